# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Training data of the placement scorer: robot maps on correct plans and on other buildings' plans.

There are four kinds of maps, none from a building of the test split: real robot maps of the
development split; its drawings, some furnished, converted to robot maps; real maps of homes and
offices without any plan; and maps of generated buildings. Each is cropped, rotated, and rescaled
unless its scale counts as known. Each is matched with its own plan, some of them roughened, and
with plans of other buildings, some by the same architect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D, Placements, angle_between
from fpnet_core.io.maps import read_map
from fpnet_core.localizer.global_localizer import Candidates, GlobalLocalizer
from fpnet_core.localizer.maps import (
    ScaledPair,
    SegmentedMap,
    scaled_pair,
    segment_plan,
    segment_robot_map,
)
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.matching import RegionMatcher
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.scoring import CONTEXT, FIGURES, Evidence, PlacementModel, PlacementScorer
from fpnet_core.segmentation.moved import rescaled
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import GridMap, Submap
from fpnet_lab.evaluation.robots.robot_pairs import RobotPair, read_robot_pairs, varied
from fpnet_lab.metrics.placement import RIGHT_DEG, RIGHT_DIAGONALS, RIGHT_SCALE
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.drawn.distort import rough_drawing
from fpnet_lab.sim.drawn.rough import robot_map_of
from fpnet_lab.sim.pairs.pair import generate_mapped_pair
from fpnet_lab.sim.population.floors import TUNE_FLOORS

Array = NDArray[np.float64]
Displaced = Callable[[Array], Array]

KINDS = ('real', 'drawn', 'foreign', 'generated')

_SHARES = ((0.9, 1.0), (0.5, 1.0), (0.35, 0.5), (0.2, 0.35), (0.1, 0.2), (0.05, 0.1))
_SHARE_WEIGHTS = (0.08, 0.2, 0.12, 0.25, 0.27, 0.08)
"""
Ranges of the share of free space kept by crops, and their frequencies: explored areas, early ones
too. Chosen.
"""

_METRIC = {'real': 0.3, 'drawn': 0.5, 'foreign': 0.3, 'generated': 0.75}
"""
Share of the cases of each kind with a stated scale; robot maps are metric. Chosen.
"""

_ROUGH = {'real': 0.25, 'drawn': 1.0, 'generated': 0.4}
"""Share of correct plans to roughen; a drawing fits a copy of itself perfectly. Chosen."""

BLOCK_CASES = 25
"""Numerical: consecutive cases that one task computes."""

# Chosen, not measured:
_OTHERS = 2  # plans of other buildings per map
_GENERATED_OTHERS = 0.5  # share of the maps of real buildings with one generated plan
_GENERATED_PLANS, _PLAN_SEED = 36, 991  # numerical
_TOLERATED_SCALE = 0.09  # larger log scale errors are reduced if the scale counts as stated
_STATED_ERROR = 0.05  # largest log error of a stated scale

RIGHT_LEAST_M, RIGHT_MEDIAN_M = 0.9, 1.0
"""
Limits of a right placement, in addition to those of ``fpnet bench matching``: the error at the
centre may be up to the first on small plans; or most of the map is displaced by less than the
second, as drawings have local errors of over 10 %. Around a robot the second is the limit. Chosen.
"""


@dataclass(frozen=True, eq=False)
class Trial:
    """
    One match of a map with a plan: evidence for ``C`` placements and the ``right (C,)`` ones.

    ``is_own`` marks the plan of the map's own building; ``kind`` and ``building`` are those of the
    map, ``kept`` is the remaining share of its free space, NaN if it was not cropped.
    """

    evidence: Evidence
    right: NDArray[np.bool_]
    is_own: bool
    kind: str
    building: str
    kept: float = np.nan


Trials = tuple[Trial, ...]
COLUMNS = (*FIGURES, *CONTEXT)
"""Columns of the evidence of cached trials."""


