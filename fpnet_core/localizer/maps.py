# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Match two whole maps of unknown relative scale, rotation and translation, once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import Affine2D
from fpnet_core.localizer.belief import posterior
from fpnet_core.localizer.scale import door_scale_search
from fpnet_core.localizer.sides import (
    Comparison,
    MapSide,
    StageTimer,
    compare,
    prepare_plan,
    prepare_submap,
    rescaled,
)
from fpnet_core.matching import RegionMatcher
from fpnet_core.segmentation import SubmapSegmenter, segment_unknown_scale
from fpnet_core.types import GridMap, Submap


class MapMatchStatus(StrEnum):
    """What may be said of two maps."""

    MATCHED = 'matched'
    AMBIGUOUS = 'ambiguous'
    UNMATCHED = 'unmatched'


@dataclass(frozen=True, eq=False)
class MapMatch:
    """
    The placement of one map on another.

    ``A_plan_sub`` maps the submap's nominal metres to the plan's; None if unmatched.
    ``A_best`` is the best placement whatever it is worth, None only where there is none at all.
    ``score`` is the raster agreement in [0, 1], ``probability`` that of the best placement
    against all others and against none of them, of ``places`` searched (see
    :func:`fpnet_core.localizer.belief.posterior`). Both sides are in metres as estimated from
    door widths.
    """

    status: MapMatchStatus
    A_plan_sub: Affine2D | None
    A_best: Affine2D | None
    score: float
    probability: float
    places: float
    plan: MapSide
    sub: MapSide
    comparison: Comparison
    timings_ms: dict[str, float]


def match_maps(
    plan: GridMap, submap: Submap, matcher: RegionMatcher, config: FpnetConfig
) -> MapMatch:
    """
    Place ``submap`` on ``plan`` although neither scale is trusted.

    Door widths give each map a first metric scale; placements are then searched over
    a range around it, which is wide where few doors agree.

    Raises
    ------
    MapFormatError
        If the plan holds no room.
    """
    timer = StageTimer()
    with timer.stage('total'):
        with timer.stage('scale'):
            plan_scale = segment_unknown_scale(plan, config.segmentation)[1]
            sub_scale = segment_unknown_scale(submap, config.segmentation)[1]
        with timer.stage('segment'):
            plan_side = prepare_plan(rescaled(plan, plan_scale.factor), config)
        metric = replace(submap, grid=rescaled(submap.grid, sub_scale.factor))
        sub_side = prepare_submap(metric, SubmapSegmenter(config.segmentation), timer)
        confidence = min(plan_scale.confidence, sub_scale.confidence)
        search = door_scale_search(confidence, config.pose)
        comparison = compare(
            plan_side, sub_side, matcher, metric.free_area_m2, config.pose, timer, search
        )
    places = plan_side.evidence.free_area_m2 * len(search)
    status, score, probability = _judged(comparison, sub_side, places, config)
    best = None
    if comparison.estimates:
        A = comparison.estimates[0].A_plan_submap
        linear = A.linear * (sub_scale.factor / plan_scale.factor)
        best = Affine2D(linear, A.translation / plan_scale.factor)
    return MapMatch(
        status=status,
        A_plan_sub=None if status is MapMatchStatus.UNMATCHED else best,
        A_best=best,
        score=score,
        probability=probability,
        places=places,
        plan=plan_side,
        sub=sub_side,
        comparison=comparison,
        timings_ms=timer.timings_ms,
    )


def _judged(
    comparison: Comparison, sub: MapSide, places: float, config: FpnetConfig
) -> tuple[MapMatchStatus, float, float]:
    """Status, score and probability of the best placement."""
    if not comparison.estimates:
        return MapMatchStatus.UNMATCHED, 0.0, 0.0
    scores = np.array([e.score for e in comparison.estimates])
    each = posterior(scores, sub.evidence.wall_length_m, places, config.localizer)
    best, p = float(scores[0]), float(each[0])
    if p < 1.0 - each.sum():
        return MapMatchStatus.UNMATCHED, best, p
    if p < config.localizer.claim_probability:
        return MapMatchStatus.AMBIGUOUS, best, p
    return MapMatchStatus.MATCHED, best, p
