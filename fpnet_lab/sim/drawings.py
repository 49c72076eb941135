# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a matcher is shown of a storey: a drawing at another scale and angle, cut into rooms."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.graphs import build_region_graph
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import OCCUPIED, UNKNOWN, GridMap, RegionGraph, Segmentation
from fpnet_lab.sim.config import DrawingConfig
from fpnet_lab.sim.plan_sources import Storey
from fpnet_lab.sim.render import render_plan
from fpnet_lab.sim.styles import draw_style

MARGIN_M = 1.0
"""Unknown border around a warped drawing. Chosen."""

# Chosen, not measured:
# A cell is wall where walls cover this share of the interpolated place: below one half, so that
# lines of one cell stay closed at any angle.
_WALL_SHARE = 0.4
# Drawings lie this far from the origin of their frame at most [m].
_SHIFT_M = 30.0


@dataclass(frozen=True, eq=False)
class Drawing:
    """
    A storey as the matcher sees it.

    ``A_plan_building`` says where the drawing shows the building; ``area (4, 2)`` is the part of
    the building that it shows [m, building], None where it shows everything.
    """

    segmentation: Segmentation
    graph: RegionGraph
    A_plan_building: Affine2D
    area: NDArray[np.float64] | None


def draw_storey(
    storey: Storey,
    rng: np.random.Generator,
    config: DrawingConfig,
    segmentation: SegmentationConfig,
) -> Drawing:
    """Draw a storey: rendered from its outlines, or its own raster where it came from one."""
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
    return Drawing(drawn, build_region_graph(drawn, 'plan'), A, area)


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
    return Affine2D(stretch @ np.array([[c, -s], [s, c]]), rng.uniform(-_SHIFT_M, _SHIFT_M, 2))


def _draw_area(
    storey: Storey, rng: np.random.Generator, config: DrawingConfig
) -> NDArray[np.float64]:
    """Draw a rectangle (4, 2) around a place in a room, sides parallel to the building's axes."""
    room = storey.plan.rooms[int(rng.integers(len(storey.plan.rooms)))]
    half = rng.uniform(*config.cut_m, 2) / 2.0
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return np.asarray(room.polygon.mean(axis=0) + half * corners)


def cut_map(grid: GridMap, ring: NDArray[np.float64]) -> GridMap:
    """Return ``grid`` with everything outside of a convex polygon ``ring (V, 2)`` unknown."""
    inside = np.zeros(grid.shape, dtype=np.uint8)
    corners = np.rint(grid.xy_to_rc(ring)[:, ::-1]).astype(np.int32)
    cv2.fillConvexPoly(inside, corners, 1)
    return replace(grid, cells=np.where(inside > 0, grid.cells, UNKNOWN))


def warp_map(grid: GridMap, A_plan_building: Affine2D) -> GridMap:
    """
    Return ``grid``, frame building, as a drawing in ``plan`` with cells of the same size.

    Walls are kept closed; what lies outside of ``grid`` is unknown.
    """
    rows, cols = grid.shape
    corners = grid.rc_to_xy(
        [[-0.5, -0.5], [-0.5, cols - 0.5], [rows - 0.5, cols - 0.5], [rows - 0.5, -0.5]]
    )
    seen = A_plan_building.apply(corners)
    origin = seen.min(axis=0) - MARGIN_M
    size = np.ceil((seen.max(axis=0) + MARGIN_M - origin) / grid.resolution).astype(int)
    pose = SE2.from_xy_yaw(float(origin[0]), float(origin[1]), 0.0)
    # OpenCV wants the way back, from target to source cells [x, y].
    back = _cells_from_xy(grid) @ A_plan_building.inv() @ _xy_from_cells(pose, grid.resolution)

    def warped(values: NDArray[np.generic], flags: int, outside: float) -> NDArray[np.float32]:
        image = cv2.warpAffine(
            values.astype(np.float32),
            back.matrix[:2],
            (int(size[0]), int(size[1])),
            flags=flags | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=outside,
        )
        return np.asarray(image, dtype=np.float32)

    wall = warped(grid.cells == OCCUPIED, cv2.INTER_LINEAR, 0.0) > _WALL_SHARE
    nearest = warped(grid.cells, cv2.INTER_NEAREST, float(UNKNOWN))
    cells = np.where(wall, OCCUPIED, np.where(nearest == OCCUPIED, UNKNOWN, nearest))
    return GridMap(cells.astype(np.int8), grid.resolution, pose, 'plan')


def _xy_from_cells(pose: SE2, cell_m: float) -> Affine2D:
    """Return the map from cells (column, row), centres at integers, to metres."""
    cells = Affine2D(np.eye(2) * cell_m, np.full(2, 0.5 * cell_m))
    composed: Affine2D = pose @ cells
    return composed


def _cells_from_xy(grid: GridMap) -> Affine2D:
    return _xy_from_cells(grid.T_frame_grid, grid.resolution).inv()
