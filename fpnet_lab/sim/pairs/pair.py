# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Matching pairs: a drawing and a partial robot map of one building, with ground truth.

Both maps use the product's segmentation and graph features, so that training data matches the
data at run time.
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
"""Submaps with fewer regions are useless for training; another tour is sampled. Chosen."""

_ATTEMPTS = 24  # numerical
_TOURS_PER_STOREY = 6  # chosen

# Given: element of a pair's seed that separates the random streams.
_TOUR, _DRAWING = 1, 2


@dataclass(frozen=True, eq=False)
class MatchingPair:
    """
    One training example.

    Parameters
    ----------
    plan_graph, sub_graph : region graphs of the plan and the submap
    sub_labels : (N,) int64
        Index of the plan region of each submap region, or ``UNMATCHED`` or ``IGNORE``.
    A_plan_submap : ground truth transform
    explored_area_m2 : free space observed by the robot
    plan_id : storey; pairs with the same id must be in the same dataset split
    family : layout family of a generated storey, name of a given one
    plan_portals, sub_portals : openings that form the graphs' edges
    truth : correspondences that define the labels; None if not stored
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
        """Least-squares similarity to the true transform at the submap regions' corners."""
        corners = [region.polygon for region in self.sub_graph.regions]
        return nearest_similarity(self.A_plan_submap, np.concatenate(corners))


@dataclass(frozen=True, eq=False)
class MappedPair:
    """A pair with its source maps, for figures and tests."""

    pair: MatchingPair
    plan: BuildingPlan
    plan_segmentation: Segmentation
    sub_segmentation: Segmentation
    submap: Submap


def nearest_similarity(A: Affine2D, points: NDArray[np.float64]) -> Similarity2D:
    """
    Return the similarity that best approximates ``A`` at ``points (P, 2)``.

    This is the closed-form least-squares solution. Coincident points are treated as if spread
    equally in both directions.
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
    Return pair ``index`` of the infinite sequence defined by ``seed``.

    The result depends only on ``(seed, index, config, source)``, not on previously generated
    pairs or the number of processes.

    Raises
    ------
    FpnetError
        If no tour through the storey observes enough regions.
    """
    return generate_mapped_pair(seed, index, config, source).pair


def generate_mapped_pair(
    seed: int, index: int, config: SimConfig | None = None, source: PlanSource | None = None
) -> MappedPair:
    """Return pair ``index`` like :func:`generate_pair`, with its source maps."""
    config = config if config is not None else SimConfig()
    if source is None:
        source = generated_plans(config)
    with _one_thread():
        return _first_usable(seed, index, config, source)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Limit OpenCV to one thread, because rounding depends on how it splits an image."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def _first_usable(seed: int, index: int, config: SimConfig, source: PlanSource) -> MappedPair:
    """Return the pair of the first attempt that observes enough regions."""
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
    """Return a storey's drawing, shared by all pairs with the same ``number``."""
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
    """Generate, segment and label a robot map; return None if it has too few regions."""
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
    """Build the world, walk and scan; return None if the robot fits nowhere."""
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
