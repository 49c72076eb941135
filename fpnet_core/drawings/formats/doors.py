# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection of door symbols in a vector drawing: a leaf and the arc of its swing.

Arcs are detected by geometry: many programs write them as short line segments on a coarse grid,
a few segments per path.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.pages import Array, OutlinePieces

DOOR_WIDTHS_M = (0.55, 1.45)
"""Physical: widths of the leaves of doors [m], toilet cabins to hospital beds."""

# Chosen, not measured:
_MIN_RUN = 5  # fewest segments of an arc
_MAX_TURN = np.radians(50.0)  # between segments of an arc; more is a corner
_EVEN = 4.0  # largest ratio of neighbouring segments of an arc
_ROUND = 0.03  # of the radius: largest distance of an arc's points from its circle
_SWEEP = (np.radians(25.0), np.radians(115.0))  # angles of a leaf that is drawn open
_QUARTER = (np.radians(78.0), np.radians(102.0))
_NEAR = 0.14  # of the radius: gap of a leaf at hinge and tip, from frames and thick leaves
_ALIKE = 1.8  # largest width ratio of doors without a leaf to those with one
_SIZE_SHARE = (0.0005, 0.12)  # of the sheet's long side: radius if the scale is unknown


@dataclass(frozen=True, eq=False)
class DoorArcs:
    """
    Circular arcs.

    ``centre (A, 2)``, ``radius (A,)``, ``sweep (A,)`` [rad], ``tips (A, 2, 2)``; ``arc (N,)`` is
    the index of the arc that a segment belongs to, -1 for none.
    """

    centre: Array
    radius: Array
    sweep: Array
    tips: Array
    arc: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Doors:
    """
    Doors with a drawn leaf, and the mask of all segments that draw doors.

    ``width (D,)``; ``hinge (D, 2)``; tips of the leaf: ``shut (D, 2)`` if closed and
    ``leaf (D, 2)`` as drawn; ``is_door (N,)``.
    """

    width: Array
    is_door: NDArray[np.bool_]
    hinge: Array = field(default_factory=lambda: np.empty((0, 2)))
    shut: Array = field(default_factory=lambda: np.empty((0, 2)))
    leaf: Array = field(default_factory=lambda: np.empty((0, 2)))


def find_arcs(pieces: OutlinePieces) -> DoorArcs:
    """Return the runs of joined segments that are parts of circles."""
    first, last = _runs(pieces)
    if not len(first):
        return _no_arcs(len(pieces.ends))
    size = last - first + 1
    members = np.repeat(first - np.cumsum(size) + size, size) + np.arange(size.sum())
    starts = np.cumsum(size) - size
    points, tips = pieces.ends[members, 0], _tips(pieces, first, last)
    centre, radius = _circles(points, starts, tips[:, 1], size)
    off = np.abs(np.hypot(*(points - np.repeat(centre, size, axis=0)).T) - np.repeat(radius, size))
    is_round = np.maximum.reduceat(off, starts) < _ROUND * radius
    length = np.add.reduceat(pieces.length[members], starts)
    chord = np.hypot(*(tips[:, 1] - tips[:, 0]).T)
    with np.errstate(invalid='ignore', divide='ignore'):
        sweep = 2.0 * np.arcsin(np.minimum(chord / (2.0 * radius), 1.0))
        # Segments on a coarse grid are longer than the arc; only long arcs need their length.
        sweep = np.where(length > 2.8 * radius, length / radius, sweep)
    is_round &= np.isfinite(radius) & (sweep > _SWEEP[0])
    number = np.where(is_round, np.cumsum(is_round) - 1, -1)
    arc = np.full(len(pieces.ends), -1)
    arc[members] = np.repeat(number, size)
    return DoorArcs(centre[is_round], radius[is_round], sweep[is_round], tips[is_round], arc)


