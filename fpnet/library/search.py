# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Search of the plans that may contain a robot map: words vote for plans, walls decide.

Voting is fast and finds the right plan for most maps. If no plan stands out after the comparison
of walls, the map's walls are correlated with those of every plan.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
import math

import numpy as np
from numpy.typing import NDArray

from fpnet.library.keypoints import Keypoints, keypoints_of
from fpnet.library.shard import Shard
from fpnet.library.shifts import Shifts
from fpnet.library.walls import LEAST, SeenWalls, area_of, direction_of, seen_walls
from fpnet_core.geometry import Placements, rotation
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.types import GridMap, Segmentation

# Chosen, not measured:
# Plans with most votes whose keypoints are compared, per shard and scale.
_LOOKED_AT = 40
# Least and largest number of plans whose walls are compared, and placements of each, at several
# scales, from keypoints and from walls.
_FEWEST, _COMPARED, _OF_A_PLAN = 5, 40, 2
# A plan stands out if its fit is this many times that of the next one, and that of a single
# keypoint with a perfect fit of walls.
_STANDS_OUT = 2.0
# Largest number of plans, those with most votes, on which all shifts are tried.
_SWEPT = 1000
# Ratio of successive scales; 9 m between walls are then off by one and a half bins at most.
_SCALE_STEP = 1.06
# Least share of the observed area that must fit into the plan's area.
_INSIDE = 0.7

_LEADING = 0.4
"""
Walls are compared for plans with this share of the best fit of keypoints. Fitted to the robot
maps of the development split (docs/sites.md, thousands of plans).
"""

_SPAN = 2.0 * 1.645  # given: width of a 90 % interval in standard deviations


@dataclass(frozen=True)
class Known:
    """Path and relative scale interval of a plan, as stored."""

    path: str
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class ShardPlans:
    """A shard and its plans, in the same order."""

    shard: Shard
    plans: tuple[Known, ...]


@dataclass(frozen=True, eq=False)
class _MapQuery:
    """A robot map as a query; one of its metres is ``low`` to ``high`` true metres."""

    keypoints: Keypoints
    walls: GridMap
    low: float
    high: float

    @classmethod
    def of(cls, seen: Segmentation, scale: ScaleEstimate) -> _MapQuery:
        factor = scale.factor
        low, high = scale.low / factor, scale.high / factor
        return cls(keypoints_of(seen, factor), seen_walls(seen, factor), low, high)

    @cached_property
    def fitting(self) -> SeenWalls:
        return SeenWalls.of(self.walls)

    @cached_property
    def direction(self) -> float:
        return direction_of(self.walls)


@dataclass(frozen=True, eq=False)
class _ShardQuery:
    """
    A shard's ``N`` plans at ``F`` scales: ``factors (F,)`` that enlarge the robot map.

    ``weight (F, N)`` is the likelihood of each scale, 0 if impossible; ``votes (F, N)`` include
    it; ``fits (F, N)`` are the fits of keypoints at ``poses (F, N, 3)``: yaw, x and y [m].
    """

    query: _MapQuery
    part: ShardPlans
    factors: NDArray[np.float64]
    weight: NDArray[np.float64]
    votes: NDArray[np.float64]
    fits: NDArray[np.float64]
    poses: NDArray[np.float32]

    @classmethod
    def of(cls, query: _MapQuery, part: ShardPlans) -> _ShardQuery:
        factors, weight = _scales(query, part)
        votes, fits = np.zeros_like(weight), np.zeros_like(weight)
        poses = np.zeros((*weight.shape, 3), np.float32)
        for index, factor in enumerate(factors.tolist()):
            seen = query.keypoints.scaled(factor)
            votes[index], poses[index] = part.shard.voted(seen)
            votes[index] *= weight[index]
            for number in np.argsort(-votes[index], kind='stable')[:_LOOKED_AT].tolist():
                if votes[index, number] > 0.0:
                    partners = part.shard.partners(seen, number, poses[index, number])
                    fits[index, number] = partners * math.sqrt(votes[index, number])
        return cls(query, part, factors, weight, votes, fits, poses)

    @cached_property
    def _shifts(self) -> Shifts:
        return Shifts(self.query.walls, self.query.direction, self.factors.tolist())

    def swept(self, number: int) -> Placements:
        """Return the placements on a plan by correlation of walls, at the two best scales."""
        shard = self.part.shard
        direction = float(shard.direction[number])
        found = self._shifts.best(shard.walls_of(number), direction)
        fits = np.maximum(found.score, 0.0) * self.weight[:, number]
        best = np.argsort(-fits, kind='stable')[:_OF_A_PLAN]
        return Placements(found.linear, found.translation, fits).take(best[fits[best] > 0.0])

    def voted(self, number: int) -> Placements:
        """Return the placements on a plan by keypoints, at the two best scales."""
        own = self.fits[:, number]
        best = np.argsort(-own, kind='stable')[:_OF_A_PLAN]
        return _placements(self.poses[best, number], self.factors[best]).take(own[best] > 0.0)

    def compared(self, number: int, placements: Placements) -> float:
        """Return the fit of a plan by walls and keypoints, at the best of some placements."""
        if len(placements) == 0:
            return 0.0
        walls = self.part.shard.walls_of(number)
        fits, aligned = self.query.fitting.laid(walls, placements)
        return float((fits * self._partners(number, aligned)).max())

    def roughly(self, number: int, placements: Placements) -> float:
        """Return the fit of a plan by keypoints and by the scores of :meth:`swept`."""
        return float((placements.score * self._partners(number, placements)).max(initial=0.0))

    def _partners(self, number: int, placements: Placements) -> NDArray[np.float64]:
        """Return the weighted number of partners at ``C`` placements on a plan, ``(C,)``."""
        poses = np.column_stack([placements.heading, placements.translation]).astype(np.float32)
        found = [
            self.part.shard.partners(self.query.keypoints.scaled(each), number, pose)
            for each, pose in zip(placements.scale.tolist(), poses, strict=True)
        ]
        return np.array(found, dtype=np.float64)


