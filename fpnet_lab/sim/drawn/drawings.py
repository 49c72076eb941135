# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings of storeys for the matcher, with random scale and rotation, segmented into rooms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.geometry import Affine2D, rotation
from fpnet_core.graphs import build_region_graph
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import RegionGraph, Segmentation
from fpnet_lab.sim.config import DrawingConfig
from fpnet_lab.sim.drawn.distort import cut_map, warp_map
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import draw_style
from fpnet_lab.sim.plans.sources import NamedPlan

# Numerical: maximum distance of drawings from the origin of their frame [m].
SHIFT_M = 30.0


@dataclass(frozen=True, eq=False)
class StoreyDrawing:
    """
    A storey's drawing as input of the matcher.

    ``A_plan_building`` maps the building to the drawing; ``area (4, 2)`` is the part of the
    building that is shown [m, building], or None if it is complete.
    """

    segmentation: Segmentation
    graph: RegionGraph
    A_plan_building: Affine2D
    area: NDArray[np.float64] | None


def draw_storey(
    storey: NamedPlan,
    rng: np.random.Generator,
    config: DrawingConfig,
    segmentation: SegmentationConfig,
) -> StoreyDrawing:
    """Draw a storey from its source raster if it has one, otherwise from its outlines."""
    A = draw_placement(rng, config)
    plan = storey.plan
    if storey.raster is None:
        grid = render_plan(
            plan,
            resolution_m=float(rng.uniform(*config.resolution_m)),
            wall_m=plan.wall_m * float(rng.uniform(*config.wall_factor)),
            T_plan_building=A,
            style=draw_style(rng, config.style),
        )
    else:
        grid = warp_map(storey.raster, A)
    area = None
    if rng.random() < config.cut:
        area = _draw_area(storey, rng, config)
        grid = cut_map(grid, A.apply(area))
    drawn = segment_floorplan(grid, segmentation)
    return StoreyDrawing(drawn, build_region_graph(drawn, 'plan'), A, area)


def draw_placement(rng: np.random.Generator, config: DrawingConfig) -> Affine2D:
    """Sample ``A_plan_building``: rotation, scale error and anisotropic scale of a drawing."""
    common = rng.uniform(-config.scale_error, config.scale_error)
    split = rng.uniform(-config.axis_error, config.axis_error)
    angle = (
        rng.uniform(-np.pi, np.pi)
        if rng.random() < config.any_angle
        else np.pi / 2.0 * rng.integers(4)
    )
    stretch = np.diag([1.0 + common + split, 1.0 + common - split])
    return Affine2D(stretch @ rotation(angle), rng.uniform(-SHIFT_M, SHIFT_M, 2))


def _draw_area(
    storey: NamedPlan, rng: np.random.Generator, config: DrawingConfig
) -> NDArray[np.float64]:
    """Sample an axis-parallel rectangle (4, 2) centred in a random room, frame ``building``."""
    room = storey.plan.rooms[int(rng.integers(len(storey.plan.rooms)))]
    half = rng.uniform(*config.cut_m, 2) / 2.0
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return np.asarray(room.polygon.mean(axis=0) + half * corners)
