# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Methods on real floorplans and real robot maps of the same buildings, whole and in part.

Every pair is taken as it is and under random rotations, scales and connected crops. ``fpnet`` is
the whole product: scale from door widths, regions, network, consensus, raster verification and
the claim. The other matchers get the same graphs and a transform by RANSAC; ``correlative`` gets
the rasters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import time
from typing import Any

import numpy as np

from fpnet_core.baselines.correlative import search_placement
from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError
from fpnet_core.evaluation.matching import Prediction, predict_one, score
from fpnet_core.evaluation.robot_pairs import BANDS, RobotPair, read_robot_pairs, varied
from fpnet_core.geometry import Affine2D
from fpnet_core.localizer import match_maps
from fpnet_core.localizer.maps import MapMatch, MapMatchStatus
from fpnet_core.matching import RegionMatcher
from fpnet_core.metrics import placement_error
from fpnet_core.sim.labels import label_regions
from fpnet_core.sim.pairs import MatchingPair
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, GridMap

SEED = 9001
VARIANTS = 10
"""Random variants of every pair in each band."""

RIGHT_DEG = 5.0
RIGHT_SCALE = 0.1
RIGHT_DIAGONALS = 0.03
"""A transform is right within these: rotation, scale, and share of the plan's diagonal."""


@dataclass(frozen=True, eq=False)
class RobotCase:
    """One variant of a pair and the band of free space that it keeps."""

    pair: RobotPair
    band: str


@dataclass(frozen=True)
class _Outcome:
    """What one method said of one case."""

    band: str
    building: str
    is_right: bool
    is_wrong_claim: bool


def robot_cases(data: Path, split: str, limit: int | None) -> list[RobotCase]:
    """Return every pair of a half as it is and varied in each band, or ``limit`` of them."""
    pairs = read_robot_pairs(data, split)
    keys = [
        (number, band_number, variant)
        for number in range(len(pairs))
        for band_number in range(len(BANDS))
        # The pair as it is stands before the variants of the first band.
        for variant in range(-1 if band_number == 0 else 0, VARIANTS)
    ]
    if limit is not None and limit < len(keys):
        # A fixed shuffle spreads few cases over all buildings and bands.
        order = np.random.default_rng(SEED).permutation(len(keys))[:limit]
        keys = [keys[index] for index in np.sort(order)]
    return [_case(pairs[key[0]], *key) for key in keys]


def _case(pair: RobotPair, number: int, band_number: int, variant: int) -> RobotCase:
    """Return one variant of the pair ``number``; -1 is the pair as it is."""
    band, kept = list(BANDS.items())[band_number]
    if variant < 0:
        return RobotCase(pair, band)
    rng = np.random.default_rng([SEED, number, band_number, variant])
    return RobotCase(varied(pair, rng, kept), band)


def bench_robot_maps(
    cases: Sequence[RobotCase],
    matchers: Mapping[str, RegionMatcher],
    config: FpnetConfig,
    with_correlative: bool,
    on_cases: Callable[[float], None],
) -> dict[str, Any]:
    """
    Run all methods on all cases.

    Returns
    -------
    ``methods`` with the figures of :func:`fpnet_core.evaluation.matching.score` and, per band and
    per building and band, ``right``, ``wrong_and_claimed`` (shares) and ``pairs``. A map without
    rooms is a miss of every method.
    """
    if 'fpnet' not in matchers:
        raise FpnetError('the set robot needs the method fpnet, which cuts the maps into regions')
    pairs: list[MatchingPair] = []
    said: dict[str, list[Prediction]] = {name: [] for name in matchers}
    if with_correlative:
        said['correlative'] = []
    outcomes: dict[str, list[_Outcome]] = {name: [] for name in said}
    for case in cases:
        match = match_maps(
            case.pair.plan, submap_from_grid(case.pair.robot), matchers['fpnet'], config
        )
        pair = _as_pair(case.pair, match)
        if pair is not None:
            pairs.append(pair)
        for name, items in said.items():
            prediction = _predict(name, case.pair, match, pair, matchers)
            if pair is not None:
                items.append(prediction)
            outcomes[name].append(_outcome(case, match, prediction))
        on_cases(1.0)
    figures = score(pairs, said)
    methods = {
        name: {
            **figures[name],
            'bands': _bands(outcomes[name]),
            'buildings': _buildings(outcomes[name]),
        }
        for name in said
    }
    return {'methods': methods, 'pairs': len(cases)}


