# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Matching pairs: a drawing and a partial robot map of one building, with the true answer.

Both sides go through the product's own segmentation and graph features, so that training sees
what run time sees.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D, Similarity2D
from fpnet_core.graphs import build_region_graph
from fpnet_core.segmentation import segment_submap
from fpnet_core.types import Portal, RegionGraph, Segmentation, Submap
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.drawn.drawings import StoreyDrawing, draw_storey
from fpnet_lab.sim.pairs.clips import clip_map
from fpnet_lab.sim.pairs.explore import draw_scanner, scan_walk
from fpnet_lab.sim.pairs.labels import Correspondences, label_regions
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes
from fpnet_lab.sim.pairs.walks import plan_walk
from fpnet_lab.sim.plans.sources import NamedPlan, PlanSource, generated_plans
from fpnet_lab.sim.types import BuildingPlan

MIN_SUB_REGIONS = 2
"""Submaps with fewer regions teach nothing; another tour is drawn. Chosen."""

_ATTEMPTS = 24  # numerical
_TOURS_PER_STOREY = 6  # chosen

# Given: second word of a pair's seed: what the random numbers are for.
_TOUR, _DRAWING = 1, 2


@dataclass(frozen=True, eq=False)
class MatchingPair:
    """
    One training example.

    Parameters
    ----------
    plan_graph, sub_graph : the two sides
    sub_labels : (N,) int64
        For each submap region the index of its plan region, ``UNMATCHED`` or ``IGNORE``.
    A_plan_submap : the true transform
    explored_area_m2 : free space that the robot has seen
    plan_id : the storey; pairs that share it must stay on one side of a split
    family : layout family of a generated storey, name of a given one
    plan_portals, sub_portals : the openings behind the graphs' edges
    truth : what the labels follow from; None where nobody kept it
    """

    plan_graph: RegionGraph
    sub_graph: RegionGraph
    sub_labels: NDArray[np.int64]
    A_plan_submap: Affine2D
    explored_area_m2: float
    plan_id: int
    family: str
    plan_portals: tuple[Portal, ...] = ()
    sub_portals: tuple[Portal, ...] = ()
    truth: Correspondences | None = None

    @property
    def S_plan_submap(self) -> Similarity2D:
        """Similarity nearest to the true transform over the corners of the submap's regions."""
        corners = [region.polygon for region in self.sub_graph.regions]
        return nearest_similarity(self.A_plan_submap, np.concatenate(corners))


@dataclass(frozen=True, eq=False)
class MappedPair:
    """A pair together with the maps it came from, for pictures and tests."""

    pair: MatchingPair
    plan: BuildingPlan
    plan_segmentation: Segmentation
    sub_segmentation: Segmentation
    submap: Submap


def nearest_similarity(A: Affine2D, points: NDArray[np.float64]) -> Similarity2D:
    """
    Return the similarity that takes ``points (P, 2)`` nearest to where ``A`` takes them.

    The least squares solution in closed form; for points in one place the one of equal weight in
    both directions.
    """
    centre = points.mean(axis=0)
    spread = np.cov(points.T, bias=True) if len(points) > 1 else np.zeros((2, 2))
    if np.trace(spread) <= 0.0:
        spread = np.eye(2)
    cross = A.linear @ spread
    a, b = np.trace(cross), cross[1, 0] - cross[0, 1]
    linear = np.array([[a, -b], [b, a]]) / np.trace(spread)
    return Similarity2D(linear, A.apply(centre) - linear @ centre)


def generate_pair(
    seed: int, index: int, config: SimConfig | None = None, source: PlanSource | None = None
) -> MatchingPair:
    """
    Return pair ``index`` of the endless sequence that ``seed`` names.

    The result depends on ``(seed, index, config, source)`` only, not on what was generated before
    or by how many processes.

    Raises
    ------
    FpnetError
        If no tour through the storey sees enough of it.
    """
    return generate_mapped_pair(seed, index, config, source).pair


