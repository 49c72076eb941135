# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Places, rays and lines on rasters; compiled where every cell of a map is asked for."""

from __future__ import annotations

from typing import TypeVar

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Scalar = TypeVar('Scalar', bound=np.generic)


@njit(cache=True, nogil=True, inline='always')
def nearest_cell(A: Array, x: float, y: float) -> tuple[int, int]:
    """Return the cell nearest to a point [m]; ``A (2, 3)`` maps metres to (row, column)."""
    row = int(np.floor(A[0, 0] * x + A[0, 1] * y + A[0, 2] + 0.5))
    col = int(np.floor(A[1, 0] * x + A[1, 1] * y + A[1, 2] + 0.5))
    return row, col


@njit(cache=True, nogil=True)
def is_inside(mask: NDArray[np.bool_], row: float, col: float, outside: bool) -> bool:
    """Return the ``mask (H, W)`` at the nearest cell, ``outside`` beyond its edge."""
    r, c = int(np.floor(row + 0.5)), int(np.floor(col + 0.5))
    if r < 0 or c < 0 or r >= mask.shape[0] or c >= mask.shape[1]:
        return outside
    return bool(mask[r, c])


@njit(cache=True, nogil=True)
def run_length(
    mask: NDArray[np.bool_],
    outside: bool,
    row: float,
    col: float,
    d_row: float,
    d_col: float,
    limit: float,
) -> float:
    """Return how far ``mask`` stays True from a place on, up to ``limit`` [cells]."""
    run = 0.0
    while run < limit and is_inside(mask, row + run * d_row, col + run * d_col, outside):
        run += 0.5
    return run


def cells_at(rc: Array, shape: tuple[int, ...]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Return rows and columns (...) of the cells nearest to places ``rc (..., 2)``.

    Places beyond a raster of ``shape`` get the cell of its edge.
    """
    cells = np.clip(np.rint(rc), 0, np.array(shape[:2]) - 1).astype(np.int64)
    return cells[..., 0], cells[..., 1]


def values_at(values: NDArray[Scalar], rc: Array, outside: float) -> NDArray[Scalar]:
    """Return ``values (H, W)`` at the cells nearest to ``rc (..., 2)``, ``outside`` beyond."""
    nearest = np.rint(rc)
    is_inside = ((nearest >= 0) & (nearest < values.shape)).all(axis=-1)
    beyond = np.asarray(outside, values.dtype)
    return np.where(is_inside, values[cells_at(rc, values.shape)], beyond)


def draw_line(cells: NDArray[np.uint8], ends: Array) -> None:
    """
    Set ``cells (H, W)`` along a line to 1, in place; no path of neighbours crosses it.

    ``ends (2, 2)`` are row and column of its ends.
    """
    start, stop = np.rint(ends[:, ::-1]).astype(int).tolist()
    cv2.line(cells, start, stop, 1, thickness=2)
