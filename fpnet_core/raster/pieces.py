# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Connected pieces of masks."""

from __future__ import annotations

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.windows import Window


def pieces_of(mask: Mask, connectivity: int = 8) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """
    Return labels (H, W) of the pieces of ``mask (H, W)``, 0 outside, and figures (N, 5) of each.

    The figures are left, top, width, height and area in cells, as OpenCV's ``CC_STAT`` names
    them; the first row is all that is no piece. Diagonal neighbours join for ``connectivity`` 8,
    not for 4.
    """
    _, labels, stats, _ = cv2.connectedComponentsWithStats(
        mask.astype(np.uint8), connectivity=connectivity
    )
    return np.asarray(labels, np.int32), np.asarray(stats, np.int32)


@njit(cache=True, nogil=True)
def label_figures(
    labels: NDArray[np.int32], values: NDArray[np.float32], count: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """
    Return how many cells (count,) each of ``labels (H, W)`` has, and its largest value (count,).

    ``values (H, W)`` are not negative; a label without cells has the value 0.
    """
    sizes, largest = np.zeros(count, np.int64), np.zeros(count, np.float32)
    for row in range(labels.shape[0]):
        for col in range(labels.shape[1]):
            label = labels[row, col]
            sizes[label] += 1
            largest[label] = max(largest[label], values[row, col])
    return sizes, largest


def label_windows(labels: NDArray[np.int32]) -> dict[int, Window]:
    """Return the window of each label (H, W) that has cells, in the order of the labels, not 0."""
    ends = _label_ends(labels, int(labels.max(initial=0)) + 1).tolist()
    return {
        label: (slice(r0, r1), slice(c0, c1))
        for label, (r0, c0, r1, c1) in enumerate(ends)
        if label and r1 > 0
    }


@njit(cache=True, nogil=True)
def _label_ends(labels: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """Return first row and column and those after the last (count, 4); 0 after of none."""
    ends = np.zeros((count, 4), np.int64)
    for row in range(labels.shape[0]):
        for col in range(labels.shape[1]):
            end = ends[labels[row, col]]
            if end[2] == 0:
                end[0], end[1] = row, col
            end[1], end[2], end[3] = min(end[1], col), row + 1, max(end[3], col + 1)
    return ends


def longer_pieces(mask: Mask, length: float) -> Mask:
    """Return ``mask (H, W)`` without pieces of at most ``length`` cells along both axes."""
    labels, stats = pieces_of(mask)
    keep = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) > length
    keep[0] = False
    return np.asarray(keep[labels])
