# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One-shot matching of two whole maps: rotation, translation, and scales where unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.types import Reading
from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import Affine2D
from fpnet_core.graphs import build_region_graph
from fpnet_core.localizer.global_localizer import Candidates, GlobalLocalizer, MatchQuery
from fpnet_core.localizer.prepared_maps import StageTimer, prepared_plan
from fpnet_core.localizer.scale import ScaleSearch, estimated_search, first_search
from fpnet_core.matching import RegionMatcher
from fpnet_core.pose import PreparedMap, map_evidence
from fpnet_core.raster.windows import window_of
from fpnet_core.scoring import Circumstances, PlacementScorer, Posterior, reason_of
from fpnet_core.segmentation import (
    STATED_SCALE,
    ScaleEstimate,
    segment_floorplan,
    segment_submap,
    segment_unknown_scale,
)
from fpnet_core.segmentation.moved import rescaled_rooms
from fpnet_core.types import UNKNOWN, GridMap, Segmentation, Submap


class MapMatchStatus(StrEnum):
    """Result of matching two maps."""

    MATCHED = 'matched'
    AMBIGUOUS = 'ambiguous'
    UNMATCHED = 'unmatched'


@dataclass(frozen=True, eq=False)
class SegmentedMap:
    """
    A map segmented into rooms, in its nominal metres, with its scale.

    ``scale`` is in true metres per nominal metre: stated, or estimated from rooms and doors.
    ``free_area_m2`` is nominal as well.
    """

    segmentation: Segmentation
    scale: ScaleEstimate
    is_stated: bool
    free_area_m2: float


@dataclass(frozen=True, eq=False)
class MapMatch:
    """
    Placement of one map on another.

    ``A_plan_sub`` maps the submap's nominal metres to the plan's; None if unmatched.
    ``A_best`` is the best placement regardless of the status, None only if there is no placement.
    ``score`` is the raster agreement in [0, 1], ``probability`` that of the best placement
    against all others and against none of them (see :mod:`fpnet_core.scoring`); ``reason``
    explains the status in one sentence. Both prepared maps are in metres, as stated or as
    estimated from rooms and doors; ``search`` are the scales tried between them, ``area_m2`` is
    the robot's free space, and ``sub_is_stated``: its map is in metres. ``storey`` is the one
    matched if the plan is one of several.
    """

    status: MapMatchStatus
    A_plan_sub: Affine2D | None
    A_best: Affine2D | None
    score: float
    probability: float
    plan: PreparedMap
    sub: PreparedMap
    candidates: Candidates
    search: ScaleSearch
    area_m2: float
    sub_is_stated: bool
    timings_ms: dict[str, float]
    reason: str
    storey: str = ''

    @property
    def scale(self) -> float | None:
        """Nominal plan metres per nominal submap metre, for the best placement."""
        return None if self.A_best is None else self.A_best.scale


def segment_plan(grid: GridMap, config: FpnetConfig, is_metric: bool = False) -> SegmentedMap:
    """
    Segment a floorplan into rooms; ``is_metric``: its scale was stated.

    Raises
    ------
    MapFormatError
        If the plan contains no room.
    """
    is_stated = is_metric and config.localizer.scale_policy != 'unknown'
    if is_stated:
        return _with_rooms(segment_floorplan(grid, config.segmentation), STATED_SCALE, True)
    return _with_rooms(*segment_unknown_scale(grid, config.segmentation), False)


def cut_of(reading: Reading, config: FpnetConfig) -> SegmentedMap:
    """
    Return the rooms of a parsed drawing, at the parsed scale.

    Raises
    ------
    MapFormatError
        If it contains no room.
    """
    if reading.estimate is None and config.localizer.scale_policy == 'unknown':
        return segment_plan(reading.grid, config)
    segmentation = reading.segmented(config.segmentation)
    scale = reading.estimate or STATED_SCALE
    return _with_rooms(segmentation, scale, reading.scale.is_known)


def _with_rooms(segmentation: Segmentation, scale: ScaleEstimate, is_stated: bool) -> SegmentedMap:
    if not segmentation.rooms:
        raise MapFormatError(
            f'the floorplan contains no room ({segmentation.reason}); check that free space is '
            'drawn light and walls dark'
        )
    return SegmentedMap(segmentation, scale, is_stated, 0.0)


