# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Windows, borders and neighbours of rasters, and the first index of each key."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Window = tuple[slice, slice]
"""Rows and columns, with start and stop set."""
Scalar = TypeVar('Scalar', bound=np.generic)

_ALL, _HEAD, _TAIL = slice(None), slice(None, -1), slice(1, None)
NEIGHBOURS = (((_ALL, _HEAD), (_ALL, _TAIL)), ((_HEAD, _ALL), (_TAIL, _ALL)))
"""Slices that pair each cell with its right and its upper neighbour."""

EVERY_SIDE = (*NEIGHBOURS, *(pair[::-1] for pair in NEIGHBOURS))
"""Slices that pair each cell with each of its four neighbours."""

_LARGE_CELLS = 4_000_000  # numerical: 100 m x 100 m at 5 cm; smaller maps are cheap to process
_MARGIN_CELLS = 20  # numerical: so that the surroundings of the known part are still unknown


def window_of(mask: Mask) -> Window | None:
    """Return the smallest window with all True cells of ``mask (H, W)``; None without any."""
    rows, cols = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)


def known_window(known: Mask) -> Window:
    """
    Return the window of a map's known cells ``known (H, W)`` with a margin; all of a small map.

    Recorded maps are often allocated much larger than the area that was seen.
    """
    window = window_of(known) if known.size > _LARGE_CELLS else None
    if window is None:
        return slice(0, known.shape[0]), slice(0, known.shape[1])
    rows, cols = (
        slice(max(0, side.start - _MARGIN_CELLS), min(size, side.stop + _MARGIN_CELLS))
        for side, size in zip(window, known.shape, strict=True)
    )
    return rows, cols


def cells_of(mask: Mask) -> NDArray[np.int64]:
    """Return row and column (K, 2) of the True cells of ``mask (H, W)``, row by row."""
    # np.nonzero on two axes takes ten times as long as flat indices.
    return np.stack(np.divmod(np.flatnonzero(mask), mask.shape[1]), axis=1)


def cropped(values: NDArray[Scalar], window: Window, beyond: float) -> NDArray[Scalar]:
    """Return a window of ``values (H, W)``; cells off the raster are ``beyond``."""
    inner = tuple(
        slice(max(s.start, 0), min(s.stop, size))
        for s, size in zip(window, values.shape, strict=True)
    )
    above, left, below, right = (
        inner[0].start - window[0].start,
        inner[1].start - window[1].start,
        window[0].stop - inner[0].stop,
        window[1].stop - inner[1].stop,
    )
    found = values[inner]
    if not (above or left or below or right):
        return found
    return framed(found, (above, left), (below, right), beyond)


def framed(
    values: NDArray[Scalar], before: tuple[int, int], after: tuple[int, int], beyond: float = 0
) -> NDArray[Scalar]:
    """
    Return ``values (H, W)`` padded with ``beyond``: ``before`` and ``after`` rows and columns.

    The overhead of ``numpy.pad`` exceeds the work for a single room.
    """
    (above, left), (rows, cols) = before, values.shape
    size = above + rows + after[0], left + cols + after[1]
    found = np.full(size, beyond, values.dtype)
    found[above : above + rows, left : left + cols] = values
    return found


def border_of(values: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return the outermost rows and columns of ``values (H, W)`` concatenated, corners twice."""
    return np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])


def first_of_each(keys: NDArray[Any], order: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the indices (K,) of ``keys (N,)`` at which ``order (N,)`` first meets each key."""
    _, first = np.unique(keys[order], return_index=True)
    return np.asarray(order[np.sort(first)])
