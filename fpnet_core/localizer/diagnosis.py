# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Offline diagnosis of a run or a match without a pose.

The search is repeated over a much wider range of scales and on the mirrored plan. A running
localizer cannot afford these tests within an update.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
import math

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.types import Reading
from fpnet_core.localizer.drift import drift_of
from fpnet_core.localizer.floorplan import Floorplan, denied_scale
from fpnet_core.localizer.global_localizer import GlobalLocalizer, MatchQuery
from fpnet_core.localizer.kept import is_brief
from fpnet_core.localizer.maps import MapMatch
from fpnet_core.localizer.prepared_maps import StageTimer, prepare_submap, prepared_plan
from fpnet_core.localizer.scale import ScaleSearch, allowed_scales
from fpnet_core.matching import RegionMatcher
from fpnet_core.scoring import PlacementScorer, Posterior
from fpnet_core.scoring.causes import causes_of
from fpnet_core.scoring.findings import (
    DoubleWalls,
    Findings,
    Fit,
    Sensed,
    TurningWalls,
    alike,
    storeys_alike,
)
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.scoring.reasons import CONTRADICTED, FEW_WALLS_M
from fpnet_core.segmentation import ScaleEstimate, SubmapSegmenter
from fpnet_core.segmentation.moved import mirrored_rooms
from fpnet_core.trajectory import path_length
from fpnet_core.types import OCCUPIED, Cause, GridMap, LocalizerOutput, Status, Submap

# Chosen: drift up to which a submap fits as well as one without drift.
_STRAIGHT_DEG, _STRAIGHT_M = 3.0, 0.3
_FARTHEST_M = 5.0  # physical: indoors, a robot that drove this far has passed a wall
# Numerical: scales from a third to three times the one in use, or the one estimated from rooms.
_WIDEST = 2.0


def explain_run(
    outputs: Sequence[LocalizerOutput],
    plan: GridMap,
    matcher: RegionMatcher,
    config: FpnetConfig,
    reading: Reading | None = None,
    invocation: Invocation | None = None,
    storey: int | None = None,
    sensed: Sensed | None = None,
) -> tuple[Cause, ...]:
    """
    Return the likely causes of a run without a pose, most likely first.

    Parameters
    ----------
    outputs : all updates of the run, in time order
    plan : the floorplan, as given to the localizer
    matcher, config : as the localizer's
    reading : parse result of the plan; None if unknown
    invocation : the user's command line, for the next commands
    storey : the selected one on the sheet
    sensed : findings from the scans alone; None if not checked
    """
    seen = [output.submap for output in outputs if output.submap is not None]
    found = Findings(
        0.0,
        0.0,
        needed_m2=config.localizer.min_explored_m2,
        driven_m=max((path_length(submap.path_xy) for submap in seen), default=math.inf),
        contradictions=sum(output.reason == CONTRADICTED for output in outputs),
        restarts=sum(b.stamp_ns != a.stamp_ns and b.id <= a.id for a, b in pairwise(seen)),
        is_mirrored=bool(outputs) and outputs[-1].is_mirrored,
        is_blind=bool(outputs) and not seen,
        storeys_alike=storeys_alike(outputs[-1].storeys if outputs else {}),
        sensed=sensed or Sensed(),
    )
    if seen:
        largest = max(seen, key=lambda submap: submap.free_area_m2)
        found = replace(found, drift=drift_of(outputs), is_blind=_is_blind(seen[-1]))
        estimate, segmentation = None, None
        if reading is not None:
            estimate, segmentation = reading.estimate, reading.segmented(config.segmentation)
        floorplan = Floorplan.prepared(plan, config, estimate, segmentation=segmentation)
        found = replace(found, scale_conflict=floorplan.scale_conflict)
        found = _with_new_search(found, largest, floorplan, matcher, config)
        if found.drift is not None:
            kept = [o.submap for o in outputs if o.submap is not None and not is_brief(o)]
            straight_m = _straight_m(found.drift)
            early = [submap for submap in kept if path_length(submap.path_xy) <= straight_m]
            found = replace(found, early=_early_fit(early, floorplan, matcher, config))
    return causes_of(_with_reading(found, reading, storey), invocation)


def explain_match(
    match: MapMatch,
    matcher: RegionMatcher,
    config: FpnetConfig,
    reading: Reading | None = None,
    invocation: Invocation | None = None,
    storey: int | None = None,
) -> tuple[Cause, ...]:
    """Return the likely causes of a match without a result; parameters as in explain_run."""
    global_localizer = GlobalLocalizer(
        matcher, PlacementScorer.configured(config.localizer), config
    )
    scale_conflict = None
    if reading is not None and reading.scale.is_known:
        scale_conflict = denied_scale(match.plan, config)
    found = Findings(0.0, 0.0, says_scale=match.sub_is_stated, scale_conflict=scale_conflict)
    query = MatchQuery(match.plan, match.sub, match.area_m2, match.search)
    found = _with_tests(found, query, match.candidates.posterior, global_localizer)
    return causes_of(_with_reading(found, reading, storey), invocation)