@dataclass(frozen=True, eq=False)
class _Case:
    """A map, and the positions (P, 2) of its points on its ``plan``; None for maps without one."""

    submap: Submap
    is_metric: bool
    building: str
    plan: GridMap | None
    displaced: Displaced
    robot_xy: Array | None = None
    kept: float = np.nan


class TrialSource:
    """
    Generates the trials of one kind.

    All kinds except ``generated`` need ``data``; ``real`` takes the pairs of one split, ``half``.
    Plans of the test split are not roughened.

    Raises
    ------
    FpnetError
        If the shared data is missing or incomplete.
    """

    def __init__(
        self,
        kind: str,
        seed: int,
        data: Path | None,
        config: FpnetConfig,
        matcher: RegionMatcher,
        half: str = 'tune',
    ) -> None:
        self._kind, self._seed, self._data, self._half = kind, seed, data, half
        self._config = config
        self._global_localizer = GlobalLocalizer(
            matcher, PlacementScorer(PlacementModel.indifferent(), 0.5), config
        )
        self._pairs = read_robot_pairs(data, half) if data is not None else ()
        self._plans: dict[str, GridMap] = {pair.building: pair.plan for pair in self._pairs}
        if data is not None and half == 'tune':
            self._plans |= {name: read_map(_floorplan(data, name)) for name in TUNE_FLOORS}
        self._generated: list[GridMap] = []
        self._unpaired: list[Path] = []
        if kind == 'foreign':
            assert data is not None  # optional for generated buildings only
            self._unpaired = sorted((data / 'declutter' / 'maps').glob('*.png'))
            if not self._unpaired:
                raise FpnetError(f'{data / "declutter" / "maps"} holds no maps')
        self._cut: dict[tuple[str, bool], SegmentedMap] = {}
        self._neighbours: dict[str, list[tuple[str, GridMap]]] = {}

    def block(self, number: int) -> list[Trial]:
        """Return the trials of :data:`BLOCK_CASES` consecutive cases; deterministic."""
        self._neighbours.clear()
        first = number * BLOCK_CASES
        return [t for index in range(first, first + BLOCK_CASES) for t in self.trials(index)]

    def trials(self, index: int) -> Iterator[Trial]:
        """Yield the trials of one case; earlier generated plans of the block serve as others."""
        rng = np.random.default_rng([self._seed, KINDS.index(self._kind), index])
        case = self._case(index, rng)
        robot = segment_robot_map(case.submap, self._config, case.is_metric)
        if case.plan is not None:
            own = segment_plan(case.plan, self._config, case.is_metric)
            yield from self._met(case, robot, own, case.plan)
        for name, grid in self._others(case, rng):
            yield from self._met(case, robot, self._cut_once(name, grid, case.is_metric), None)

    def _met(
        self, case: _Case, robot: SegmentedMap, plan: SegmentedMap, own: GridMap | None
    ) -> Iterator[Trial]:
        """Yield the trial of a search, if the search has any result."""
        pair = scaled_pair(plan, robot, self._global_localizer.config)
        if case.is_metric:
            pair = replace(pair, robot_xy=case.robot_xy)
        found = self._global_localizer.find(pair, StageTimer())
        if len(found.estimates):
            right = np.zeros(len(found.estimates), dtype=np.bool_)
            if own is not None:
                right = _right(found, case, own, pair)
            evidence, is_own = found.posterior.evidence.figures_only, own is not None
            yield Trial(evidence, right, is_own, self._kind, case.building, case.kept)

    def _case(self, index: int, rng: np.random.Generator) -> _Case:
        share = _SHARES[int(rng.choice(len(_SHARES), p=_SHARE_WEIGHTS))]
        is_metric = bool(rng.random() < _METRIC[self._kind])
        if self._kind == 'generated':
            return self._generated_case(index, is_metric, rng)
        pair = self._pair(index, rng)
        if is_metric:
            pair = _nearly_metric(pair, rng)
        cut = varied(replace(pair, is_metric=is_metric), rng, share)
        plan, displaced = cut.plan, _by(cut.A_plan_robot)
        if self._half == 'tune' and rng.random() < _ROUGH.get(self._kind, 0.0):
            rough = rough_drawing(plan, rng)
            plan, displaced = rough.grid, _after(rough.displaced, cut.A_plan_robot)
        is_foreign = self._kind == 'foreign'
        return _Case(
            submap_from_grid(cut.robot),
            is_metric,
            cut.building,
            None if is_foreign else plan,
            displaced,
            kept=cut.kept,
        )

    def _pair(self, index: int, rng: np.random.Generator) -> RobotPair:
        if self._kind == 'real':
            return self._pairs[index % len(self._pairs)]
        if self._kind == 'foreign':
            path = self._unpaired[index % len(self._unpaired)]
            return RobotPair(path.stem, self._pairs[0].plan, read_map(path), Affine2D.identity())
        assert self._data is not None  # optional for generated buildings only
        name = TUNE_FLOORS[index % len(TUNE_FLOORS)]
        furnished = sorted((self._data / 'bormann' / 'furnished').glob(f'{name}*.png'))
        drawn = [*furnished, _floorplan(self._data, name)]
        robot = robot_map_of(read_map(drawn[int(rng.integers(len(drawn)))]), rng)
        plan = self._plans[name]
        A_plan_robot = pixel_to_xy(plan) @ pixel_to_xy(robot).inv()
        return RobotPair(name, plan, robot, A_plan_robot, building=name)

    def _generated_case(self, index: int, is_metric: bool, rng: np.random.Generator) -> _Case:
        sim = SimConfig()
        mapped = generate_mapped_pair(self._seed, index * sim.pairs_per_plan, sim)
        grid, A = mapped.plan_segmentation.grid, mapped.pair.A_plan_submap
        displaced = _by(A)
        if rng.random() < _ROUGH['generated']:
            rough = rough_drawing(grid, rng)
            grid, displaced = rough.grid, _after(rough.displaced, A)
        name = f'{mapped.pair.family}-{index}'
        return _Case(
            mapped.submap, is_metric, name, grid, displaced, np.array(mapped.submap.path_xy[-1])
        )

    def _others(self, case: _Case, rng: np.random.Generator) -> Iterator[tuple[str, GridMap]]:
        """Yield plans of other buildings."""
        if self._kind == 'generated':
            yield from self._other_generated(case, rng)
            return
        names = [name for name in sorted(self._plans) if name != case.building]
        count = _OTHERS
        if rng.random() < _GENERATED_OTHERS:
            number = int(rng.integers(_GENERATED_PLANS))
            yield f'generated {number}', self._generated_plan(number)
            count -= 1
        for pick in rng.choice(len(names), count, replace=False).tolist():
            yield names[pick], self._plans[names[pick]]

    def _other_generated(
        self, case: _Case, rng: np.random.Generator
    ) -> Iterator[tuple[str, GridMap]]:
        """Yield the latest plan by the same architect, and one of another family."""
        family = case.building.rsplit('-', 1)[0]
        same = self._neighbours.get(family, [])
        rest = [
            plan for name, plans in self._neighbours.items() if name != family for plan in plans
        ]
        yield from same[-1:]
        if rest:
            yield rest[int(rng.integers(len(rest)))]
        assert case.plan is not None  # all generated buildings have a plan
        self._neighbours[family] = [(case.building, case.plan)]

    def _generated_plan(self, number: int) -> GridMap:
        while len(self._generated) <= number:
            sim = SimConfig()
            mapped = generate_mapped_pair(
                _PLAN_SEED, len(self._generated) * sim.pairs_per_plan, sim
            )
            self._generated.append(mapped.plan_segmentation.grid)
        return self._generated[number]

    def _cut_once(self, name: str, grid: GridMap, is_metric: bool) -> SegmentedMap:
        key = (name, is_metric)
        if key not in self._cut:
            self._cut[key] = segment_plan(grid, self._config, is_metric)
        return self._cut[key]