_Plan = tuple[_ShardQuery, int]


def proposed(
    parts: Iterable[ShardPlans], seen: Segmentation, scale: ScaleEstimate
) -> list[tuple[float, str]]:
    """Return fits and paths of plans for a robot map, best first; see the module."""
    query = _MapQuery.of(seen, scale)
    if len(query.keypoints) < 2:
        return []
    queries = [_ShardQuery.of(query, part) for part in parts]
    voted = {
        (each, number): fit
        for each in queries
        for number, fit in enumerate(each.fits.max(axis=0).tolist())
        if fit > 0.0
    }
    leaders = _leaders(voted)
    found = {(each, number): each.compared(number, each.voted(number)) for each, number in leaders}
    if not _stands_out(list(found.values())):
        swept = [(plan, plan[0].swept(plan[1])) for plan in _possible(queries)]
        swept.sort(key=lambda row: -row[0][0].roughly(row[0][1], row[1]))
        for (each, number), placements in swept[:_COMPARED]:
            fit = each.compared(number, placements)
            found[each, number] = max(fit, found.get((each, number), 0.0))
    # Plans without a comparison of walls get the fit of a chance overlap.
    final = {plan: LEAST * fit for plan, fit in voted.items()}
    final |= {plan: max(fit, final.get(plan, 0.0)) for plan, fit in found.items()}
    ranked = sorted(final.items(), key=lambda item: -item[1])
    return [(fit, each.part.plans[number].path) for (each, number), fit in ranked if fit > 0.0]


def _leaders(voted: dict[_Plan, float]) -> list[_Plan]:
    """Return the plans with the best fit of keypoints."""
    ranked = sorted(voted, key=lambda plan: -voted[plan])
    near = [plan for plan in ranked if voted[plan] >= _LEADING * voted[ranked[0]]]
    return ranked[: min(max(len(near), _FEWEST), _COMPARED)]


def _stands_out(fits: Sequence[float]) -> bool:
    """Return whether one plan fits much better than the others."""
    best, second = sorted([*fits, 1.0, 1.0], reverse=True)[:2]
    return best >= _STANDS_OUT * second


def _possible(queries: Iterable[_ShardQuery]) -> list[_Plan]:
    """Return the plans with most votes that may contain the map, sorted by raster size."""
    rows = [
        (float(votes), each, number)
        for each in queries
        for number, votes in enumerate(each.votes.max(axis=0))
        if each.weight[:, number].any()
    ]
    rows.sort(key=lambda row: -row[0])
    plans = [(each, number) for _, each, number in rows[:_SWEPT]]
    return sorted(plans, key=lambda plan: tuple(plan[0].part.shard.shape[plan[1]].tolist()))


def _scales(query: _MapQuery, part: ShardPlans) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Return the scales to try ``(F,)``, and the likelihood of each for each plan ``(F, N)``.

    The intervals of map and plan are combined as independent errors. A scale is impossible for a
    plan whose area is too small for the map.
    """
    plans = np.log([(plan.low, plan.high) for plan in part.plans])
    own = np.log([query.low, query.high])
    middle = own.mean() - plans.mean(axis=1)
    span = np.hypot(np.ptp(own), np.ptp(plans, axis=1))
    first, last = (middle - span / 2.0).min(), (middle + span / 2.0).max()
    steps = math.ceil((last - first) / math.log(_SCALE_STEP) - 1e-9)
    scales = np.linspace(first, last, steps + 1) if steps else np.array([first])
    off = np.abs(scales[:, None] - middle)
    slack = math.log(_SCALE_STEP) / 2.0
    floor = area_of(query.walls) * np.exp(2.0 * scales)
    is_possible = (off <= span / 2.0 + slack) & (_INSIDE * floor[:, None] <= part.shard.area)
    sigma = np.maximum(span / _SPAN, slack)
    return np.exp(scales), np.where(is_possible, np.exp(-0.5 * np.square(off / sigma)), 0.0)


def _placements(poses: NDArray[np.float32], factors: NDArray[np.float64]) -> Placements:
    placed = poses.astype(np.float64)
    return Placements(factors[:, None, None] * rotation(placed[:, 0]), placed[:, 1:])
