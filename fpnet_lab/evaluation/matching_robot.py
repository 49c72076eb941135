# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Evaluation of methods on real floorplans and real robot maps of the same buildings.

Every pair is used unchanged and under random rotations, scales and connected crops; a stated scale
is kept. Every robot map is also matched with plans of other buildings, where every placement is
wrong. ``fpnet`` is the complete pipeline: scale from door widths unless stated, regions, network,
consensus, raster verification and acceptance. The other matchers get the same graphs and a
transform by RANSAC; those of :mod:`fpnet_lab.evaluation.raster_methods` get the rasters.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
import time
from typing import Any, NamedTuple

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D
from fpnet_core.localizer.global_localizer import GlobalLocalizer
from fpnet_core.localizer.maps import (
    MapMatch,
    MapMatchStatus,
    SegmentedMap,
    match_segmented,
    segment_plan,
    segment_robot_map,
)
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.matching import RegionMatcher
from fpnet_core.scoring import PlacementScorer
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, GridMap
from fpnet_lab.evaluation.matching import Prediction, predict_one, score
from fpnet_lab.evaluation.pair_sets import SEED
from fpnet_lab.evaluation.raster_methods import CLAIMS_ALL, RASTER_METHODS, predict_by_raster
from fpnet_lab.evaluation.robots.robot_figures import Foreign, Outcome, robot_figures
from fpnet_lab.evaluation.robots.robot_pairs import (
    BANDS,
    WHOLE,
    BuildingFloorplan,
    RobotPair,
    foreign_drawings,
    read_drawings,
    read_robot_pairs,
    varied,
)
from fpnet_lab.metrics import placement_error
from fpnet_lab.sim.pairs.labels import label_regions
from fpnet_lab.sim.pairs.pair import MatchingPair

VARIANTS = 10
"""Random variants of every pair in each band. Chosen."""

_FOREIGN_STREAM = 1  # given: random stream of the choice of plans, separate from that of crops


@dataclass(frozen=True, eq=False)
class RobotCase:
    """One variant of a pair, its band, and the plans of other buildings to match it with."""

    pair: RobotPair
    band: str
    foreign: tuple[BuildingFloorplan, ...] = ()


class _Key(NamedTuple):
    """Key of a case: index of the pair, of the band (-1: unchanged), and of the variant."""

    pair: int
    band: int
    variant: int


@dataclass(frozen=True, eq=False)
class _TimedCut:
    cut: SegmentedMap
    milliseconds: float


def robot_cases(data: Path, split: str, limit: int | None, foreign: int = 3) -> list[RobotCase]:
    """
    Return every pair of a split, unchanged and varied in each band, or ``limit`` of them.

    Each case has ``foreign`` plans of other buildings of the same split.
    """
    pairs = read_robot_pairs(data, split)
    drawings = read_drawings(data, split, pairs)
    keys = [_Key(number, -1, 0) for number in range(len(pairs))]
    keys += [
        _Key(number, band, variant)
        for number in range(len(pairs))
        for band in range(len(BANDS))
        for variant in range(VARIANTS)
    ]
    chosen = keys if limit is None else _shuffled_keys(keys, limit)
    return [_case(pairs[key.pair], key, drawings, foreign) for key in sorted(chosen)]


def _shuffled_keys(keys: Sequence[_Key], limit: int) -> list[_Key]:
    """Return ``limit`` keys: a fixed shuffle over the buildings that alternates the bands."""
    shuffled = [keys[index] for index in np.random.default_rng(SEED).permutation(len(keys))]
    taken: Counter[int] = Counter()
    rounds: list[tuple[int, _Key]] = []
    for key in shuffled:
        rounds.append((taken[key.band], key))
        taken[key.band] += 1
    return [key for _, key in sorted(rounds, key=lambda item: item[0])[:limit]]


def _case(
    pair: RobotPair, key: _Key, drawings: Sequence[BuildingFloorplan], foreign: int
) -> RobotCase:
    """Return the variant of a pair for a key."""
    choice = np.random.default_rng([SEED, *(key.pair, key.band + 1, key.variant), _FOREIGN_STREAM])
    others = foreign_drawings(pair.drawing, drawings, choice, foreign)
    if key.band < 0:
        return RobotCase(pair, WHOLE, others)
    band, kept = list(BANDS.items())[key.band]
    return RobotCase(varied(pair, np.random.default_rng([SEED, *key]), kept), band, others)


def bench_robot_maps(
    cases: Sequence[RobotCase],
    matchers: Mapping[str, RegionMatcher],
    config: FpnetConfig,
    rasters: Sequence[str],
    on_cases: Callable[[float], None],
) -> dict[str, Any]:
    """
    Run all methods on all cases.

    Returns
    -------
    ``methods`` with the figures of :func:`fpnet_lab.evaluation.matching.score` and of
    :func:`fpnet_lab.evaluation.robots.robot_figures.robot_figures`. A map without rooms is a miss
    of every method. ``correlative`` accepts everything and skips the plans of other buildings.
    """
    if 'fpnet' not in matchers:
        raise FpnetError('the set robot needs the method fpnet, which segments the maps')
    if cases:  # compiles and fills caches before the first timed case
        _Bench(matchers, config, ()).run(replace(cases[0], foreign=()))
    bench = _Bench(matchers, config, rasters)
    for case in cases:
        bench.run(case)
        on_cases(1.0)
    figures = score(bench.pairs, bench.said)
    methods = {
        name: {**figures[name], **robot_figures(outcomes)}
        for name, outcomes in bench.outcomes.items()
    }
    return {'methods': methods, 'pairs': len(cases)}


