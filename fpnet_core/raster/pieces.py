# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Connected pieces of masks."""

from __future__ import annotations

from typing import TypeVar

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.windows import Window, cells_of, framed

Scalar = TypeVar('Scalar', bound=np.generic)

_FLOODED = 2  # numerical: marks what a flood has reached


def pieces_of(mask: Mask, connectivity: int = 8) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """
    Return labels (H, W) of the pieces of ``mask (H, W)``, 0 outside, and figures (N, 5) of each.

    The figures are left, top, width, height and area in cells, as OpenCV's ``CC_STAT`` names
    them; the first row is all that is no piece. Diagonal neighbours join for ``connectivity`` 8,
    not for 4.
    """
    # OpenCV's own figures take five times as long as all else.
    count, found = cv2.connectedComponents(mask.view(np.uint8), connectivity=connectivity)
    labels = np.asarray(found, np.int32)
    top, left, bottom, right, area = _label_ends(labels, count)[:, :5].astype(np.int32).T
    return labels, np.stack([left, top, right - left, bottom - top, area], axis=1)


def filled(mask: Mask) -> Mask:
    """Return ``mask (H, W)`` with its holes."""
    contours, _ = cv2.findContours(mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    whole = np.zeros(mask.shape, dtype=np.uint8)
    cv2.drawContours(whole, contours, -1, 1, -1)
    return whole.view(np.bool_)


def reached_from_edge(mask: Mask) -> Mask:
    """Return what of ``mask (H, W)`` hangs together with its outermost cells, across sides."""
    # A frame joins whatever lies at the edge: one flood is far cheaper than all pieces.
    flooded = framed(mask, (1, 1), (1, 1), True).view(np.uint8)
    cv2.floodFill(flooded, None, (0, 0), _FLOODED)
    return np.ascontiguousarray(flooded[1:-1, 1:-1] == _FLOODED)


def pieces_of_few(mask: Mask) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Return the True cells (K, 2) of ``mask (H, W)``, row by row, and the piece (K,) of each.

    Diagonal neighbours join. Pieces are numbered from 0 on, in the order of :func:`pieces_of`,
    which takes far longer where cells are few.
    """
    cells = cells_of(mask)
    root = _joined(cells)
    # OpenCV meets pieces block by block of two cells a side.
    blocks = (cells[:, 0] // 2) * mask.shape[1] + cells[:, 1] // 2
    first = np.full(len(cells), np.iinfo(np.int64).max)
    np.minimum.at(first, root, blocks)
    return cells, np.unique(first[root], return_inverse=True)[1]


@njit(cache=True, nogil=True)
def _joined(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return for each of ``cells (K, 2)``, row by row, one that stands for its piece."""
    root, above = np.arange(len(cells)), 0
    for k in range(len(cells)):
        row, col = cells[k]
        while cells[above, 0] < row - 1 or (cells[above, 0] < row and cells[above, 1] < col - 1):
            above += 1
        near = above
        while cells[near, 0] < row and cells[near, 1] <= col + 1:
            _join(root, near, k)
            near += 1
        if k and cells[k - 1, 0] == row and cells[k - 1, 1] == col - 1:
            _join(root, k - 1, k)
    for k in range(len(cells)):
        root[k] = root_of(root, k)
    return root


@njit(cache=True, nogil=True)
def root_of(root: NDArray[np.int64], k: int) -> int:
    """Return what stands for the piece that ``k`` has joined, and make the way to it shorter."""
    while root[k] != k:
        root[k] = root[root[k]]
        k = root[k]
    return k


@njit(cache=True, nogil=True)
def _join(root: NDArray[np.int64], a: int, b: int) -> None:
    """Make two cells' pieces one."""
    root[root_of(root, b)] = root_of(root, a)


def looked_up(labels: NDArray[np.int32], values: NDArray[Scalar]) -> NDArray[Scalar]:
    """Return the one of ``values (N,)`` that each of ``labels (H, W)`` numbers."""
    found = np.empty(labels.shape, values.dtype)
    look_up(labels, values, found)
    return found


@njit(cache=True, nogil=True)
def look_up(labels, values, found):  # type: ignore[no-untyped-def]
    """Write what :func:`looked_up` returns to ``found (H, W)``, which may be the labels."""
    for row in range(labels.shape[0]):
        own, to = labels[row], found[row]
        for col in range(len(own)):
            # A number that cannot be negative is not counted from the end.
            to[col] = values[np.uint32(own[col])]


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
        own, value, first = labels[row], values[row], 0
        # Most cells have the label of the one before.
        while first < len(own):
            label, end, most = own[first], first, np.float32(0.0)
            while end < len(own) and own[end] == label:
                most = max(most, value[end])
                end += 1
            sizes[label] += end - first
            largest[label] = max(largest[label], most)
            first = end
    return sizes, largest


@njit(cache=True, nogil=True)
def shared_cells(
    ours: NDArray[np.int32], theirs: NDArray[np.int32], most_ours: int, most_theirs: int
) -> NDArray[np.int64]:
    """
    Return how many cells each label of one raster shares with each of another, 0 left out.

    ``ours`` and ``theirs (H, W)`` have labels up to M and N; the result is (M, N).
    """
    shared = np.zeros((most_ours + 1, most_theirs + 1), np.int64)
    for row in range(ours.shape[0]):
        a, b, first = ours[row], theirs[row], 0
        for col in range(1, len(a)):
            # Most cells share what those before them do.
            if a[col] != a[first] or b[col] != b[first]:
                shared[a[first], b[first]] += col - first
                first = col
        shared[a[first], b[first]] += len(a) - first
    return shared[1:, 1:]


def label_extents(
    labels: NDArray[np.int32], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """
    Return where labels (H, W) begin and end (count, 4), how many cells they have and their middle.

    First row and column, and those after the last; cells (count,); mean row and column (count, 2).
    A label without cells has zeros.
    """
    found = _label_ends(labels, count)
    ends, cells, first = found[:, :4], found[:, 4], found[:, :2]
    # Counted from where a label begins: what it is does not hang on where the raster does.
    sums = found[:, 5:] - first * cells[:, None]
    return ends, cells, sums / np.maximum(cells, 1)[:, None] + first


def cell_corners(mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """
    Return which corners ``(H + 1, W + 1)`` of cells belong to any of ``mask (H, W)``, 1 or 0.

    Their contours run exactly along the cells' outer edges; a corner is half a cell before the
    cell of its row and column.
    """
    padded = framed(mask, (0, 0), (1, 1)).view(np.uint8)
    return np.asarray(cv2.dilate(padded, np.ones((2, 2), np.uint8), anchor=(1, 1)), np.uint8)


def label_windows(labels: NDArray[np.int32]) -> dict[int, Window]:
    """Return the window of each label (H, W) that has cells, in the order of the labels, not 0."""
    ends = _label_ends(labels, int(labels.max(initial=0)) + 1)[:, :5].tolist()
    return {
        label: (slice(r0, r1), slice(c0, c1))
        for label, (r0, c0, r1, c1, _) in enumerate(ends)
        if label and r1 > 0
    }


@njit(cache=True, nogil=True)
def _label_ends(labels: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """
    Return first row and column, those after the last, cells, and sums of their places (count, 7).

    The sums are of rows and of columns; a label without cells has zeros.
    """
    ends = np.zeros((count, 7), np.int64)
    rows, cols = labels.shape
    for row in range(rows):
        col = 0
        while col < cols:
            label, first = labels[row, col], col
            while col < cols and labels[row, col] == label:
                col += 1
            end = ends[label]
            if end[4] == 0:
                end[0], end[1] = row, first
            end[1], end[2], end[3] = min(end[1], first), row + 1, max(end[3], col)
            end[4] += col - first
            end[5] += row * (col - first)
            end[6] += (first + col - 1) * (col - first) // 2
    return ends


def meeting_cells(labels: NDArray[np.int32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Return where ``labels (H, W)`` meet, as flat indices (K,) of cells and of neighbours.

    Neighbours have another label, and neither has 0; first come all to the right, then those in
    the next row, each kind row by row.
    """
    right, below = _meeting(labels, 0, 1), _meeting(labels, 1, 0)
    there = np.concatenate([right + 1, below + labels.shape[1]])
    return np.concatenate([right, below]), there


@njit(cache=True, nogil=True)
def _meeting(labels: NDArray[np.int32], down: int, right: int) -> NDArray[np.int64]:
    """Return the flat indices (K,) of cells that meet the neighbour so far off."""
    rows, cols = labels.shape
    count = 0
    for row in range(rows - down):
        for col in range(cols - right):
            count += labels[row, col] != labels[row + down, col + right]
    found, k = np.empty(count, np.int64), 0
    for row in range(rows - down):
        for col in range(cols - right):
            own, other = labels[row, col], labels[row + down, col + right]
            if own != other and own > 0 and other > 0:
                found[k] = row * cols + col
                k += 1
    return found[:k]


def longer_pieces(mask: Mask, length: float) -> Mask:
    """Return ``mask (H, W)`` without pieces of at most ``length`` cells along both axes."""
    labels, stats = pieces_of(mask)
    keep = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) > length
    keep[0] = False
    return np.asarray(keep[labels])
