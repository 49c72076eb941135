# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rasters in blocks of cells: means, any of a block, their middles, and back."""

from __future__ import annotations

from typing import TypeVar

import cv2
from numba import njit
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


@njit(cache=True, nogil=True)
def block_counts(mask: NDArray[np.bool_], side: int) -> NDArray[np.int64]:
    """Return how many True cells (ceil(H / side), ceil(W / side)) blocks have."""
    rows, cols = mask.shape
    counts = np.zeros((-(-rows // side), -(-cols // side)), np.int64)
    for row in range(rows):
        for k in range(counts.shape[1]):
            count = 0
            for col in range(k * side, min((k + 1) * side, cols)):
                count += mask[row, col]
            counts[row // side, k] += count
    return counts


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
    return np.asarray(_unblocked(np.ascontiguousarray(blocks), side, rows, cols))


@njit(cache=True, nogil=True)
def _unblocked(blocks, side, rows, cols):  # type: ignore[no-untyped-def]
    """Return what :func:`unblocked` does."""
    raster, whole = np.empty((rows, cols), blocks.dtype), cols // side
    for first in range(0, rows, side):
        k, own = first // side, raster[first]
        # No column is divided, and no loop has a loop in it: several are written at once then.
        if side == 2:
            for block in range(whole):
                own[2 * block] = blocks[k, block]
                own[2 * block + 1] = blocks[k, block]
        else:
            for offset in range(side):
                every = own[offset : whole * side : side]
                for block in range(whole):
                    every[block] = blocks[k, block]
        for col in range(whole * side, cols):
            own[col] = blocks[k, whole]
        for row in range(first + 1, min(first + side, rows)):
            raster[row] = own
    return raster


def thinned(mask: NDArray[np.bool_], spacing: float) -> NDArray[np.float64]:
    """Return mean (row, column) (P, 2) of the True cells in each block of ``spacing`` cells."""
    sums = _block_sums(mask, max(spacing, 1.0)).reshape(-1, 3)
    sums = sums[sums[:, 2] > 0]
    return np.asarray(sums[:, :2] / sums[:, 2:], dtype=np.float64)


@njit(cache=True, nogil=True)
def _block_sums(mask: NDArray[np.bool_], spacing: float) -> NDArray[np.float64]:
    """Return sums of rows and of columns, and counts of True cells, by block (h, w, 3)."""
    rows, cols = mask.shape
    sums = np.zeros((int(rows / spacing) + 1, int(cols / spacing) + 1, 3))
    across = (np.arange(cols) / spacing).astype(np.int64)
    for row in range(rows):
        r = int(row / spacing)
        for col in range(cols):
            if mask[row, col]:
                c = across[col]
                sums[r, c, 0] += row
                sums[r, c, 1] += col
                sums[r, c, 2] += 1
    return sums