def right_placements(
    placed: Placements, points: Array, truth: Array, diagonal_m: float
) -> NDArray[np.bool_]:
    """Return which placements map ``points (P, 2)`` near ``truth (P, 2)`` on the plan."""
    there = placed.apply(points)
    moved = np.median(np.linalg.norm(there - truth, axis=2), axis=1)
    middle = np.linalg.norm(there.mean(axis=1) - truth.mean(axis=0), axis=1)
    best = Affine2D.from_matrix(_fitted(points, truth))
    turn = np.rad2deg(angle_between(placed.heading, best.heading))
    scale = np.abs(placed.scale / best.scale - 1.0)
    limit_m = max(RIGHT_DIAGONALS * diagonal_m, RIGHT_LEAST_M)
    is_near = (middle < limit_m) & (scale < RIGHT_SCALE)
    is_same = (moved < RIGHT_MEDIAN_M) & (middle < RIGHT_MEDIAN_M)
    return np.asarray((is_near | is_same) & (turn < RIGHT_DEG))


def _right(found: Candidates, case: _Case, own: GridMap, pair: ScaledPair) -> NDArray[np.bool_]:
    """Return which placements on the correct plan are right."""
    if case.robot_xy is not None and case.is_metric:
        return _right_at(found, case)
    free = pair.sub.evidence.free
    truth = case.displaced(free / pair.sub_factor) * pair.plan_factor
    diagonal_m = float(np.hypot(*own.shape)) * own.resolution * pair.plan_factor
    return right_placements(found.estimates, free, truth, diagonal_m)


