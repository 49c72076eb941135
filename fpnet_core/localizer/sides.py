# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Everything that is derived once from a plan or a submap, and how two of them are compared."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
import time

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from fpnet_core.config import FpnetConfig, PoseConfig
from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import SE2, Placements
from fpnet_core.graphs import build_region_graph
from fpnet_core.localizer.scale import ScaleSearch
from fpnet_core.matching import RegionMatcher
from fpnet_core.pose import (
    MapEvidence,
    map_evidence,
    propose,
    select_promising,
    verified_estimates,
)
from fpnet_core.segmentation import SubmapSegmenter, segment_floorplan
from fpnet_core.types import (
    FREE,
    GridMap,
    MatchResult,
    RegionGraph,
    Segmentation,
    Submap,
)

RobotXY = NDArray[np.float64] | None
"""Where the robot is in the submap, ``(2,)`` [m]; None without one."""

_CENTROID_SHARE = 0.05  # centroids of half-seen rooms move the scale of an assignment by this


@dataclass(frozen=True, eq=False)
class MapSide:
    """One map as regions, as a graph and as raster evidence."""

    segmentation: Segmentation
    graph: RegionGraph
    evidence: MapEvidence


@dataclass(frozen=True, eq=False)
class Comparison:
    """What one comparison of a submap with the plan found, best placement first."""

    match: MatchResult
    estimates: Placements


class StageTimer:
    """Collects the duration of named stages in milliseconds."""

    def __init__(self) -> None:
        self.timings_ms: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time the enclosed block under ``name``."""
        start = time.perf_counter()
        yield
        elapsed = 1e3 * (time.perf_counter() - start)
        self.timings_ms[name] = self.timings_ms.get(name, 0.0) + elapsed


def prepare_plan(grid: GridMap, config: FpnetConfig) -> MapSide:
    """
    Segment a floorplan and derive its graph and evidence; runs once per floorplan.

    Raises
    ------
    MapFormatError
        If the drawing holds no room.
    """
    segmentation = segment_floorplan(grid, config.segmentation)
    if not segmentation.rooms:
        raise MapFormatError(
            f'the floorplan holds no room ({segmentation.reason}); check that free space is '
            'drawn light, walls dark, and that the resolution is in metres per cell'
        )
    return plan_side(segmentation)


def rescaled(grid: GridMap, factor: float) -> GridMap:
    """Return the same cells with every length multiplied by ``factor``."""
    origin = grid.T_frame_grid
    moved = SE2(origin.linear, origin.translation * factor)
    return replace(grid, resolution=grid.resolution * factor, T_frame_grid=moved)


def rescaled_rooms(segmentation: Segmentation, factor: float) -> Segmentation:
    """Return the same rooms and doors with every length multiplied by ``factor``."""
    regions = (
        replace(
            region,
            polygon=region.polygon * factor,
            centroid=region.centroid * factor,
            area_m2=region.area_m2 * factor**2,
        )
        for region in segmentation.regions
    )
    portals = (replace(portal, ends=portal.ends * factor) for portal in segmentation.portals)
    grid = rescaled(segmentation.grid, factor)
    return replace(segmentation, grid=grid, regions=tuple(regions), portals=tuple(portals))


def plan_side(segmentation: Segmentation) -> MapSide:
    """Return graph and evidence of a segmented plan; only its rooms count as free space."""
    grid = segmentation.grid
    interior = (segmentation.labels > 0) | _free_beside_rooms(segmentation)
    return MapSide(
        segmentation,
        build_region_graph(segmentation, 'plan'),
        map_evidence(grid, interior),
    )


def _free_beside_rooms(segmentation: Segmentation) -> NDArray[np.bool_]:
    """Free cells connected to a room: door openings, and slivers that no room took."""
    free = segmentation.grid.cells == FREE
    components, count = label(free)
    touched = np.zeros(count + 1, dtype=bool)
    touched[np.unique(components[segmentation.labels > 0])] = True
    touched[0] = False
    return np.asarray(touched[components])


def prepare_submap(submap: Submap, segmenter: SubmapSegmenter, timer: StageTimer) -> MapSide:
    """
    Segment a submap and derive its graph and evidence; may hold no region at all.

    ``segmenter`` cuts again only what changed since the last submap it saw.
    """
    with timer.stage('segment'):
        segmentation = segmenter.update(submap)
    with timer.stage('graph'):
        graph = build_region_graph(segmentation, 'submap')
    with timer.stage('evidence'):
        evidence = map_evidence(submap.grid)
    return MapSide(segmentation, graph, evidence)


def compare(
    plan: MapSide,
    sub: MapSide,
    matcher: RegionMatcher,
    explored_area_m2: float,
    config: PoseConfig,
    timer: StageTimer,
    search: ScaleSearch,
    tracked: Placements | None = None,
    robot_xy: RobotXY = None,
) -> Comparison:
    """
    Match, propose, verify: all placements worth knowing, best first.

    Parameters
    ----------
    plan, sub : both sides
    matcher : graph matcher
    explored_area_m2 : observed free area, grades the matcher's threshold
    timer : receives stage durations
    search : scales of the plan to try
    tracked : placements from the previous tick, refined beside the new ones
    robot_xy : (2,) where the robot is in the submap, None without one
    """
    with timer.stage('match'):
        match = matcher.match(plan.graph, sub.graph, explored_area_m2)
    with timer.stage('propose'):
        is_sure = len(match.pairs) >= config.sure_pairs
        candidates = propose(
            plan.segmentation,
            sub.segmentation,
            match.probability,
            plan.evidence,
            sub.evidence,
            search.stretches,
            config.focused_pairs if is_sure else config.max_pairs,
        )
        promising = select_promising(plan.evidence, sub.evidence, candidates, config)
        promising = _assigned(match, search.factors).joined(promising)
    with timer.stage('verify'):
        if tracked is not None:
            promising = tracked.joined(promising)
        estimates = verified_estimates(
            plan.evidence, sub.evidence, promising, config, search.freedom, robot_xy
        )
    return Comparison(match, estimates)


def _assigned(match: MatchResult, factors: NDArray[np.float64]) -> Placements:
    """
    Return the placements of the matcher's complete assignments.

    All regions together know the scale better than door widths do, so they may leave the range
    of scales to try by as much again, and by what their centroids may be off.
    """
    margin = factors.max() / factors.min() * (1.0 + _CENTROID_SHARE)
    middle = np.sqrt(factors.min() * factors.max())
    low, high = middle / margin, middle * margin
    placed = (h.S_plan_sub for h in match.hypotheses)
    return Placements.of(S for S in placed if low <= S.scale <= high)
