# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection of hatching: many parallel lines of one style, close together, evenly spaced.

Walls are parallel, too, but their distances alternate between those of walls and rooms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.pages import Array, OutlinePieces

# Chosen, not measured:
_MIN_LINES = 24  # at different positions; a flight of stairs has fewer
_ANGLE = np.radians(1.0)  # largest angle between parallel lines
_CLOSEST = 0.008  # of the drawing's long side: largest distance of lines, 0.4 m of 50 m
_SAME = 0.15  # of the distance: tolerance of equal positions and of even spacing
_EVEN_SHARE = 0.75  # of the distances are the typical one or a small multiple of it


def find_hatching(
    pieces: OutlinePieces, style: NDArray[np.int64], size: float
) -> NDArray[np.bool_]:
    """
    Return the mask ``(N,)`` of segments that are lines of a hatch.

    Parameters
    ----------
    pieces : segments of all paths
    style : (P,)
        Style index of each path: its colour, width and layer.
    size : long side of the drawing in its units
    """
    direction = pieces.ends[:, 1] - pieces.ends[:, 0]
    angle = np.mod(np.arctan2(direction[:, 1], direction[:, 0]) + 0.5 * _ANGLE, np.pi)
    slots = int(np.pi / _ANGLE) + 1
    key = style[pieces.path] * slots + (angle / _ANGLE).astype(np.int64)
    order = np.argsort(key, kind='stable')
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    is_hatch = np.zeros(len(key), dtype=np.bool_)
    for members in np.split(order, starts[1:]):
        if len(members) >= _MIN_LINES:
            is_hatch[members] = _is_even(pieces, members, _CLOSEST * size)
    return is_hatch


def _is_even(pieces: OutlinePieces, members: NDArray[np.int64], closest: float) -> bool:
    """Return whether parallel lines are close together at even distances."""
    ends = pieces.ends[members]
    longest = int(np.argmax(pieces.length[members]))
    along = (ends[longest, 1] - ends[longest, 0]) / pieces.length[members][longest]
    offsets = np.sort(ends.mean(axis=1) @ np.array([-along[1], along[0]]))
    gaps = np.diff(offsets)
    typical = _typical(gaps)
    if not 0.0 < typical < closest:
        return False
    gaps = gaps[gaps > _SAME * typical]
    near = gaps[gaps < 3.5 * typical]
    off = np.abs(near / typical - np.rint(near / typical))
    return len(near) + 1 >= _MIN_LINES and bool((off < _SAME).sum() >= _EVEN_SHARE * len(gaps))


def _typical(gaps: Array) -> float:
    """Return the median distance of lines at different positions."""
    apart = gaps[gaps > _SAME * gaps.mean()] if len(gaps) else gaps
    return float(np.median(apart)) if len(apart) else 0.0
