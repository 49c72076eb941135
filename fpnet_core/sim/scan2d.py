# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fast planar ray casting in occupancy rasters, and the tours that robots take through them.

Rasters are indexed [row, column] with row 0 at the lowest y; positions are in cells from the
raster's outer corner, so that cell (r, c) covers [c, c + 1) x [r, r + 1).
"""

from __future__ import annotations

from typing import Any

from numba import njit
import numpy as np
from numpy.typing import NDArray

EMPTY, SOLID, GLASS, LINTEL = 0, 1, 2, 3
"""Codes of a world raster; a ray passes glass with some probability."""

MISS = -1.0
"""Range of a ray that met nothing within reach."""


@njit(cache=True)
def cast_rays(
    world: Any, x: float, y: float, angles: Any, max_cells: float, glass_pass: Any
) -> tuple[Any, Any]:
    """
    Return ranges (A,) float64 in cells to the first obstacle, and its code (A,) uint8.

    ``world (H, W) uint8`` holds codes; ``glass_pass (A,) bool`` says which rays pass glass.
    Rays that leave the raster or reach ``max_cells`` are ``MISS`` with code ``EMPTY``.
    """
    rows, cols = world.shape
    count = angles.shape[0]
    ranges = np.full(count, MISS)
    codes = np.zeros(count, np.uint8)
    for i in range(count):
        dx, dy = np.cos(angles[i]), np.sin(angles[i])
        col, row = int(np.floor(x)), int(np.floor(y))
        step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
        delta_x = abs(1.0 / dx) if dx != 0.0 else 1e18
        delta_y = abs(1.0 / dy) if dy != 0.0 else 1e18
        next_x = (col + 1 - x if dx > 0.0 else x - col) * delta_x
        next_y = (row + 1 - y if dy > 0.0 else y - row) * delta_y
        travelled = 0.0
        while travelled < max_cells:
            if next_x < next_y:
                travelled = next_x
                next_x += delta_x
                col += step_x
            else:
                travelled = next_y
                next_y += delta_y
                row += step_y
            if col < 0 or row < 0 or col >= cols or row >= rows:
                break
            code = world[row, col]
            if code != 0 and not (code == 2 and glass_pass[i]):
                if travelled < max_cells:
                    ranges[i] = travelled
                    codes[i] = code
                break
    return ranges, codes


@njit(cache=True)
def carve(free: Any, x: float, y: float, angles: Any, ranges: Any) -> None:
    """Count, in ``free (H, W) uint16``, the cells that rays of ``ranges (A,)`` cells cross."""
    rows, cols = free.shape
    for i in range(angles.shape[0]):
        reach = ranges[i]
        dx, dy = np.cos(angles[i]), np.sin(angles[i])
        col, row = int(np.floor(x)), int(np.floor(y))
        step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
        delta_x = abs(1.0 / dx) if dx != 0.0 else 1e18
        delta_y = abs(1.0 / dy) if dy != 0.0 else 1e18
        next_x = (col + 1 - x if dx > 0.0 else x - col) * delta_x
        next_y = (row + 1 - y if dy > 0.0 else y - row) * delta_y
        while col >= 0 and row >= 0 and col < cols and row < rows:
            if free[row, col] < 65535:
                free[row, col] += 1
            if next_x < next_y:
                if next_x >= reach:
                    break
                next_x += delta_x
                col += step_x
            else:
                if next_y >= reach:
                    break
                next_y += delta_y
                row += step_y


@njit(cache=True)
def mark_ends(counts: Any, x: float, y: float, angles: Any, ranges: Any, is_marked: Any) -> None:
    """Count, in ``counts (H, W) uint16``, the cells in which marked rays end."""
    rows, cols = counts.shape
    for i in range(angles.shape[0]):
        if is_marked[i]:
            col = int(np.floor(x + ranges[i] * np.cos(angles[i])))
            row = int(np.floor(y + ranges[i] * np.sin(angles[i])))
            if 0 <= row < rows and 0 <= col < cols and counts[row, col] < 65535:
                counts[row, col] += 1


@njit(cache=True)
def walk_field(passable: Any, start_row: int, start_col: int) -> tuple[Any, Any]:
    """
    Return predecessors (H * W,) int32 and lengths (H * W,) float32 of walks from the start.

    Predecessors are flat indices, -1 where the start cannot be reached; the start is its own.
    Lengths are in cells, infinite where unreachable.
    Breadth first with the four straight moves before the diagonal ones, which do not cut
    corners of ``passable (H, W) bool``.
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
    """Return the walk (S, 2) of rows and columns from the field's start to a reached cell."""
    here = row * cols + col
    walk = [here]
    while previous[here] != here:
        here = int(previous[here])
        walk.append(here)
    flat = np.array(walk[::-1], dtype=np.int64)
    return np.stack([flat // cols, flat % cols], axis=1)
