# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Exact Euclidean distance transform, bitwise reproducible whatever the memory layout.

It takes two passes (Felzenszwalb and Huttenlocher, 2012): distances within columns, then along
each row the lower envelope of the parabolas of their squares, in integers. The second pass is the
expensive one and covers only the requested cells.
"""

from __future__ import annotations

import math

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import unwritable

_NOWHERE = np.sqrt(np.finfo(np.float32).max)
"""Numerical: distance if there is no True cell; its square is finite."""


def cells_to_nearest(
    mask: NDArray[np.bool_],
    step: int = 1,
    where: NDArray[np.bool_] | None = None,
    most: float = np.inf,
) -> NDArray[np.float32]:
    """
    Return the distance (H, W) float32 from each cell to the nearest True cell, in cells.

    With ``step``, only for the middle cells of blocks of that side, as in
    :func:`~fpnet_core.raster.blocks.block_middles`. With ``where (H, W)``, only for its True
    cells, 0 elsewhere. Distances beyond ``most`` are only known to exceed it.
    """
    selected = np.ones((1, mask.shape[1]), np.bool_) if where is None else where
    rows, cols = mask.shape
    beyond = int(min(most, rows + cols - 1)) + 1
    first = (step - 1) // 2
    found = np.zeros((len(range(first, rows, step)), len(range(first, cols, step))), np.float32)
    down, lowest = _down_columns(unwritable(mask)), np.empty((3, cols + 1), np.int64)
    _along_rows(down, unwritable(selected), step, beyond, lowest, found)
    return found


@njit(cache=True, nogil=True)
def _down_columns(mask):  # type: ignore[no-untyped-def]
    """Return the distance (H, W) to the nearest True cell in a column; at least H + W if none."""
    rows, cols = mask.shape
    down = np.empty((rows, cols), np.int32)
    for row in range(rows):
        for col in range(cols):
            far = down[row - 1, col] + 1 if row else rows + cols
            down[row, col] = 0 if mask[row, col] else far
    for row in range(rows - 2, -1, -1):
        for col in range(cols):
            if down[row, col] > down[row + 1, col]:
                down[row, col] = down[row + 1, col] + 1
    return down


@njit(cache=True, nogil=True)
def _along_rows(down, selected, step, beyond, lowest, out):  # type: ignore[no-untyped-def]
    """
    Write the result of :func:`cells_to_nearest`; ``selected`` may be one row for all.

    ``lowest (3, W + 1)`` is memory for the parabolas of the lower envelope: each one's column, its
    height there and the first column where it is lowest. Columns whose distance is ``beyond`` or
    more have none.
    """
    cols, first = down.shape[1], (step - 1) // 2
    for k in range(len(out)):
        near, is_selected = down[first + k * step], selected[(first + k * step) % len(selected)]
        begin = 0
        while begin < cols:
            end = begin
            while end < cols and is_selected[end]:
                end += 1
            if end == begin:
                begin += 1
                continue
            # A distance changes by at most one from cell to cell.
            count, best = 0, 0
            for col in range(max(begin - near[begin], 0), min(end + near[end - 1], cols)):
                if near[col] >= beyond:
                    continue
                height, since = np.int64(near[col]) ** 2, -1
                while count:
                    place = lowest[0, count - 1]
                    # The integer crossing is at most half a column too far right; there both are
                    # equally low.
                    meet = col * col - place * place + height - lowest[1, count - 1]
                    since = math.floor(meet * (0.5 / (col - place))) + 1
                    if since > lowest[2, count - 1]:
                        break
                    count, since = count - 1, -1
                if since < end:
                    lowest[0, count], lowest[1, count], lowest[2, count] = col, height, since
                    count += 1
            for n in range((begin - first + step - 1) // step, (end - first + step - 1) // step):
                col = first + n * step
                while best + 1 < count and lowest[2, best + 1] <= col:
                    best += 1
                away = col - lowest[0, best]
                squared = np.float32(away * away + lowest[1, best])
                out[k, n] = np.sqrt(squared) if count else _NOWHERE
            begin = end


def clearance_of(free: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the distance (H, W) from each cell to the nearest cell not free or off the raster."""
    return cells_to_nearest(np.pad(~free, 1, constant_values=True))[1:-1, 1:-1]


def nearest_labels(
    labels: NDArray[np.int32],
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return approximate distances (H, W) to the nearest positive label [cells], and the label."""
    is_labelled = labels > 0
    cells, source = cv2.distanceTransformWithLabels(
        (~is_labelled).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    label_of = np.zeros(int(source.max()) + 1, np.int32)
    label_of[source[is_labelled]] = labels[is_labelled]
    return np.asarray(cells, np.float32), label_of[source]


def near_code(mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """
    Return squared distances (H, W) to the nearest True cell, 3 for everything beyond 2.

    Within a cell's eight neighbours they are 0, 1 and 2. This is far cheaper than all distances.
    """
    cells = mask.astype(np.uint8)
    beside = cv2.dilate(cells, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
    around = cv2.dilate(cells, np.ones((3, 3), np.uint8))
    return np.asarray(3 - cells - beside - around, dtype=np.uint8)
