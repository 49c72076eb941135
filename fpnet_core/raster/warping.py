# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Resampling of grids in other frames."""

from __future__ import annotations

import cv2
import numpy as np

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.raster.pixels import column_to_xy, corners_xy
from fpnet_core.types import UNKNOWN, GridMap


def warping_of(
    grid: GridMap, A_map_plan: Affine2D, margin_m: float = 0.0
) -> tuple[SE2, tuple[int, int], Affine2D]:
    """
    Return how to resample a grid in ``map`` at its own resolution, with ``margin_m`` around it.

    Returns the origin of the result in ``map``, its columns and rows, and the affine from its
    (column, row) to the grid's, in OpenCV's convention.
    """
    corners = A_map_plan.apply(corners_xy(grid))
    low = corners.min(axis=0) - margin_m
    size = np.ceil((corners.max(axis=0) + margin_m - low) / grid.resolution).astype(int)
    T_map_grid = SE2.from_xy_yaw(float(low[0]), float(low[1]), 0.0)
    A_cell_map = column_to_xy(grid.T_frame_grid, grid.resolution).inv() @ A_map_plan.inv()
    A_source_target: Affine2D = A_cell_map @ column_to_xy(T_map_grid, grid.resolution)
    return T_map_grid, (int(size[0]), int(size[1])), A_source_target


def warped_grid(grid: GridMap, A_map_plan: Affine2D) -> GridMap:
    """Return a grid in ``map``: resampled at its own resolution, unknown around it."""
    if np.array_equal(A_map_plan.matrix, np.eye(3)):
        return grid
    T_map_grid, size, A_source_target = warping_of(grid, A_map_plan)
    cells = cv2.warpAffine(
        grid.cells.view(np.uint8),
        A_source_target.matrix[:2],
        size,
        flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=int(np.array(UNKNOWN, dtype=np.int8).view(np.uint8)),
    )
    return GridMap(cells.view(np.int8), grid.resolution, T_map_grid, 'map')