def segment_robot_map(
    submap: Submap, config: FpnetConfig, is_metric: bool = False
) -> SegmentedMap:
    """Segment a robot's map into rooms, possibly none; ``is_metric``: it is in metres."""
    trimmed = _trimmed(submap)
    if is_metric:
        segmentation, scale = segment_submap(trimmed), STATED_SCALE
    else:
        segmentation, scale = segment_unknown_scale(trimmed, config.segmentation)
    return SegmentedMap(segmentation, scale, is_metric, submap.free_area_m2)


def match_maps(
    plan: GridMap | Reading,
    submap: Submap,
    matcher: RegionMatcher,
    config: FpnetConfig,
    plan_is_metric: bool = False,
    sub_is_metric: bool = False,
) -> MapMatch:
    """
    Place ``submap`` on ``plan``; a parsed drawing has its own flag for metric scale.

    The scale policy of the localizer applies to stated scales (``localizer.scale_policy``). If a
    scale is unknown, rooms and doors give an estimate with an interval; placements are
    searched over the combined intervals of both maps.

    Raises
    ------
    MapFormatError
        If the plan contains no room.
    """
    timer = StageTimer()
    with timer.stage('total'):
        with timer.stage('segment_plan'):
            if isinstance(plan, Reading):
                plan_cut = cut_of(plan, config)
            else:
                plan_cut = segment_plan(plan, config, plan_is_metric)
        with timer.stage('segment_submap'):
            sub_cut = segment_robot_map(submap, config, sub_is_metric)
        global_localizer = GlobalLocalizer(
            matcher, PlacementScorer.configured(config.localizer), config
        )
        return match_segmented(plan_cut, sub_cut, global_localizer, timer)


@dataclass(frozen=True, eq=False, kw_only=True)
class ScaledPair(MatchQuery):
    """
    Both maps in metres, as stated or estimated from rooms and doors, and the scales to try.

    The factors are metres per nominal metre of each map.
    """

    plan_factor: float
    sub_factor: float


def scaled_pair(plan: SegmentedMap, sub: SegmentedMap, config: FpnetConfig) -> ScaledPair:
    """Convert a plan and a robot's map to metres."""
    plan_factor, sub_factor = plan.scale.factor, sub.scale.factor
    return ScaledPair(
        prepared_plan(rescaled_rooms(plan.segmentation, plan_factor)),
        _prepared_submap(rescaled_rooms(sub.segmentation, sub_factor)),
        sub.free_area_m2 * sub_factor**2,
        _search(plan, sub, config),
        plan_factor=plan_factor,
        sub_factor=sub_factor,
    )


def match_storeys(
    plans: Mapping[str, SegmentedMap],
    sub: SegmentedMap,
    global_localizer: GlobalLocalizer,
    timer: StageTimer,
) -> dict[str, MapMatch]:
    """
    Place a robot's map on the storeys of a site, by name, most probable storey first.

    The storeys exclude each other, so a match on one also determines the storey.
    """
    found = {name: _compared(plan, sub, global_localizer, timer) for name, plan in plans.items()}
    ranked = sorted(found, key=lambda name: -found[name][1].posterior.best)
    posteriors = [found[name][1].posterior for name in ranked]
    if len(posteriors) > 1:
        even, fresh = [0.0] * len(posteriors), [True] * len(posteriors)
        posteriors = global_localizer.scorer.among_storeys(posteriors, even, fresh)
    told = dict(zip(ranked, posteriors, strict=True))
    order = sorted(ranked, key=lambda name: -told[name].best)
    return {
        name: _map_match(
            found[name][0],
            replace(found[name][1], posterior=told[name]),
            sub.is_stated,
            global_localizer.config,
            timer,
            _storeys_of(name, order, told),
        )
        for name in order
    }


@dataclass(frozen=True)
class _Storeys:
    """``name`` of a storey, and the strongest other one: name, share of walls explained, p."""

    name: str = ''
    runner_up: tuple[str, float, float] | None = None