def _runs(pieces: OutlinePieces) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first and the last segment of each run that could be an arc."""
    ends, length = pieces.ends, pieces.length
    if len(ends) < 2:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    direction = ends[:, 1] - ends[:, 0]
    cross = direction[:-1, 0] * direction[1:, 1] - direction[:-1, 1] * direction[1:, 0]
    turn = np.abs(np.arctan2(cross, (direction[:-1] * direction[1:]).sum(axis=1)))
    ratio = length[1:] / length[:-1]
    joined = (ends[1:, 0] == ends[:-1, 1]).all(axis=1) & (turn < _MAX_TURN)
    joined &= (ratio < _EVEN) & (ratio > 1.0 / _EVEN)
    breaks = np.flatnonzero(~joined)
    first = np.concatenate([[0], breaks + 1])
    last = np.concatenate([breaks, [len(ends) - 1]])
    is_long = last - first + 1 >= _MIN_RUN
    return first[is_long], last[is_long]


def _tips(pieces: OutlinePieces, first: NDArray[np.int64], last: NDArray[np.int64]) -> Array:
    return np.stack([pieces.ends[first, 0], pieces.ends[last, 1]], axis=1)


def _circles(
    points: Array, starts: NDArray[np.int64], tip: Array, size: NDArray[np.int64]
) -> tuple[Array, Array]:
    """
    Return the centres and radii of the best-fitting circles of runs of points.

    Algebraic fit of Kasa (1976), all runs at once; straight runs get a huge radius.
    """
    middle = np.add.reduceat(points, starts) / size[:, None]
    spread = np.maximum(np.hypot(*(tip - middle).T), 1e-12)
    local = (points - np.repeat(middle, size, axis=0)) / np.repeat(spread, size)[:, None]
    columns = np.column_stack([local, np.ones(len(local))])
    squares = (local**2).sum(axis=1)
    M = np.add.reduceat(columns[:, :, None] * columns[:, None, :], starts)
    v = np.add.reduceat(columns * squares[:, None], starts)
    solution = np.linalg.solve(M + 1e-12 * np.eye(3), v[..., None])[..., 0]
    centre = 0.5 * solution[:, :2]
    radius = np.sqrt(np.maximum(solution[:, 2] + (centre**2).sum(axis=1), 0.0))
    return middle + centre * spread[:, None], radius * spread


def find_doors(pieces: OutlinePieces, unit_m: float | None, size: float) -> Doors:
    """
    Return the doors of a drawing.

    Parameters
    ----------
    pieces : segments of all paths
    unit_m : metres per unit; None where unknown
    size : long side of the drawing in its units
    """
    arcs = find_arcs(pieces)
    low, high = np.multiply(_SIZE_SHARE, size)
    if unit_m is not None:
        low, high = np.divide(DOOR_WIDTHS_M, unit_m)
    fits = (arcs.radius > low) & (arcs.radius < high) & (arcs.sweep < _SWEEP[1])
    is_door = np.zeros(len(pieces.ends), dtype=np.bool_)
    if not fits.any():
        return Doors(np.empty(0), is_door)
    leaves, tip = _leaves(arcs, fits, pieces)
    has_leaf = tip >= 0
    is_quarter = fits & (arcs.sweep > _QUARTER[0]) & (arcs.sweep < _QUARTER[1])
    if has_leaf.any():
        typical = float(np.median(arcs.radius[has_leaf]))
        alike = np.abs(np.log(arcs.radius / typical)) < np.log(_ALIKE)
        drawn = has_leaf | (is_quarter & alike)
    else:
        drawn = is_quarter if unit_m is not None else np.zeros_like(is_quarter)
    is_door[leaves] = True
    is_door |= np.append(drawn, False)[arcs.arc]
    tips, tip = arcs.tips[has_leaf], tip[has_leaf]
    rows = np.arange(len(tip))
    return Doors(
        arcs.radius[has_leaf], is_door, arcs.centre[has_leaf], tips[rows, 1 - tip], tips[rows, tip]
    )


def _leaves(
    arcs: DoorArcs, fits: NDArray[np.bool_], pieces: OutlinePieces
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the segments from the hinge to a tip of an arc, and which tip; -1 for none."""
    straight = np.flatnonzero(arcs.arc < 0)
    tip = np.full(len(arcs.radius), -1)
    if not len(straight):
        return straight, tip
    points = pieces.ends[straight].reshape(-1, 2)
    by_x = np.argsort(points[:, 0])
    sorted_x = points[by_x, 0]
    found = [np.empty(0, np.int64)]
    for k in np.flatnonzero(fits):
        reach = _NEAR * arcs.radius[k]
        start, stop = np.searchsorted(sorted_x, arcs.centre[k, 0] + np.array([-reach, reach]))
        beside = by_x[start:stop]
        ends = beside[np.hypot(*(points[beside] - arcs.centre[k]).T) < reach]
        other = pieces.ends[straight[ends // 2], 1 - ends % 2]
        to_tip = np.hypot(*(other[:, None] - arcs.tips[k]).transpose(2, 0, 1))
        reaches = to_tip < _NEAR * arcs.radius[k]
        leaf = ends[reaches.any(axis=1)] // 2
        if len(leaf):
            tip[k] = int(np.argmin(to_tip.min(axis=0)))
        found.append(straight[leaf])
    return np.concatenate(found), tip


def _no_arcs(count: int) -> DoorArcs:
    none = np.empty(0)
    return DoorArcs(np.empty((0, 2)), none, none, np.empty((0, 2, 2)), np.full(count, -1))
