# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blocks of raster cells: means, logical or, middle cells, and expansion back to cells."""

from __future__ import annotations

from typing import TypeVar

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import unwritable
from fpnet_core.raster.windows import framed

Scalar = TypeVar('Scalar', bound=np.generic)


def block_means(
    values: NDArray[np.float32], side: int, beyond: float = 0.0
) -> NDArray[np.float32]:
    """
    Return the means (ceil(H / side), ceil(W / side)) of blocks of ``values (H, W)``.

    ``beyond`` pads blocks that extend past the edge.
    """
    padded = _whole_blocks(values, side, beyond)
    size = (padded.shape[1] // side, padded.shape[0] // side)
    return np.asarray(cv2.resize(padded, size, interpolation=cv2.INTER_AREA), np.float32)


def block_any(mask: NDArray[np.bool_], side: int, is_beyond: bool = False) -> NDArray[np.bool_]:
    """
    Return which blocks (ceil(H / side), ceil(W / side)) hold a True cell.

    ``is_beyond`` pads blocks that extend past the edge.
    """
    if side == 1:
        return mask
    padded = _whole_blocks(mask, side, is_beyond)
    # Rows first: their cells are contiguous in memory.
    tall = padded[::side].copy()
    for row in range(1, side):
        tall |= padded[row::side]
    found = tall[:, ::side].copy()
    for col in range(1, side):
        found |= tall[:, col::side]
    return found


def block_counts(mask: NDArray[np.bool_], side: int) -> NDArray[np.int64]:
    """Return the number of True cells (ceil(H / side), ceil(W / side)) per block."""
    means = block_means(mask.astype(np.float32), side)
    return np.rint(means * side**2).astype(np.int64)


def _whole_blocks(values: NDArray[Scalar], side: int, beyond: float) -> NDArray[Scalar]:
    """Return ``values (H, W)`` padded with ``beyond`` to whole blocks."""
    rows, cols = values.shape
    if rows % side == 0 and cols % side == 0:
        return values
    return framed(values, (0, 0), (-rows % side, -cols % side), beyond)


def block_middles(raster: NDArray[Scalar], side: int) -> NDArray[Scalar]:
    """Return the cell at the middle of each block, the one before it if ``side`` is even."""
    first = (side - 1) // 2
    return np.ascontiguousarray(raster[first::side, first::side])


def unblocked(
    blocks: NDArray[Scalar], side: int, shape: tuple[int, ...] | None = None
) -> NDArray[Scalar]:
    """Return a raster of ``shape`` (None: all blocks) in which each cell has its block's value."""
    rows, cols = shape or (side * blocks.shape[0], side * blocks.shape[1])
    # Along rows first: the second repeat then copies whole rows.
    return np.repeat(np.repeat(blocks, side, axis=1)[:, :cols], side, axis=0)[:rows]


def thinned(mask: NDArray[np.bool_], spacing: float) -> NDArray[np.float64]:
    """Return mean (row, column) (P, 2) of the True cells in each block of ``spacing`` cells."""
    sums = _block_sums(unwritable(mask), max(spacing, 1.0)).reshape(-1, 3)
    sums = sums[sums[:, 2] > 0]
    return np.asarray(sums[:, :2] / sums[:, 2:], dtype=np.float64)


@njit(cache=True, nogil=True)
def _block_sums(mask, spacing):  # type: ignore[no-untyped-def]
    """Return sums of rows and of columns, and counts of True cells, by block (h, w, 3)."""
    rows, cols = mask.shape
    sums = np.zeros((int(rows / spacing) + 1, int(cols / spacing) + 1, 3))
    across = np.empty(cols, np.int64)
    for col in range(cols):
        across[col] = int(col / spacing)
    for row in range(rows):
        r = int(row / spacing)
        for col in range(cols):
            if mask[row, col]:
                c = across[col]
                sums[r, c, 0] += row
                sums[r, c, 1] += col
                sums[r, c, 2] += 1
    return sums
