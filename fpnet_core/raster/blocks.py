# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rasters in blocks of cells: means, any of a block, their middles, and back."""

from __future__ import annotations

from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.windows import framed

Scalar = TypeVar('Scalar', bound=np.generic)


def block_means(
    values: NDArray[np.float32], side: int, beyond: float = 0.0
) -> NDArray[np.float32]:
    """
    Return the means (ceil(H / side), ceil(W / side)) of blocks of ``values (H, W)``.

    ``beyond`` fills the blocks that reach beyond the edge.
    """
    padded = _whole_blocks(values, side, beyond)
    size = (padded.shape[1] // side, padded.shape[0] // side)
    return np.asarray(cv2.resize(padded, size, interpolation=cv2.INTER_AREA), np.float32)


def block_any(mask: NDArray[np.bool_], side: int, is_beyond: bool = False) -> NDArray[np.bool_]:
    """
    Return which blocks (ceil(H / side), ceil(W / side)) hold a True cell.

    ``is_beyond`` tells that those do which reach beyond the edge.
    """
    if side == 1:
        return mask
    padded = _whole_blocks(mask, side, is_beyond)
    # Rows first: their cells lie side by side, and those of columns do not.
    tall = padded[::side].copy()
    for row in range(1, side):
        tall |= padded[row::side]
    found = tall[:, ::side].copy()
    for col in range(1, side):
        found |= tall[:, col::side]
    return found


def block_counts(mask: NDArray[np.bool_], side: int) -> NDArray[np.int64]:
    """Return how many True cells (ceil(H / side), ceil(W / side)) blocks have."""
    means = block_means(mask.astype(np.float32), side)
    return np.rint(means * side**2).astype(np.int64)


def _whole_blocks(values: NDArray[Scalar], side: int, beyond: float) -> NDArray[Scalar]:
    """Return ``values (H, W)`` with ``beyond`` added up to whole blocks."""
    rows, cols = values.shape
    if rows % side == 0 and cols % side == 0:
        return values
    return framed(values, (0, 0), (-rows % side, -cols % side), beyond)


def block_middles(raster: NDArray[Scalar], side: int) -> NDArray[Scalar]:
    """Return the cell at the middle of each block, the one before it where ``side`` is even."""
    first = (side - 1) // 2
    return np.ascontiguousarray(raster[first::side, first::side])


def unblocked(
    blocks: NDArray[Scalar], side: int, shape: tuple[int, ...] | None = None
) -> NDArray[Scalar]:
    """Return a raster of ``shape`` (all of the blocks for None), each cell as its block is."""
    rows, cols = shape or (side * blocks.shape[0], side * blocks.shape[1])
    # Along rows first: those are copied as a whole then.
    return np.repeat(np.repeat(blocks, side, axis=1)[:, :cols], side, axis=0)[:rows]


def thinned(mask: NDArray[np.bool_], spacing: float) -> NDArray[np.float64]:
    """Return mean (row, column) (P, 2) of the True cells in each block of ``spacing`` cells."""
    bounds = []
    for size in mask.shape:
        block = (np.arange(size) / max(spacing, 1.0)).astype(np.int64)
        bounds.append(np.flatnonzero(np.diff(block, prepend=-1, append=size)))
    down, across = bounds
    # Sums over all cells before each: what lies between two of them is looked up.
    before = np.asarray(cv2.integral(mask.view(np.uint8)))
    by_row = np.diff(np.diff(before[:, across]), axis=0)  # row, block
    by_col = np.diff(np.diff(before[down], axis=0))  # block, column
    cells = np.add.reduceat(by_row, down[:-1], axis=0)
    row, col = (np.arange(size) for size in mask.shape)
    row_sums = np.add.reduceat(by_row * row[:, None], down[:-1], axis=0)
    col_sums = np.add.reduceat(by_col * col, across[:-1], axis=1)
    is_any = cells > 0
    return np.stack([row_sums[is_any], col_sums[is_any]], axis=1) / cells[is_any, None]
