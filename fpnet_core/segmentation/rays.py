# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rays through masks, compiled: how far a straight line stays inside."""

from __future__ import annotations

from numba import njit
import numpy as np
from numpy.typing import NDArray


@njit(cache=True)
def is_inside(mask: NDArray[np.bool_], row: float, col: float, outside: bool) -> bool:
    """Return the ``mask (H, W)`` at the nearest cell, ``outside`` beyond its edge."""
    r, c = int(np.floor(row + 0.5)), int(np.floor(col + 0.5))
    if r < 0 or c < 0 or r >= mask.shape[0] or c >= mask.shape[1]:
        return outside
    return bool(mask[r, c])


@njit(cache=True)
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