def generate_mapped_pair(
    seed: int, index: int, config: SimConfig | None = None, source: PlanSource | None = None
) -> MappedPair:
    """Return pair ``index`` as :func:`generate_pair` does, with the maps behind it."""
    config = config if config is not None else SimConfig()
    if source is None:
        source = generated_plans(config)
    with _one_thread():
        return _first_usable(seed, index, config, source)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Keep OpenCV to one thread: its last digits depend on how it shares out an image."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def _first_usable(seed: int, index: int, config: SimConfig, source: PlanSource) -> MappedPair:
    """Return the pair of the first attempt that sees enough."""
    plan_id = source.plan_id(index // config.pairs_per_plan)
    for attempt in range(_ATTEMPTS):
        version = attempt // _TOURS_PER_STOREY
        storey = _storey(source, seed, plan_id, version)
        number = index // config.pairs_per_drawing
        drawing = _drawing(source, config, seed, plan_id, version, number)
        rng = np.random.default_rng([seed, plan_id, _TOUR, index, attempt])
        mapped = _explore(storey, drawing, rng, config, plan_id)
        if mapped is not None:
            return mapped
    raise FpnetError(
        f'plan {storey.name}: no tour in {_ATTEMPTS} saw {MIN_SUB_REGIONS} regions or more; '
        'expected several rooms with doors at the right metres per pixel'
    )


@lru_cache(maxsize=2)
def _storey(source: PlanSource, seed: int, plan_id: int, version: int) -> NamedPlan:
    return source.storey(seed, plan_id, version)


@lru_cache(maxsize=2)
def _drawing(
    source: PlanSource, config: SimConfig, seed: int, plan_id: int, version: int, number: int
) -> StoreyDrawing:
    """Return a drawing of a storey; every pair of the same ``number`` gets this one."""
    storey = _storey(source, seed, plan_id, version)
    rng = np.random.default_rng([seed, plan_id, _DRAWING, number, version])
    return draw_storey(storey, rng, config.drawing, config.segmentation)


def _explore(
    storey: NamedPlan,
    drawing: StoreyDrawing,
    rng: np.random.Generator,
    config: SimConfig,
    plan_id: int,
) -> MappedPair | None:
    """Make a robot map, segment and label it; None where too little is seen."""
    made = _ROBOT_MAPS[config.robot_map](storey, drawing, rng, config)
    if made is None:
        return None
    submap, T_submap_building = made
    sub = segment_submap(submap)
    if len(sub.regions) < MIN_SUB_REGIONS or not drawing.segmentation.regions:
        return None
    A_plan_submap = drawing.A_plan_building @ T_submap_building.inv()
    truth = label_regions(drawing.segmentation, sub, A_plan_submap)
    pair = MatchingPair(
        plan_graph=drawing.graph,
        sub_graph=build_region_graph(sub, 'submap'),
        sub_labels=truth.labels,
        A_plan_submap=A_plan_submap,
        explored_area_m2=submap.free_area_m2,
        plan_id=plan_id,
        family=storey.name,
        plan_portals=drawing.segmentation.portals,
        sub_portals=sub.portals,
        truth=truth,
    )
    return MappedPair(pair, storey.plan, drawing.segmentation, sub, submap)


def _tour(
    storey: NamedPlan, drawing: StoreyDrawing, rng: np.random.Generator, config: SimConfig
) -> tuple[Submap, SE2] | None:
    """Build the world, walk and scan; None where the robot cannot go anywhere."""
    plan = storey.plan
    scanner = draw_scanner(rng, config.scan)
    world = build_world(plan, draw_changes(plan, rng, config.building), scanner.height_m)
    walk = plan_walk(world, rng, config.scan, drawing.area)
    if not len(walk):
        return None
    return scan_walk(world, walk, scanner, rng, config.scan)


def _clip(
    storey: NamedPlan, drawing: StoreyDrawing, rng: np.random.Generator, config: SimConfig
) -> tuple[Submap, SE2] | None:
    return clip_map(storey, drawing.area, rng, config.clip)


_ROBOT_MAPS = {'tour': _tour, 'clip': _clip}