def _right_at(found: Candidates, case: _Case) -> NDArray[np.bool_]:
    """Return which placements give the right robot pose."""
    assert case.robot_xy is not None  # checked by the caller
    here = case.robot_xy[None]
    error_m = np.linalg.norm(found.estimates.apply(here)[:, 0] - case.displaced(here)[0], axis=1)
    ahead = here + np.array([[1.0, 0.0]])
    true = (case.displaced(ahead) - case.displaced(here))[0]
    moved = found.estimates.linear[:, :, 0]
    turn = np.angle((moved @ [1.0, 1j]) / (true @ [1.0, 1j]))
    return np.asarray((error_m < RIGHT_MEDIAN_M) & (np.abs(np.rad2deg(turn)) < 2.0 * RIGHT_DEG))


def _fitted(points: Array, truth: Array) -> Array:
    """Return the affine map ``(2, 3)`` from ``points`` to ``truth``, by least squares."""
    inputs = np.column_stack([points, np.ones(len(points))])
    return np.asarray(np.linalg.lstsq(inputs, truth, rcond=None)[0].T)


def _nearly_metric(pair: RobotPair, rng: np.random.Generator) -> RobotPair:
    """Return a pair whose robot map has the plan's scale, up to the error of a stated one."""
    scale = pair.A_plan_robot.scale
    if abs(np.log(scale)) <= _TOLERATED_SCALE:
        return pair
    factor = scale * float(np.exp(rng.uniform(-_STATED_ERROR, _STATED_ERROR)))
    smaller = Affine2D(np.eye(2) / factor, np.zeros(2))
    robot = rescaled(pair.robot, factor)
    return replace(pair, robot=robot, A_plan_robot=pair.A_plan_robot @ smaller)


def _by(A: Affine2D) -> Displaced:
    return A.apply


def _after(displaced: Displaced, A: Affine2D) -> Displaced:
    return lambda xy: displaced(A.apply(xy))


def _floorplan(data: Path, name: str) -> Path:
    return data / 'bormann' / 'floorplan' / f'{name}.png'
