# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Watershed of the clearance, and merging of its basins across shallow saddles."""

from __future__ import annotations

from dataclasses import dataclass

from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.pieces import label_figures, looked_up, meeting_cells
from fpnet_core.raster.windows import first_of_each, framed
from fpnet_core.segmentation.scene import WorkRaster

_MERGE_DEPTH_M = 0.02  # numerical: shallower constrictions are raster artefacts
# Numerical: clearances are sorted in steps of a millimetre. This allows a radix sort, and rounding
# does not decide ties.
_STEP_M = 1e-3


@dataclass(frozen=True, eq=False)
class Basins:
    """
    Catchment basins of the clearance's local maxima.

    ``labels (h, w)`` int32 is basin index + 1, 0 outside the mask; ``peaks (B,)`` is the largest
    clearance of each basin [m].
    """

    labels: NDArray[np.int32]
    peaks: NDArray[np.float32]


@njit(cache=True)
def _flood(
    height: NDArray[np.float32],
    mask: NDArray[np.bool_],
    order: NDArray[np.int64],
    labels: NDArray[np.int32],
) -> int:
    """
    Label cells in descending order by their highest labelled neighbour; count the basins.

    A diagonal neighbour counts only if a cell beside both is free. A wall drawn as a diagonal line
    of single cells is therefore closed.
    """
    cols = height.shape[1]
    count = 0
    for index in order:
        row, col = index // cols, index % cols
        best = np.int32(0)
        best_height = np.float32(-1.0)
        for d_row in range(-1, 2):
            for d_col in range(-1, 2):
                label = labels[row + d_row, col + d_col]
                if label == 0 or height[row + d_row, col + d_col] <= best_height:
                    continue
                if mask[row + d_row, col] or mask[row, col + d_col]:
                    best = label
                    best_height = height[row + d_row, col + d_col]
        if best == 0:
            count += 1
            best = np.int32(count)
        labels[row, col] = best
    return count


def grow_basins(work: WorkRaster) -> Basins:
    """
    Divide the working raster into one basin per local maximum of the clearance.

    Cells are visited from the widest place to the narrowest and join the basin of their steepest
    ascent: a watershed without markers. Zero free cells give zero basins.
    """
    mask = framed(work.mask, (1, 1), (1, 1))
    height = framed(work.clearance, (1, 1), (1, 1))
    cells = np.flatnonzero(mask)
    steps = np.minimum(height.ravel()[cells] / _STEP_M, 65535).astype(np.uint16)
    order = cells[np.argsort(65535 - steps, kind='stable')]
    labels = np.zeros(mask.shape, dtype=np.int32)
    count = _flood(height, mask, order, labels)
    _, peaks = label_figures(labels, height, count + 1)
    return Basins(np.ascontiguousarray(labels[1:-1, 1:-1]), peaks[1:])


def find_saddles(
    labels: NDArray[np.int32], clearance: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """
    Return the pairs of touching labels and the widest place of each shared boundary.

    Returns
    -------
    pairs (E, 2) int64 : labels, smaller first, each pair once; widest boundary first
    saddles (E,) float32 : clearance there [m], descending
    """
    base = int(labels.max(initial=0)) + 1
    sides = np.stack(meeting_cells(labels))
    low, high = np.sort(labels.ravel()[sides], axis=0).astype(np.int64)
    key, value = low * base + high, clearance.ravel()[sides].min(axis=0)
    widest = first_of_each(key, np.lexsort((key, -value)))
    pairs = key[widest]
    return np.stack([pairs // base, pairs % base], axis=1), value[widest]


def merge_shallow(basins: Basins, work: WorkRaster) -> NDArray[np.int32]:
    """Return labels (h, w), 0 outside, consecutive, with basins merged across shallow saddles."""
    pairs, saddles = find_saddles(basins.labels, work.clearance)
    parent = list(range(len(basins.peaks) + 1))
    peak = [0.0, *basins.peaks.tolist()]

    def root(basin: int) -> int:
        while parent[basin] != basin:
            parent[basin] = basin = parent[parent[basin]]
        return basin

    for pair, saddle in zip(pairs.tolist(), saddles.tolist(), strict=True):  # widest first
        keep, gone = sorted(map(root, pair), key=peak.__getitem__, reverse=True)
        if peak[gone] - saddle < _MERGE_DEPTH_M:
            parent[gone] = keep
    _, number = np.unique([root(basin) for basin in parent], return_inverse=True)
    return looked_up(basins.labels, number.astype(np.int32))
