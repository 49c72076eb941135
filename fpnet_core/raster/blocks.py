# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blocks of raster cells: means, logical or, middle cells, and expansion back to cells."""

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
    rows, cols = (_parts_of(size, max(spacing, 1.0)) for size in mask.shape)
    above = cv2.integral(mask.view(np.uint8))  # count of True cells above and left of each corner
    in_cols = np.diff(np.diff(above[:, cols], axis=1), axis=0)
    in_rows = np.diff(np.diff(above[rows], axis=0), axis=1)
    count = np.diff(np.diff(above[rows][:, cols], axis=0), axis=1).ravel()
    row = np.add.reduceat(in_cols * np.arange(len(mask))[:, None], rows[:-1], axis=0).ravel()
    col = np.add.reduceat(in_rows * np.arange(mask.shape[1]), cols[:-1], axis=1).ravel()
    is_filled = count > 0
    return np.stack([row, col], axis=1)[is_filled] / count[is_filled, None]


def _parts_of(size: int, spacing: float) -> NDArray[np.int64]:
    """Return the first of ``size`` indices in each part, and ``size``."""
    part = (np.arange(size) / spacing).astype(np.int64)
    return np.flatnonzero(np.diff(part, prepend=-1, append=size))
