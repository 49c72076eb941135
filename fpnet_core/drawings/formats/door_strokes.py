# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Doors on a layer of doors, drawn as strokes or boxes between jambs, without leaf and arc.

Sliding and glazed doors are drawn so, and doors in plans from databases. The layer's name is not
sufficient, as it also holds frames, leaves and numbers: a door must reach from wall to wall.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.doors import DOOR_WIDTHS_M
from fpnet_core.drawings.formats.pages import Array, OutlinePieces

# Chosen, not measured:
_JAMB_M = 0.15  # largest gap between the end of a door and its wall
_DEEPEST_M = 0.6  # thickest wall with a door
_PARALLEL = np.cos(np.radians(5.0))  # of the largest angle between strokes of one door
_BESIDE = 0.25  # of their length: largest shift between strokes of one door
_MOST = 4_000  # numerical: largest number of strokes of doors


@dataclass(frozen=True, eq=False)
class DoorStrokes:
    """Doors between jambs: ``ends (D, 2, 2)`` on centre lines of walls ``depth (D,)`` thick."""

    ends: Array
    depth: Array

    def corners(self, beyond: float) -> Array:
        """Return the doors' corners ``(D, 4, 2)``, ``beyond`` both faces of the wall."""
        start, end = self.ends[:, 0], self.ends[:, 1]
        along = (end - start) / np.hypot(*(end - start).T)[:, None]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        across *= (0.5 * self.depth + beyond)[:, None]
        return np.stack([start - across, end - across, end + across, start + across], axis=1)


def find_door_strokes(
    pieces: OutlinePieces, walls: OutlinePieces, unit_m: float | None
) -> DoorStrokes:
    """Return the doors in ``pieces`` of layers of doors; none if ``unit_m`` is unknown."""
    none = DoorStrokes(np.empty((0, 2, 2)), np.empty(0))
    if unit_m is None:
        return none
    low, high = DOOR_WIDTHS_M[0] / unit_m, 2.0 * DOOR_WIDTHS_M[1] / unit_m  # of two leaves
    fits = ~pieces.is_curve & (pieces.length > low) & (pieces.length < high)
    ends = pieces.ends[fits]
    if not (0 < len(ends) <= _MOST and len(walls.ends)):
        return none
    ends = ends[_reach(ends, walls, _JAMB_M / unit_m)]
    groups = _together(ends, _DEEPEST_M / unit_m)
    doors = [_middle(ends[groups == number]) for number in range(groups.max(initial=-1) + 1)]
    if not doors:
        return none
    return DoorStrokes(np.array([line for line, _ in doors]), np.array([d for _, d in doors]))


def _reach(ends: Array, walls: OutlinePieces, reach: float) -> NDArray[np.bool_]:
    """Return the mask of strokes with a wall at both ends."""
    import shapely

    tree, points = shapely.STRtree(shapely.linestrings(walls.ends)), shapely.points(ends)
    number, _ = tree.query(points.ravel(), predicate='dwithin', distance=reach)
    counts: NDArray[np.int64] = np.bincount(number, minlength=2 * len(ends))
    return np.asarray(counts.reshape(-1, 2).min(axis=1) > 0)


def _together(ends: Array, deepest: float) -> NDArray[np.int64]:
    """Return the door index of each stroke ``(S,)``; strokes beside each other are one door."""
    from scipy.sparse.csgraph import connected_components

    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(*along.T)
    along = along / length[:, None]
    offset = ends.mean(axis=1)[:, None] - ends.mean(axis=1)
    shift = np.abs(np.einsum('abi,ai->ab', offset, along))
    beside = np.abs(offset[..., 0] * along[:, None, 1] - offset[..., 1] * along[:, None, 0])
    is_same = (np.abs(along @ along.T) > _PARALLEL) & (beside < deepest)
    is_same &= shift < _BESIDE * length[:, None]
    _, numbers = connected_components(is_same, directed=False)
    return np.asarray(numbers, dtype=np.int64)


def _middle(strokes: Array) -> tuple[Array, float]:
    """Return the centre line (2, 2) of a door's strokes, and their distance."""
    longest = strokes[np.argmax(np.hypot(*(strokes[:, 1] - strokes[:, 0]).T))]
    along = (longest[1] - longest[0]) / np.hypot(*(longest[1] - longest[0]))
    frame = np.stack([along, [-along[1], along[0]]], axis=1)
    local = (strokes.reshape(-1, 2) - longest[0]) @ frame
    low, high = local.min(axis=0), local.max(axis=0)
    middle = 0.5 * (low[1] + high[1])
    line = np.array([[low[0], middle], [high[0], middle]]) @ frame.T + longest[0]
    return line, float(high[1] - low[1])
