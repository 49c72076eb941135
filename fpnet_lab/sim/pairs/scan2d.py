# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fast planar ray casting in occupancy rasters, and shortest walks of robots through them.

Rasters are indexed [row, column] with row 0 at the lowest y. Positions are in cells from the
raster's outer corner: cell (r, c) covers [c, c + 1) x [r, r + 1). Shape letters: ``S`` scans,
``A`` rays of a scan, ``L`` height layers.
"""

from __future__ import annotations

from typing import Any

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

EMPTY, SOLID, GLASS, LINTEL = 0, 1, 2, 3
"""Given: codes of a world raster; a ray passes glass with some probability."""

MISS = -1.0
"""Given: range of a ray without a hit within reach."""

# Numerical: shorter leaps are slower than single steps [cells].
_LEAST_LEAP = 2
# Numerical: distance to the next grid line of a ray that is parallel to it [cells].
_NEVER = 1e18


def clear_cells(is_empty: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """
    Return the distance (H, W) [cells] of each cell to the nearest obstacle, in the maximum norm.

    Values are 0 in obstacles and at most 255; ``is_empty (H, W)`` marks obstacle-free cells.
    """
    cells = cv2.distanceTransform(is_empty.astype(np.uint8), cv2.DIST_C, 3)
    return np.asarray(np.minimum(cells, 255.0), dtype=np.uint8)


@njit(cache=True)
def cast_rays(
    worlds: Any, clear: Any, starts: Any, directions: Any, max_cells: float, glass_pass: Any
) -> tuple[Any, Any]:
    """
    Return ranges (L, S, A) float64 [cells] to the first obstacle, and codes (L, S, A) uint8.

    Rays that leave the raster or reach ``max_cells`` have range ``MISS`` and code ``EMPTY``.

    Parameters
    ----------
    worlds : (L, H, W) uint8, codes; every ray is cast in every layer
    clear : (H, W) uint8, :func:`clear_cells` of the cells that are empty in all layers
    starts : (S, 2) float64, x and y in cells, inside the raster and outside of obstacles
    directions : (S, A, 2) float64, unit vectors
    max_cells : maximum range
    glass_pass : (S, A) bool, marks rays that pass glass
    """
    layers, rows, cols = worlds.shape
    scans, rays = directions.shape[:2]
    ranges = np.full((layers, scans, rays), MISS)
    codes = np.zeros((layers, scans, rays), np.uint8)
    for k in range(scans):
        x, y = starts[k, 0], starts[k, 1]
        for i in range(rays):
            dx, dy = directions[k, i, 0], directions[k, i, 1]
            grow_x = 1.0 / dx if dx != 0.0 else _NEVER
            grow_y = 1.0 / dy if dy != 0.0 else _NEVER
            step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
            ahead_x, ahead_y = (1 if dx >= 0.0 else 0), (1 if dy >= 0.0 else 0)
            leap = 1.0 / max(abs(dx), abs(dy))
            col, row = int(np.floor(x)), int(np.floor(y))
            space = clear[row, col]
            travelled, open_layers = 0.0, layers
            while open_layers > 0:
                # The square of this half width has no obstacle: leap to its border.
                if space > _LEAST_LEAP:
                    travelled += (space - 1) * leap
                    col, row = int(np.floor(x + travelled * dx)), int(np.floor(y + travelled * dy))
                else:
                    next_x = (col + ahead_x - x) * grow_x
                    next_y = (row + ahead_y - y) * grow_y
                    if next_x < next_y:
                        travelled = next_x
                        col += step_x
                    else:
                        travelled = next_y
                        row += step_y
                if travelled >= max_cells or col < 0 or row < 0 or col >= cols or row >= rows:
                    break
                space = clear[row, col]
                if space > 0:
                    continue
                for layer in range(layers):
                    code = worlds[layer, row, col]
                    if code == EMPTY or codes[layer, k, i] != EMPTY:
                        continue
                    if code != GLASS or not glass_pass[k, i]:
                        ranges[layer, k, i] = travelled
                        codes[layer, k, i] = code
                        open_layers -= 1
    return ranges, codes


@njit(cache=True)
def walk_field(passable: Any, start_row: int, start_col: int) -> tuple[Any, Any]:
    """
    Return predecessors (H * W,) int32 and path lengths (H * W,) float32 from the start.

    Predecessors are flat indices, -1 for unreachable cells; the start is its own predecessor.
    Lengths are in cells, infinite where unreachable.
    The search is breadth-first, with straight moves before diagonal ones. Diagonal moves do not
    cut corners of ``passable (H, W) bool``.
    """
    rows, cols = passable.shape
    previous = np.full(rows * cols, -1, np.int32)
    length = np.full(rows * cols, np.inf, np.float32)
    queue = np.empty(rows * cols, np.int32)
    moves = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))
    start = start_row * cols + start_col
    previous[start] = start
    length[start] = 0.0
    queue[0] = start
    head, tail = 0, 1
    while head < tail:
        here = queue[head]
        head += 1
        row, col = here // cols, here % cols
        for dr, dc in moves:
            r, c = row + dr, col + dc
            if r < 0 or c < 0 or r >= rows or c >= cols or not passable[r, c]:
                continue
            if dr != 0 and dc != 0 and not (passable[row, c] and passable[r, col]):
                continue
            there = r * cols + c
            if previous[there] < 0:
                previous[there] = here
                length[there] = length[here] + np.hypot(dr, dc)
                queue[tail] = there
                tail += 1
    return previous, length


def walk_to(previous: NDArray[np.int32], cols: int, row: int, col: int) -> NDArray[np.int64]:
    """Return the path (S, 2) of rows and columns from the field's start to a reached cell."""
    here = row * cols + col
    walk = [here]
    while previous[here] != here:
        here = int(previous[here])
        walk.append(here)
    flat = np.array(walk[::-1], dtype=np.int64)
    return np.stack([flat // cols, flat % cols], axis=1)
