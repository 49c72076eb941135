# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lookups, rays and lines on rasters; compiled where every cell of a map is visited."""

from __future__ import annotations

import math
from typing import TypeVar

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import unwritable

Array = NDArray[np.float64]
Scalar = TypeVar('Scalar', bound=np.generic)


@njit(cache=True, nogil=True, inline='always')
def nearest_cell(A: Array, x: float, y: float) -> tuple[int, int]:
    """Return the cell nearest to a point [m]; ``A (2, 3)`` maps metres to (row, column)."""
    row = int(np.floor(A[0, 0] * x + A[0, 1] * y + A[0, 2] + 0.5))
    col = int(np.floor(A[1, 0] * x + A[1, 1] * y + A[1, 2] + 0.5))
    return row, col


def marked(mask: NDArray[np.bool_], rc: Array, outside: bool) -> NDArray[np.bool_]:
    """Return ``mask (H, W)`` at the cells nearest to ``rc (..., 2)``, ``outside`` elsewhere."""
    rows, cols = np.floor(rc[..., 0] + 0.5), np.floor(rc[..., 1] + 0.5)
    is_on = (rows >= 0.0) & (cols >= 0.0) & (rows < mask.shape[0]) & (cols < mask.shape[1])
    flat = (rows * mask.shape[1] + cols)[is_on].astype(np.int64)
    found = np.full(is_on.shape, outside)
    found[is_on] = mask.reshape(-1)[flat]
    return found


def run_lengths(
    mask: NDArray[np.bool_],
    outside: bool,
    starts: Array,
    directions: Array,
    limits: Array | float,
    step: float = 0.5,
) -> Array:
    """
    Return the lengths (...) of rays in ``mask (H, W)``, in steps and about up to limits [cells].

    Rays go from ``starts (..., 2)`` along ``directions (..., 2)``; all shapes broadcast.
    """
    limits = np.asarray(limits, np.float64)
    shape = np.broadcast_shapes(starts.shape[:-1], directions.shape[:-1], limits.shape)
    rays = np.empty((*shape, 5))
    rays[..., :2], rays[..., 2:4], rays[..., 4] = starts, directions, limits
    runs = np.empty(shape)
    _run_lengths(unwritable(mask), outside, rays.reshape(-1, 5), step, runs.reshape(-1))
    return runs


@njit(cache=True, nogil=True)
def _run_lengths(mask, outside, rays, step, runs):  # type: ignore[no-untyped-def]
    """Write the lengths (N,) of rays (N, 5): start, direction and limit of each."""
    rows, cols = mask.shape
    for k in range(len(rays)):
        row, col, d_row, d_col = rays[k, 0], rays[k, 1], rays[k, 2], rays[k, 3]
        run = 0.0
        while run < rays[k, 4]:
            r = math.floor(row + run * d_row + 0.5)
            c = math.floor(col + run * d_col + 0.5)
            is_on = r >= 0 and c >= 0 and r < rows and c < cols
            if not (mask[r, c] if is_on else outside):
                break
            run += step
        runs[k] = run


def cells_at(rc: Array, shape: tuple[int, ...]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Return rows and columns (...) of the cells nearest to places ``rc (..., 2)``.

    Places off a raster of ``shape`` are clamped to its edge.
    """
    cells = np.clip(np.rint(rc), 0, np.array(shape[:2]) - 1).astype(np.int64)
    return cells[..., 0], cells[..., 1]


def values_at(values: NDArray[Scalar], rc: Array, outside: float) -> NDArray[Scalar]:
    """Return ``values (H, W)`` at the cells nearest to ``rc (..., 2)``, else ``outside``."""
    nearest = np.rint(rc)
    is_inside = ((nearest >= 0) & (nearest < values.shape)).all(axis=-1)
    beyond = np.asarray(outside, values.dtype)
    return np.where(is_inside, values[cells_at(rc, values.shape)], beyond)


def draw_line(cells: NDArray[np.uint8], ends: Array) -> None:
    """
    Set ``cells (H, W)`` along a line to 1, in place; no 8-connected path crosses it.

    ``ends (2, 2)`` are row and column of its ends.
    """
    start, stop = np.rint(ends[:, ::-1]).astype(int).tolist()
    cv2.line(cells, start, stop, 1, thickness=2)
