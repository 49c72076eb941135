# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Which of a library's plans may hold what was seen: words vote for plans, walls decide.

Votes are fast and name the right plan of most maps. Where no plan stands out once walls were
compared, what was seen is laid on every plan.
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
# Plans whose votes are looked at closely, in every shard and at every scale.
_LOOKED_AT = 40
# How many plans' walls are compared at least and at most, and placements of each, at several
# scales, that keypoints and that walls propose.
_FEWEST, _COMPARED, _OF_A_PLAN = 5, 40, 2
# A plan stands out that fits so many times as well as the next one, and as a keypoint whose walls
# fit perfectly.
_STANDS_OUT = 2.0
# Plans that what was seen is laid on at every shift at most, those with most votes.
_SWEPT = 1000
# Scales are tried this much apart; walls 9 m apart are then a step and a half off at most.
_SCALE_STEP = 1.06
# Share of what was seen that lies within the plan at least, by its area.
_INSIDE = 0.7

_LEADING = 0.4
"""
Walls are compared of plans that have this share of the best fit of keypoints. Fitted to the tune
half's robot maps (docs/sites.md, thousands of plans).
"""

_SPAN = 2.0 * 1.645  # given: standard deviations from end to end of an interval of 90 %


@dataclass(frozen=True)
class Known:
    """What is written of a plan."""

    path: str
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class ShardPlans:
    """A shard, and its plans in order."""

    shard: Shard
    plans: tuple[Known, ...]


@dataclass(frozen=True, eq=False)
class _Question:
    """What was seen, in metres of which one may be ``low`` to ``high`` true ones."""

    keypoints: Keypoints
    walls: GridMap
    low: float
    high: float

    @classmethod
    def of(cls, seen: Segmentation, scale: ScaleEstimate) -> _Question:
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
class _Asked:
    """
    A part's ``N`` plans at ``F`` scales: ``factors (F,)`` that enlarge what was seen.

    ``weight (F, N)`` is how likely each is, 0 where it is impossible, ``votes (F, N)`` are
    weighted so, ``fits (F, N)`` tell how well keypoints fit and ``poses (F, N, 3)`` where: yaw, x
    and y [m].
    """

    question: _Question
    part: ShardPlans
    factors: NDArray[np.float64]
    weight: NDArray[np.float64]
    votes: NDArray[np.float64]
    fits: NDArray[np.float64]
    poses: NDArray[np.float32]

    @classmethod
    def of(cls, question: _Question, part: ShardPlans) -> _Asked:
        factors, weight = _scales(question, part)
        votes, fits = np.zeros_like(weight), np.zeros_like(weight)
        poses = np.zeros((*weight.shape, 3), np.float32)
        for index, factor in enumerate(factors.tolist()):
            seen = question.keypoints.scaled(factor)
            votes[index], poses[index] = part.shard.voted(seen)
            votes[index] *= weight[index]
            for number in np.argsort(-votes[index], kind='stable')[:_LOOKED_AT].tolist():
                if votes[index, number] > 0.0:
                    partners = part.shard.partners(seen, number, poses[index, number])
                    fits[index, number] = partners * math.sqrt(votes[index, number])
        return cls(question, part, factors, weight, votes, fits, poses)

    @cached_property
    def _shifts(self) -> Shifts:
        return Shifts(self.question.walls, self.question.direction, self.factors.tolist())

    def swept(self, number: int) -> Placements:
        """Return where walls lay what was seen on a plan, at the best of two scales."""
        shard = self.part.shard
        direction = float(shard.direction[number])
        found = self._shifts.best(shard.walls_of(number), direction)
        fits = np.maximum(found.score, 0.0) * self.weight[:, number]
        best = np.argsort(-fits, kind='stable')[:_OF_A_PLAN]
        return Placements(found.linear, found.translation, fits).take(best[fits[best] > 0.0])

    def voted(self, number: int) -> Placements:
        """Return where keypoints lay what was seen on a plan, at the best of two scales."""
        own = self.fits[:, number]
        best = np.argsort(-own, kind='stable')[:_OF_A_PLAN]
        return _placements(self.poses[best, number], self.factors[best]).take(own[best] > 0.0)

    def compared(self, number: int, placements: Placements) -> float:
        """Return how well a plan fits by walls and by keypoints, at the best of placements."""
        if len(placements) == 0:
            return 0.0
        walls = self.part.shard.walls_of(number)
        fits, aligned = self.question.fitting.laid(walls, placements)
        return float((fits * self._partners(number, aligned)).max())

    def roughly(self, number: int, placements: Placements) -> float:
        """Return how well a plan fits by keypoints, and by walls as far as they were swept."""
        return float((placements.score * self._partners(number, placements)).max(initial=0.0))

    def _partners(self, number: int, placements: Placements) -> NDArray[np.float64]:
        """Count the keypoints that find a like one at ``C`` placements on a plan, ``(C,)``."""
        poses = np.column_stack([placements.heading, placements.translation]).astype(np.float32)
        found = [
            self.part.shard.partners(self.question.keypoints.scaled(each), number, pose)
            for each, pose in zip(placements.scale.tolist(), poses, strict=True)
        ]
        return np.array(found, dtype=np.float64)