def _storeys_of(name: str, order: Sequence[str], told: Mapping[str, Posterior]) -> _Storeys:
    others = [each for each in order if each != name and len(told[each].evidence)]
    if len(order) == 1:
        return _Storeys()
    if not others:
        return _Storeys(name)
    posterior = told[others[0]]
    return _Storeys(name, (others[0], float(posterior.evidence.of('support')[0]), posterior.best))


def match_segmented(
    plan: SegmentedMap, sub: SegmentedMap, global_localizer: GlobalLocalizer, timer: StageTimer
) -> MapMatch:
    """Place a robot's map on a plan; both are segmented into rooms."""
    pair, candidates = _compared(plan, sub, global_localizer, timer)
    return _map_match(pair, candidates, sub.is_stated, global_localizer.config, timer)


def _compared(
    plan: SegmentedMap, sub: SegmentedMap, global_localizer: GlobalLocalizer, timer: StageTimer
) -> tuple[ScaledPair, Candidates]:
    with timer.stage('evidence'):
        pair = scaled_pair(plan, sub, global_localizer.config)
    return pair, global_localizer.find(pair, timer)


def _map_match(
    pair: ScaledPair,
    candidates: Candidates,
    sub_is_stated: bool,
    config: FpnetConfig,
    timer: StageTimer,
    storeys: _Storeys = _Storeys(),
) -> MapMatch:
    """Return the match for the candidates of a comparison."""
    status = _status(candidates.posterior, config)
    best, score, probability = None, 0.0, 0.0
    if candidates.estimates:
        first = candidates.estimates[0]
        A, score, probability = first.A_plan_submap, first.score, first.probability
        factor = pair.plan_factor
        best = Affine2D(A.linear * (pair.sub_factor / factor), A.translation / factor)
    return MapMatch(
        status=status,
        A_plan_sub=None if status is MapMatchStatus.UNMATCHED else best,
        A_best=best,
        score=score,
        probability=probability,
        plan=pair.plan,
        sub=pair.sub,
        candidates=candidates,
        search=pair.search,
        area_m2=pair.area_m2,
        sub_is_stated=sub_is_stated,
        timings_ms=timer.timings_ms,
        reason=_reason(candidates.posterior, pair, status, config, storeys),
        storey=storeys.name,
    )


def _search(plan: SegmentedMap, sub: SegmentedMap, config: FpnetConfig) -> ScaleSearch:
    """Return the scales to try: by policy if both are stated, else by the estimates."""
    if plan.is_stated and sub.is_stated:
        return first_search(config.localizer.scale_policy, config.pose)
    return estimated_search(plan.scale, sub.scale, config.pose)


def _prepared_submap(segmentation: Segmentation) -> PreparedMap:
    """Return graph and evidence of a segmented map, which may contain no region."""
    graph = build_region_graph(segmentation, 'submap')
    return PreparedMap(segmentation, graph, map_evidence(segmentation.grid))


def _trimmed(submap: Submap) -> Submap:
    """Return the map without the unknown margin, which only costs time."""
    window = window_of(submap.grid.cells != UNKNOWN)
    if window is None:
        return submap
    return replace(submap, grid=submap.grid.cropped(*window), lintel=submap.lintel[window])


def _reason(
    posterior: Posterior,
    pair: ScaledPair,
    status: MapMatchStatus,
    config: FpnetConfig,
    storeys: _Storeys,
) -> str:
    facts = Circumstances(
        pair.sub.evidence.wall_length_m,
        config.localizer.match_probability,
        pair.sub.evidence.corners,
        pair.search.bounds,
        is_accepted=status is MapMatchStatus.MATCHED,
        storey=storeys.name,
        runner_up_storey=storeys.runner_up,
        unseen_m=pair.plan.evidence.unseen_wall_m(pair.area_m2),
    )
    return reason_of(posterior, facts)


def _status(posterior: Posterior, config: FpnetConfig) -> MapMatchStatus:
    """Return the status of a match."""
    if posterior.best + posterior.elsewhere <= posterior.none + posterior.foreign:
        return MapMatchStatus.UNMATCHED
    if posterior.best < config.localizer.match_probability:
        return MapMatchStatus.AMBIGUOUS
    return MapMatchStatus.MATCHED