def _predict(
    name: str,
    pair: RobotPair,
    match: MapMatch,
    graphs: MatchingPair | None,
    matchers: Mapping[str, RegionMatcher],
) -> Prediction:
    """Return what a method says; transforms are between metres as estimated from doors."""
    if name == 'correlative':
        return _correlative(match)
    if graphs is None:
        return Prediction([], [], None, False, 0.0)
    if name != 'fpnet':
        return predict_one(
            matchers[name], graphs.plan_graph, graphs.sub_graph, graphs.explored_area_m2
        )
    estimates = match.comparison.estimates
    return Prediction(
        pairs=match.comparison.match.pairs.tolist(),
        scores=match.comparison.match.scores.tolist(),
        matrix=estimates[0].A_plan_submap.matrix.tolist() if estimates else None,
        is_claimed=match.status is MapMatchStatus.MATCHED,
        milliseconds=match.timings_ms['total'],
    )


def _correlative(match: MapMatch) -> Prediction:
    """The search has no notion of doubt: it claims whatever it finds."""
    start = time.perf_counter()
    found = search_placement(match.plan.segmentation.grid, match.sub.segmentation.grid)
    elapsed_ms = 1e3 * (time.perf_counter() - start)
    matrix = None if found is None else found.A_plan_submap.matrix.tolist()
    return Prediction([], [], matrix, found is not None, elapsed_ms)


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
    """Return the fitted transform between the metres that door widths suggest."""
    plan = match.plan.segmentation.grid.resolution / pair.plan.resolution
    robot = match.sub.segmentation.grid.resolution / pair.robot.resolution
    A = pair.A_plan_robot
    return Affine2D(A.linear * (plan / robot), A.translation * plan)


def _free_area_m2(grid: GridMap) -> float:
    return float(np.count_nonzero(grid.cells == FREE)) * grid.resolution**2


def _outcome(case: RobotCase, match: MapMatch, said: Prediction) -> _Outcome:
    """Tell whether the transform is right, and whether it is wrong but claimed."""
    pair, grid = case.pair, match.sub.segmentation.grid
    rc = np.argwhere(grid.cells == FREE).mean(axis=0)
    x, y = grid.rc_to_xy(rc).tolist()
    error = placement_error(said.placement, _truth(pair, match), (x, y))
    plan = match.plan.segmentation.grid
    limit_m = RIGHT_DIAGONALS * float(np.hypot(*plan.shape)) * plan.resolution
    right = error.is_within(limit_m, RIGHT_DEG) and error.scale <= RIGHT_SCALE
    return _Outcome(case.band, pair.building, right, said.is_claimed and not right)


def _bands(outcomes: Sequence[_Outcome]) -> dict[str, dict[str, float]]:
    bands = {}
    for band in BANDS:
        chosen = [(o.is_right, o.is_wrong_claim) for o in outcomes if o.band == band]
        right, wrong = np.mean(chosen, axis=0).tolist() if chosen else (0.0, 0.0)
        bands[band] = {'right': right, 'wrong_and_claimed': wrong, 'pairs': len(chosen)}
    return bands


def _buildings(outcomes: Sequence[_Outcome]) -> dict[str, dict[str, dict[str, float]]]:
    names = sorted({o.building for o in outcomes})
    return {name: _bands([o for o in outcomes if o.building == name]) for name in names}
