# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Match two whole maps of unknown relative scale, rotation and translation, once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from fpnet_core.config import FpnetConfig, PoseConfig
from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import Affine2D
from fpnet_core.graphs import build_region_graph
from fpnet_core.localizer.belief import posterior
from fpnet_core.localizer.scale import ScaleSearch, door_scale_search
from fpnet_core.localizer.sides import (
    Comparison,
    MapSide,
    StageTimer,
    compare,
    plan_side,
    rescaled_rooms,
)
from fpnet_core.matching import RegionMatcher
from fpnet_core.pose import map_evidence
from fpnet_core.pose.raster_search import search_placements
from fpnet_core.pose.scales import estimates_across_scales
from fpnet_core.segmentation import ScaleEstimate, segment_unknown_scale
from fpnet_core.types import UNKNOWN, GridMap, Segmentation, Submap

_RASTER_CANDIDATES = 96
"""Placements of the raster search that are refined; four to eight at each scale."""


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
    against all others and against none of them (see
    :func:`fpnet_core.localizer.belief.posterior`). Both sides are in metres as estimated from
    door widths.
    """

    status: MapMatchStatus
    A_plan_sub: Affine2D | None
    A_best: Affine2D | None
    score: float
    probability: float
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
    a range around it, which is wide where few doors agree. The graph proposes; where it leads
    to no claim, the rasters propose as well (:mod:`fpnet_core.pose.raster_search`).

    Raises
    ------
    MapFormatError
        If the plan holds no room.
    """
    timer = StageTimer()
    with timer.stage('total'):
        with timer.stage('segment_plan'):
            plan_cut, plan_scale = _segmented_plan(plan, config)
        with timer.stage('segment_submap'):
            sub_cut, sub_scale = segment_unknown_scale(_trimmed(submap), config.segmentation)
        plan_factor, sub_factor = _metres_per_unit(plan_scale, sub_scale)
        with timer.stage('evidence'):
            plan_map = plan_side(rescaled_rooms(plan_cut, plan_factor))
            sub_map = _submap_side(rescaled_rooms(sub_cut, sub_factor))
        confidence = min(plan_scale.confidence, sub_scale.confidence)
        search = door_scale_search(confidence, config.pose)
        area_m2 = submap.free_area_m2 * sub_factor**2
        comparison = compare(plan_map, sub_map, matcher, area_m2, config.pose, timer, search)
        status, comparison = _judged(comparison, sub_map, config)
        if status is not MapMatchStatus.MATCHED:
            with timer.stage('raster'):
                comparison = _widened(comparison, plan_map, sub_map, search, config.pose)
            status, comparison = _judged(comparison, sub_map, config)
    best, score, probability = None, 0.0, 0.0
    if comparison.estimates:
        first = comparison.estimates[0]
        A, score, probability = first.A_plan_submap, first.score, first.probability
        best = Affine2D(A.linear * (sub_factor / plan_factor), A.translation / plan_factor)
    return MapMatch(
        status=status,
        A_plan_sub=None if status is MapMatchStatus.UNMATCHED else best,
        A_best=best,
        score=score,
        probability=probability,
        plan=plan_map,
        sub=sub_map,
        comparison=comparison,
        timings_ms=timer.timings_ms,
    )


def _segmented_plan(plan: GridMap, config: FpnetConfig) -> tuple[Segmentation, ScaleEstimate]:
    """Return the rooms of a plan of unknown scale, in its nominal metres, and the scale."""
    segmentation, scale = segment_unknown_scale(plan, config.segmentation)
    if not segmentation.rooms:
        raise MapFormatError(
            f'the floorplan holds no room ({segmentation.reason}); check that free space is '
            'drawn light and walls dark'
        )
    return segmentation, scale


def _metres_per_unit(plan: ScaleEstimate, sub: ScaleEstimate) -> tuple[float, float]:
    """
    Return both factors from nominal metres to those that the maps are compared in.

    Where doors speak on one side only, the nominal scales are the best guess of the ratio.
    """
    if plan.confidence > 0.0 and sub.confidence > 0.0:
        return plan.factor, sub.factor
    known = plan if plan.confidence > 0.0 else sub
    return known.factor, known.factor


def _submap_side(segmentation: Segmentation) -> MapSide:
    """Return graph and evidence of a segmented map, which may hold no region at all."""
    graph = build_region_graph(segmentation, 'submap')
    return MapSide(segmentation, graph, map_evidence(segmentation.grid))


def _trimmed(submap: Submap) -> Submap:
    """Return the map without the unknown cells around it, which take time and say nothing."""
    known = submap.grid.cells != UNKNOWN
    if not known.any():
        return submap
    rows, cols = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
    window = slice(rows[0], rows[-1] + 1), slice(cols[0], cols[-1] + 1)
    return replace(submap, grid=submap.grid.cropped(*window), lintel=submap.lintel[window])


def _widened(
    comparison: Comparison, plan: MapSide, sub: MapSide, search: ScaleSearch, config: PoseConfig
) -> Comparison:
    """
    Return the comparison with what the rasters propose, all scales compared fairly.

    Every other scale will do: refinement closes the gaps, and time goes with their number.
    """
    raster = search_placements(
        plan.evidence, sub.evidence, search.factors[::2], _RASTER_CANDIDATES
    )
    candidates = comparison.estimates.joined(raster)
    estimates = estimates_across_scales(
        plan.evidence, sub.evidence, candidates, config, search.freedom
    )
    return replace(comparison, estimates=estimates)


def _judged(
    comparison: Comparison, sub: MapSide, config: FpnetConfig
) -> tuple[MapMatchStatus, Comparison]:
    """Return what may be said, and the comparison with its placements' probabilities."""
    found = comparison.estimates
    if not found:
        return MapMatchStatus.UNMATCHED, comparison
    each = posterior(found.score, sub.evidence.wall_length_m, config.localizer)
    judged = replace(comparison, estimates=replace(found, probability=each))
    if each[0] < 1.0 - each.sum():
        return MapMatchStatus.UNMATCHED, judged
    if each[0] < config.localizer.claim_probability:
        return MapMatchStatus.AMBIGUOUS, judged
    return MapMatchStatus.MATCHED, judged
