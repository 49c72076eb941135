# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Connected components of masks, and statistics of labels."""

from __future__ import annotations

from typing import TypeVar

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import unwritable
from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.windows import NEIGHBOURS, Window, cells_of, framed

Scalar = TypeVar('Scalar', bound=np.generic)

_NOTHING = np.zeros((0, 1), np.float32)
_FLOODED = 2  # numerical: value of cells that the flood has reached


def pieces_of(mask: Mask, connectivity: int = 8) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """
    Return labels (H, W) of the components of ``mask (H, W)``, 0 outside, and statistics (N, 5).

    The statistics are left, top, width, height and area in cells, as OpenCV's ``CC_STAT`` names
    them; the first row is the background. Diagonal neighbours are connected for ``connectivity``
    8, not for 4.
    """
    # OpenCV's own statistics take five times as long as the rest.
    count, found = cv2.connectedComponents(mask.view(np.uint8), connectivity=connectivity)
    labels = np.asarray(found, np.int32)
    top, left, bottom, right, area = _label_ends(labels, count)[:, :5].astype(np.int32).T
    return labels, np.stack([left, top, right - left, bottom - top, area], axis=1)


def filled(mask: Mask) -> Mask:
    """Return ``mask (H, W)`` with its holes filled."""
    contours, _ = cv2.findContours(mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    whole = np.zeros(mask.shape, dtype=np.uint8)
    cv2.drawContours(whole, contours, -1, 1, -1)
    return whole.view(np.bool_)


def reached_from_edge(mask: Mask) -> Mask:
    """Return the part of ``mask (H, W)`` connected to its outermost cells, by 4-connectivity."""
    # A frame connects all edge cells: one flood is far cheaper than labelling all components.
    flooded = framed(mask, (1, 1), (1, 1), True).view(np.uint8)
    cv2.floodFill(flooded, None, (0, 0), _FLOODED)
    return np.ascontiguousarray(flooded[1:-1, 1:-1] == _FLOODED)


def pieces_of_few(mask: Mask) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Return the True cells (K, 2) of ``mask (H, W)``, row by row, and the component (K,) of each.

    Diagonal neighbours are connected. Components count from 0, in the order of :func:`pieces_of`.
    """
    found, numbers = cells_of(mask), cv2.connectedComponents(mask.view(np.uint8))[1]
    return found, numbers[mask].astype(np.int64) - 1


def looked_up(labels: NDArray[np.int32], values: NDArray[Scalar]) -> NDArray[Scalar]:
    """Return ``values (N,)`` indexed by ``labels (H, W)``."""
    return np.take(values, labels)


def label_figures(
    labels: NDArray[np.int32], values: NDArray[np.float32], count: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """
    Return the number of cells (count,) and largest value (count,) of each of ``labels (H, W)``.

    ``values (H, W)`` are not negative; a label without cells has the value 0.
    """
    ends, largest = np.zeros((count, 7), np.int64), np.zeros(count, np.float32)
    _add_labels(unwritable(labels), unwritable(values), ends, largest)
    return ends[:, 4], largest


def shared_cells(
    ours: NDArray[np.int32], theirs: NDArray[np.int32], most_ours: int, most_theirs: int
) -> NDArray[np.int64]:
    """
    Return how many cells each label of one raster shares with each of another, without label 0.

    ``ours`` and ``theirs (H, W)`` have labels up to M and N; the result is (M, N).
    """
    both = (ours > 0) & (theirs > 0)
    shared = (ours[both].astype(np.int64) - 1) * most_theirs + theirs[both] - 1
    return np.bincount(shared, minlength=most_ours * most_theirs).reshape(most_ours, most_theirs)


def label_extents(
    labels: NDArray[np.int32], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """
    Return extents (count, 4) of labels (H, W), their numbers of cells and their centroids.

    Extents are first row and column, and those after the last; cells (count,); mean row and column
    (count, 2). A label without cells has zeros.
    """
    found = _label_ends(labels, count)
    ends, cells, first = found[:, :4], found[:, 4], found[:, :2]
    # Relative to the label's first cell: rounding does not depend on the raster's origin.
    sums = found[:, 5:] - first * cells[:, None]
    return ends, cells, sums / np.maximum(cells, 1)[:, None] + first


def cell_corners(mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """
    Return which corners ``(H + 1, W + 1)`` of cells belong to any of ``mask (H, W)``, 1 or 0.

    Their contours follow the cells' outer edges exactly. A corner is half a cell before the cell
    of the same row and column.
    """
    padded = framed(mask, (0, 0), (1, 1)).view(np.uint8)
    return np.asarray(cv2.dilate(padded, np.ones((2, 2), np.uint8), anchor=(1, 1)), np.uint8)


def label_windows(labels: NDArray[np.int32]) -> dict[int, Window]:
    """Return the window of each label (H, W) that has cells, in ascending order, without 0."""
    ends = _label_ends(labels, int(labels.max(initial=0)) + 1)[:, :5].tolist()
    return {
        label: (slice(r0, r1), slice(c0, c1))
        for label, (r0, c0, r1, c1, _) in enumerate(ends)
        if label and r1 > 0
    }


def _label_ends(labels: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """
    Return first row and column, those after the last, cells, and sums of their places (count, 7).

    The sums are of rows and of columns; a label without cells has zeros.
    """
    ends = np.zeros((count, 7), np.int64)
    _add_labels(unwritable(labels), unwritable(_NOTHING), ends, _NOTHING.reshape(-1))
    return ends


@njit(cache=True, nogil=True)
def _add_labels(labels, values, ends, largest):  # type: ignore[no-untyped-def]
    """Write the result of :func:`_label_ends`, and the largest values if there are any."""
    rows, cols = labels.shape
    for row in range(rows):
        col = 0
        while col < cols:
            label, first, most = labels[row, col], col, np.float32(0.0)
            if len(values):
                while col < cols and labels[row, col] == label:
                    most = max(most, values[row, col])
                    col += 1
                largest[label] = max(largest[label], most)
            else:
                while col < cols and labels[row, col] == label:
                    col += 1
            end = ends[label]
            if end[4] == 0:
                end[0], end[1] = row, first
            end[1] = min(end[1], first)
            end[3] = max(end[3], col)
            end[2] = row + 1
            end[4] += col - first
            end[5] += row * (col - first)
            end[6] += (first + col - 1) * (col - first) // 2


def meeting_cells(labels: NDArray[np.int32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Return where ``labels (H, W)`` meet, as flat indices (K,) of cells and of neighbours.

    Both labels differ and neither is 0. Neighbours to the right come first, then those in the next
    row, each kind row by row.
    """
    is_labelled, found = labels > 0, []
    for (here, there), ahead in zip(NEIGHBOURS, (1, labels.shape[1]), strict=True):
        meets = np.zeros(labels.shape, np.bool_)
        meets[here] = (labels[here] != labels[there]) & is_labelled[here] & is_labelled[there]
        cells = np.flatnonzero(meets)
        found.append((cells, cells + ahead))
    (right, to_right), (below, to_below) = found
    return np.concatenate([right, below]), np.concatenate([to_right, to_below])


def longer_pieces(mask: Mask, length: float) -> Mask:
    """Return ``mask (H, W)`` without components of at most ``length`` cells along both axes."""
    labels, stats = pieces_of(mask)
    keep = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) > length
    keep[0] = False
    return np.asarray(keep[labels])