class _Bench:
    """Runs methods on cases; every plan is segmented into rooms once."""

    def __init__(
        self, matchers: Mapping[str, RegionMatcher], config: FpnetConfig, rasters: Sequence[str]
    ) -> None:
        names = [*matchers, *rasters]
        self.pairs: list[MatchingPair] = []
        self.said: dict[str, list[Prediction]] = {name: [] for name in names}
        self.outcomes: dict[str, list[Outcome]] = {name: [] for name in names}
        self._matchers = matchers
        self._config = config
        self._global_localizer = GlobalLocalizer(
            matchers['fpnet'], PlacementScorer.configured(config.localizer), config
        )
        self._plans: dict[str, _TimedCut] = {}

    def run(self, case: RobotCase) -> None:
        """Run all methods on one case, on the correct plan and on those of other buildings."""
        robot = _timed(
            lambda: segment_robot_map(
                submap_from_grid(case.pair.robot), self._config, case.pair.is_metric
            )
        )
        foreign = self._foreign(case, robot)
        match = self._match(case.pair.drawing, robot)
        pair = _as_pair(case.pair, match)
        if pair is not None:
            self.pairs.append(pair)
        for name, items in self.said.items():
            said = _predict(name, match, self._matchers)
            if pair is not None:
                items.append(said)
            self.outcomes[name].append(_outcome(case, match, said, tuple(foreign[name])))

    def _foreign(self, case: RobotCase, robot: _TimedCut) -> dict[str, list[Foreign]]:
        """Return the results of each method on the plans of other buildings."""
        found: dict[str, list[Foreign]] = {name: [] for name in self.said}
        for drawing in case.foreign:
            match = self._match(drawing, robot)
            is_same_architect = drawing.architect == case.pair.architect
            for name in found.keys() - {CLAIMS_ALL}:
                said = _predict(name, match, self._matchers)
                found[name].append(Foreign(is_same_architect, said.is_accepted))
        return found

    def _match(self, drawing: BuildingFloorplan, robot: _TimedCut) -> MapMatch:
        """Return the result of ``fpnet match``; its total time includes segmenting both maps."""
        if drawing.building not in self._plans:
            self._plans[drawing.building] = _timed(
                lambda: segment_plan(drawing.grid, self._config, drawing.is_metric)
            )
        plan, timer = self._plans[drawing.building], StageTimer()
        timer.timings_ms['total'] = plan.milliseconds + robot.milliseconds
        with timer.stage('total'):
            return match_segmented(plan.cut, robot.cut, self._global_localizer, timer)


def _timed(cut: Callable[[], SegmentedMap]) -> _TimedCut:
    start = time.perf_counter()
    made = cut()
    return _TimedCut(made, 1e3 * (time.perf_counter() - start))


def _predict(name: str, match: MapMatch, matchers: Mapping[str, RegionMatcher]) -> Prediction:
    """Return a method's prediction; transforms are in metres, stated or estimated from doors."""
    if name in RASTER_METHODS:
        return predict_by_raster(name, match)
    if not (match.plan.segmentation.regions and match.sub.segmentation.regions):
        return Prediction([], [], None, False, 0.0)
    if name != 'fpnet':
        area_m2 = _free_area_m2(match.sub.segmentation.grid)
        return predict_one(matchers[name], match.plan.graph, match.sub.graph, area_m2)
    estimates = match.candidates.estimates
    return Prediction(
        pairs=match.candidates.match.pairs.tolist(),
        scores=match.candidates.match.scores.tolist(),
        matrix=estimates[0].A_plan_submap.matrix.tolist() if estimates else None,
        is_accepted=match.status is MapMatchStatus.MATCHED,
        milliseconds=match.timings_ms['total'],
    )


def _as_pair(pair: RobotPair, match: MapMatch) -> MatchingPair | None:
    """Return both graphs with labels from the fitted transform; None without regions."""
    plan, sub = match.plan.segmentation, match.sub.segmentation
    if not (plan.regions and sub.regions):
        return None
    truth = _truth(pair, match)
    return MatchingPair(
        plan_graph=match.plan.graph,
        sub_graph=match.sub.graph,
        sub_labels=label_regions(plan, sub, truth).labels,
        A_plan_submap=truth,
        explored_area_m2=_free_area_m2(sub.grid),
        plan_id=0,
        family=pair.name,
    )


def _truth(pair: RobotPair, match: MapMatch) -> Affine2D:
    """Return the fitted transform in the metres of both segmented maps."""
    plan = match.plan.segmentation.grid.resolution / pair.plan.resolution
    robot = match.sub.segmentation.grid.resolution / pair.robot.resolution
    A = pair.A_plan_robot
    return Affine2D(A.linear * (plan / robot), A.translation * plan)


def _free_area_m2(grid: GridMap) -> float:
    return float(np.count_nonzero(grid.cells == FREE)) * grid.resolution**2


def _outcome(
    case: RobotCase, match: MapMatch, said: Prediction, foreign: tuple[Foreign, ...]
) -> Outcome:
    """Return whether the transform is right and whether it is accepted."""
    pair, grid = case.pair, match.sub.segmentation.grid
    rc = np.argwhere(grid.cells == FREE).mean(axis=0)
    x, y = grid.rc_to_xy(rc).tolist()
    error = placement_error(said.placement, _truth(pair, match), (x, y))
    plan = match.plan.segmentation.grid
    right = error.is_right(float(np.hypot(*plan.shape)) * plan.resolution)
    return Outcome(case.band, pair.building, pair.is_distorted, right, said.is_accepted, foreign)
