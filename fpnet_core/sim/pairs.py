# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Matching pairs: a drawing and a partial robot map of one building, with the true answer.

Both sides go through the product's own segmentation and graph features, so that training sees
what run time sees.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D
from fpnet_core.graphs import build_region_graph
from fpnet_core.segmentation import segment_floorplan, segment_submap
from fpnet_core.sim.config import DrawingConfig, SimConfig
from fpnet_core.sim.explore import draw_scanner, scan_walk
from fpnet_core.sim.labels import label_regions
from fpnet_core.sim.perturb import build_world, draw_changes, move_doors
from fpnet_core.sim.plans import generate_plan
from fpnet_core.sim.render import render_plan
from fpnet_core.sim.types import BuildingPlan
from fpnet_core.sim.walks import plan_walk
from fpnet_core.types import RegionGraph, Segmentation, Submap

MIN_SUB_REGIONS = 2
"""Submaps with fewer regions teach nothing; another tour is drawn."""

_ATTEMPTS = 24
_TOURS_PER_STOREY = 6


@dataclass(frozen=True, eq=False)
class MatchingPair:
    """
    One training example.

    ``sub_labels (N,) int64`` holds for each submap region the index of its plan region,
    ``UNMATCHED`` or ``IGNORE``. ``plan_id`` names the storey: pairs that share it must stay on
    one side of a split.
    """

    plan_graph: RegionGraph
    sub_graph: RegionGraph
    sub_labels: NDArray[np.int64]
    A_plan_submap: Affine2D
    explored_area_m2: float
    plan_id: int
    family: str


@dataclass(frozen=True, eq=False)
class PairScene:
    """A pair together with the maps it came from, for pictures and tests."""

    pair: MatchingPair
    plan: BuildingPlan
    plan_segmentation: Segmentation
    sub_segmentation: Segmentation
    submap: Submap


def generate_pair(seed: int, index: int, config: SimConfig | None = None) -> MatchingPair:
    """
    Return pair ``index`` of the endless sequence that ``seed`` names.

    The result depends on ``(seed, index, config)`` only, not on what was generated before or by
    how many processes.
    """
    return generate_scene(seed, index, config).pair


def generate_scene(seed: int, index: int, config: SimConfig | None = None) -> PairScene:
    """Return pair ``index`` as :func:`generate_pair` does, with the maps behind it."""
    config = config if config is not None else SimConfig()
    plan_id = index // config.pairs_per_plan
    for attempt in range(_ATTEMPTS):
        version = attempt // _TOURS_PER_STOREY
        plan = _storey(seed, plan_id, version, config.min_rooms, config.max_rooms)
        rng = np.random.default_rng([seed, plan_id, 1, index, attempt])
        scene = _draw_scene(plan, rng, config, plan_id)
        if scene is not None:
            return scene
    raise RuntimeError(f'no usable tour in {_ATTEMPTS} attempts for pair {index} of seed {seed}')


@lru_cache(maxsize=2)
def _storey(seed: int, plan_id: int, version: int, min_rooms: int, max_rooms: int) -> BuildingPlan:
    rng = np.random.default_rng([seed, plan_id, 0, version])
    return generate_plan(rng, min_rooms=min_rooms, max_rooms=max_rooms)


def _draw_scene(
    plan: BuildingPlan, rng: np.random.Generator, config: SimConfig, plan_id: int
) -> PairScene | None:
    """Draw the map, build the world, walk, segment and label; None where too little is seen."""
    scanner = draw_scanner(rng, config.scan)
    world = build_world(plan, draw_changes(plan, rng, config.building), scanner.height_m)
    walk = plan_walk(world, rng, config.scan)
    if not len(walk):
        return None
    submap, T_submap_building = scan_walk(world, walk, scanner, rng, config.scan, config.submap)
    sub = segment_submap(submap, config.segmentation)
    if len(sub.regions) < MIN_SUB_REGIONS:
        return None
    A_plan_building = draw_placement(rng, config.drawing)
    drawing = render_plan(
        move_doors(plan, rng, config.drawing.moved_doors),
        resolution_m=float(rng.uniform(*config.drawing.resolution_m)),
        wall_m=plan.wall_m * float(rng.uniform(*config.drawing.wall_factor)),
        T_plan_building=A_plan_building,
    )
    drawn = segment_floorplan(drawing, config.segmentation)
    A_plan_submap = A_plan_building @ T_submap_building.inv()
    pair = MatchingPair(
        plan_graph=build_region_graph(drawn, 'plan'),
        sub_graph=build_region_graph(sub, 'submap'),
        sub_labels=label_regions(drawn, sub, A_plan_submap),
        A_plan_submap=A_plan_submap,
        explored_area_m2=submap.free_area_m2,
        plan_id=plan_id,
        family=plan.family,
    )
    return PairScene(pair, plan, drawn, sub, submap)


def draw_placement(rng: np.random.Generator, config: DrawingConfig) -> Affine2D:
    """Draw ``A_plan_building``: the drawing's rotation, its scale error and its axes' ratio."""
    common = rng.uniform(-config.scale_error, config.scale_error)
    split = rng.uniform(-config.axis_error, config.axis_error)
    angle = (
        rng.uniform(-np.pi, np.pi)
        if rng.random() < config.any_angle
        else np.pi / 2.0 * rng.integers(4)
    )
    c, s = np.cos(angle), np.sin(angle)
    stretch = np.diag([1.0 + common + split, 1.0 + common - split])
    return Affine2D(stretch @ np.array([[c, -s], [s, c]]), rng.uniform(-30.0, 30.0, 2))
