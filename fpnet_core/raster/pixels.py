# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Transforms between pixels and metres, between pictures, and to OpenCV's drawing coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2, Affine2D, scale_of
from fpnet_core.types import GridMap

Array = NDArray[np.float64]

PIXEL_BITS = 4
"""Numerical: fractional bits of coordinates passed to OpenCV's drawing functions."""


def pixel_to_xy(grid: GridMap) -> Affine2D:
    """
    Return the map from image pixels to metres in the grid's frame.

    Pixels are (x right, y down) in the image as stored; integers are pixel centres, so (0, 0) is
    the centre of the top left pixel. The map is a reflection, as y changes its sense.
    """
    half = 0.5 * grid.resolution
    height_m = grid.shape[0] * grid.resolution
    A_grid_pixel = Affine2D(
        np.diag([grid.resolution, -grid.resolution]), np.array([half, height_m - half])
    )
    A_frame_pixel: Affine2D = grid.T_frame_grid @ A_grid_pixel
    return A_frame_pixel


def column_to_xy(T_frame_grid: SE2, resolution: float) -> Affine2D:
    """Return the map from (column, row) of a grid, integers at cell centres, to metres."""
    half = np.full(2, 0.5 * resolution)
    A_frame_cell: Affine2D = T_frame_grid @ Affine2D(resolution * np.eye(2), half)
    return A_frame_cell


def xy_to_rc(grid: GridMap, step: int) -> Array:
    """
    Return the affine (2, 3) from metres to fractional (row, column) of a coarser raster.

    The raster is the result of :func:`fpnet_core.raster.blocks.block_middles` with ``step`` cells.
    """
    inverse = grid.T_frame_grid.inv()
    scale = 1.0 / (grid.resolution * step)
    offset = (0.5 + (step - 1) // 2) / step
    linear = inverse.linear[::-1] * scale
    return np.column_stack([linear, inverse.translation[::-1] * scale - offset])


def corners_xy(grid: GridMap) -> Array:
    """Return the outer corners (4, 2) of a grid [m]: two of its first row, two of its last."""
    rows, cols = grid.shape
    edge = [[-0.5, -0.5], [-0.5, cols - 0.5], [rows - 0.5, -0.5], [rows - 0.5, cols - 0.5]]
    return grid.rc_to_xy(edge)


def shrinking(factor: float | tuple[float, float]) -> Array:
    """Return the affine (3, 3) from a picture's pixel centres to those of the resized picture."""
    x, y = (factor, factor) if isinstance(factor, float) else factor
    return np.array([[x, 0.0, 0.5 * x - 0.5], [0.0, y, 0.5 * y - 0.5], [0.0, 0.0, 1.0]])


def cut_from(left: float, top: float) -> Array:
    """Return the affine (3, 3) from a picture's pixels to those of a crop."""
    return np.array([[1.0, 0.0, -left], [0.0, 1.0, -top], [0.0, 0.0, 1.0]])


def map_points(H: NDArray[Any], points: NDArray[Any]) -> Array:
    """Map ``points (..., 2)`` by a homography (3, 3)."""
    lifted = np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1) @ H.T
    return np.asarray(lifted[..., :2] / lifted[..., 2:])


def growth_at(H: Array, place: NDArray[Any]) -> float:
    """Return the local scale factor of a homography (3, 3) at a place (2,)."""
    x, y, w = H @ np.append(place, 1.0)
    jacobian = (H[:2, :2] - np.outer((x / w, y / w), H[2, :2])) / w
    return float(scale_of(jacobian))


def fixed_point(pixels: Array, bits: int = PIXEL_BITS) -> NDArray[np.int32]:
    """
    Return ``pixels (..., 2)`` in OpenCV's fixed-point format for ``shift=bits``.

    Pixels are (x, y), integers at pixel centres.
    """
    return np.asarray(np.rint(pixels * (1 << bits)), dtype=np.int32)
