# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Match two whole maps of unknown relative scale, rotation and translation, once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig, PoseConfig
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.localizer.belief import posterior
from fpnet_core.localizer.sides import (
    Comparison,
    MapSide,
    StageTimer,
    allowed_scales,
    compare,
    prepare_plan,
    prepare_submap,
)
from fpnet_core.matching import RegionMatcher
from fpnet_core.segmentation import ScaleEstimate, SubmapSegmenter, segment_unknown_scale
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
            plan_side = prepare_plan(_rescaled(plan, plan_scale.factor), config)
        metric = replace(submap, grid=_rescaled(submap.grid, sub_scale.factor))
        sub_side = prepare_submap(metric, SubmapSegmenter(config.segmentation), timer)
        scales = _scales_to_try(plan_scale, sub_scale, config.pose)
        comparison = compare(
            plan_side, sub_side, matcher, metric.free_area_m2, config.pose, timer, scales
        )
    places = plan_side.evidence.free_area_m2 * len(scales)
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


def _scales_to_try(
    plan: ScaleEstimate, sub: ScaleEstimate, config: PoseConfig
) -> NDArray[np.float64]:
    """Scales around 1 between two maps in estimated metres: many doors narrow the range."""
    sure = min(plan.confidence, sub.confidence) >= config.sure_scale_confidence
    return allowed_scales(config.sure_scale_tolerance if sure else config.unsure_scale_tolerance)


def _rescaled(grid: GridMap, factor: float) -> GridMap:
    """Return the same cells with every length multiplied by ``factor``."""
    origin = grid.T_frame_grid
    moved = SE2(origin.linear, origin.translation * factor)
    return replace(grid, resolution=grid.resolution * factor, T_frame_grid=moved)


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