_Plan = tuple[_Asked, int]


def proposed(
    parts: Iterable[ShardPlans], seen: Segmentation, scale: ScaleEstimate
) -> list[tuple[float, str]]:
    """Return how well plans fit what was seen, and their paths, best first; see the module."""
    question = _Question.of(seen, scale)
    if len(question.keypoints) < 2:
        return []
    asked = [_Asked.of(question, part) for part in parts]
    voted = {
        (each, number): fit
        for each in asked
        for number, fit in enumerate(each.fits.max(axis=0).tolist())
        if fit > 0.0
    }
    leaders = _leaders(voted)
    found = {(each, number): each.compared(number, each.voted(number)) for each, number in leaders}
    if not _stands_out(list(found.values())):
        swept = [(plan, plan[0].swept(plan[1])) for plan in _possible(asked)]
        swept.sort(key=lambda row: -row[0][0].roughly(row[0][1], row[1]))
        for (each, number), placements in swept[:_COMPARED]:
            fit = each.compared(number, placements)
            found[each, number] = max(fit, found.get((each, number), 0.0))
    # What was not compared counts as walls do that lie on walls by chance.
    final = {plan: LEAST * fit for plan, fit in voted.items()}
    final |= {plan: max(fit, final.get(plan, 0.0)) for plan, fit in found.items()}
    ranked = sorted(final.items(), key=lambda item: -item[1])
    return [(fit, each.part.plans[number].path) for (each, number), fit in ranked if fit > 0.0]


def _leaders(voted: dict[_Plan, float]) -> list[_Plan]:
    """Return the plans that keypoints fit best."""
    ranked = sorted(voted, key=lambda plan: -voted[plan])
    near = [plan for plan in ranked if voted[plan] >= _LEADING * voted[ranked[0]]]
    return ranked[: min(max(len(near), _FEWEST), _COMPARED)]


def _stands_out(fits: Sequence[float]) -> bool:
    """Tell whether one of some plans fits much better than the others."""
    best, second = sorted([*fits, 1.0, 1.0], reverse=True)[:2]
    return best >= _STANDS_OUT * second


def _possible(asked: Iterable[_Asked]) -> list[_Plan]:
    """Return the plans with most votes that may hold what was seen, those of a size together."""
    rows = [
        (float(votes), each, number)
        for each in asked
        for number, votes in enumerate(each.votes.max(axis=0))
        if each.weight[:, number].any()
    ]
    rows.sort(key=lambda row: -row[0])
    plans = [(each, number) for _, each, number in rows[:_SWEPT]]
    return sorted(plans, key=lambda plan: tuple(plan[0].part.shard.shape[plan[1]].tolist()))


def _scales(
    question: _Question, part: ShardPlans
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Return the scales to be tried ``(F,)``, and how likely each is for each plan ``(F, N)``.

    Both sides' intervals are as if of independent errors. The plan may be too large, or what was
    seen too small; what lies outside of a plan by its area alone is impossible.
    """
    plans = np.log([(plan.low, plan.high) for plan in part.plans])
    own = np.log([question.low, question.high])
    middle = own.mean() - plans.mean(axis=1)
    span = np.hypot(np.ptp(own), np.ptp(plans, axis=1))
    first, last = (middle - span / 2.0).min(), (middle + span / 2.0).max()
    steps = math.ceil((last - first) / math.log(_SCALE_STEP) - 1e-9)
    scales = np.linspace(first, last, steps + 1) if steps else np.array([first])
    off = np.abs(scales[:, None] - middle)
    slack = math.log(_SCALE_STEP) / 2.0
    floor = area_of(question.walls) * np.exp(2.0 * scales)
    is_possible = (off <= span / 2.0 + slack) & (_INSIDE * floor[:, None] <= part.shard.area)
    sigma = np.maximum(span / _SPAN, slack)
    return np.exp(scales), np.where(is_possible, np.exp(-0.5 * np.square(off / sigma)), 0.0)


def _placements(poses: NDArray[np.float32], factors: NDArray[np.float64]) -> Placements:
    placed = poses.astype(np.float64)
    return Placements(factors[:, None, None] * rotation(placed[:, 0]), placed[:, 1:])