def causes_of_look(
    query: MatchQuery,
    posterior: Posterior,
    submap: Submap,
    status: Status,
    is_mirrored: bool,
    scale_conflict: ScaleEstimate | None = None,
    sensed: Sensed | None = None,
) -> tuple[Cause, ...]:
    """
    Return the likely causes known after one update; none if the status is `localized`.

    ``scale_conflict`` is the scale estimated from the plan's rooms if it contradicts the plan's
    own, ``sensed`` the findings from the scans alone.
    """
    if status is Status.LOCALIZED:
        return ()
    driven_m = path_length(submap.path_xy)
    found = Findings(
        0.0,
        0.0,
        is_mirrored=is_mirrored,
        scale_conflict=scale_conflict,
        driven_m=driven_m,
        sensed=sensed or Sensed(),
    )
    return causes_of(_with_search(found, query, posterior))


def causes_of_waiting(
    submap: Submap | None, config: FpnetConfig, has_scans: bool
) -> tuple[Cause, ...]:
    """Return the cause of an update that has too few observations to match."""
    seen_m2 = 0.0 if submap is None else submap.free_area_m2
    is_blind = has_scans and (submap is None or _is_blind(submap))
    needed_m2 = config.localizer.min_explored_m2
    return causes_of(Findings(0.0, seen_m2, needed_m2=needed_m2, is_blind=is_blind))


def _is_blind(submap: Submap) -> bool:
    """Return whether a robot that drove far enough to observe a wall has observed none."""
    return path_length(submap.path_xy) > _FARTHEST_M and not (submap.grid.cells == OCCUPIED).any()


def _with_new_search(
    found: Findings,
    submap: Submap,
    floorplan: Floorplan,
    matcher: RegionMatcher,
    config: FpnetConfig,
) -> Findings:
    """Return ``found`` with the results of a new search of one submap and of wider ones."""
    global_localizer = GlobalLocalizer(
        matcher, PlacementScorer.configured(config.localizer), config
    )
    query = _match_query(submap, floorplan)
    if query.area_m2 < found.needed_m2:
        return replace(
            found,
            walls_m=query.sub.evidence.wall_length_m,
            seen_m2=query.area_m2,
            plan_m2=query.plan.evidence.free_area_m2,
        )
    return _with_tests(
        found, query, global_localizer.find(query, StageTimer()).posterior, global_localizer
    )


def _early_fit(
    seen: Sequence[Submap], floorplan: Floorplan, matcher: RegionMatcher, config: FpnetConfig
) -> Fit | None:
    """Return the best fit of the largest of some submaps; None if it has too few walls."""
    if not seen:
        return None
    submap = max(seen, key=lambda submap: submap.free_area_m2)
    query = _match_query(submap, floorplan)
    if query.sub.evidence.wall_length_m < FEW_WALLS_M:
        return None
    global_localizer = GlobalLocalizer(
        matcher, PlacementScorer.configured(config.localizer), config
    )
    return Fit.of(global_localizer.find(query, StageTimer()).posterior)


def _straight_m(drift: DoubleWalls | TurningWalls) -> float:
    """Return the path length over which such drift hardly deforms a map [m]."""
    times = drift.turn_deg / _STRAIGHT_DEG
    if isinstance(drift, DoubleWalls):
        times = max(times, drift.shift_m / _STRAIGHT_M)
    return drift.path_m / max(times, 1.0)


def _match_query(submap: Submap, floorplan: Floorplan) -> MatchQuery:
    """Return the match query for a submap."""
    sub, _ = prepare_submap(submap, SubmapSegmenter(), StageTimer())
    return MatchQuery(floorplan.working, sub, submap.free_area_m2, floorplan.scale.search)


def _with_reading(found: Findings, reading: Reading | None, storey: int | None) -> Findings:
    if reading is None:
        return found
    cells_per_pixel = reading.scale.resolution_m / reading.grid.resolution
    return replace(
        found,
        doubts=() if reading.accepted else reading.doubts,
        storeys=max(1, len(reading.storeys)),
        storey=storey,
        resolution_m=found.resolution_m * cells_per_pixel,
    )


def _with_search(found: Findings, query: MatchQuery, posterior: Posterior) -> Findings:
    factors = (query.search.wide_scales or query.search).factors
    shares, probability = alike(posterior)
    return replace(
        found,
        walls_m=query.sub.evidence.wall_length_m,
        seen_m2=query.area_m2,
        plan_m2=query.plan.evidence.free_area_m2,
        best=Fit.of(posterior),
        alike=shares,
        alike_probability=float(probability),
        scales=(float(factors.min()), float(factors.max())),
        resolution_m=query.plan.segmentation.grid.resolution,
    )


def _with_tests(
    found: Findings, query: MatchQuery, posterior: Posterior, global_localizer: GlobalLocalizer
) -> Findings:
    """Return ``found`` with the results on the plan, at wider scales and on the mirror image."""
    found = _with_search(found, query, posterior)
    factors = allowed_scales(_WIDEST) / (
        found.scale_conflict.factor if found.scale_conflict else 1.0
    )
    wide = ScaleSearch.of_factors(factors, global_localizer.config.pose.anisotropy_sigma)
    mirror = prepared_plan(mirrored_rooms(query.plan.segmentation))
    rescaled = global_localizer.find(replace(query, search=wide), StageTimer()).posterior
    mirrored = global_localizer.find(replace(query, plan=mirror), StageTimer()).posterior
    # Equal odds here: the user weighs that drawings are rarely mirrored.
    contest = global_localizer.scorer.against_mirror(mirrored, posterior, 0.0)
    return replace(found, rescaled=Fit.of(rescaled), mirror=Fit.of(contest))
