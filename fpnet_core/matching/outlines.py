# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Comparison of the walls and floors seen in a submap with those drawn in the plan.

The plan's rooms are rasterized once; points on the walls and floors of a submap are then looked up
under each placement. Rectangles distinguish rooms of different size, outlines rooms of different
shape, also for partially seen rooms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import each_unwritable
from fpnet_core.raster.pixels import PIXEL_BITS, fixed_point

Array = NDArray[np.float64]

EXPLAINED = ('walls_apart', 'total_walls_apart', 'walls_met', 'floor_outside', 'rooms_mixed')
"""Features of a placement that :func:`explained` returns."""

_CELL = 0.1  # numerical: cell edge of the plan raster in its units, enlarged to...
_MOST_CELLS = 2_000_000  # numerical: ...keep it below this many cells
_FAR = 1.0  # numerical: plan units; depths are clipped here
_WALL_STEP, _FLOOR_STEP = 0.35, 0.5  # numerical: units between points on walls and on floors
_FLOOR_FINER = 5  # numerical
_MOST_POINTS = 400  # numerical: points on the walls of one map, and about as many on its floors
_FEW_POINTS = 48  # numerical: approximate number of points when many placements are compared
_AT_DOOR = 0.25  # chosen: units; points on walls nearer to a doorway than this are dropped
# Chosen, not measured:
_SPREAD = 0.2  # scale of the robust weights of wall distances, in plan units
_OUTSIDE = 0.5  # distance outside the plan's floor that counts in full, in plan units


@dataclass(frozen=True, eq=False)
class Painted:
    """
    Free space of a graph as rasters ``(H, W)`` with origin ``low (2,)``, row 0 at the lowest y.

    ``cell`` is the cell edge, ``depth`` the distance to the nearest wall, negative outside rooms
    and doorways, at most 1; ``room`` is a room's index plus one, and 0 elsewhere. Units are the
    graph's.
    """

    low: Array
    cell: float
    depth: NDArray[np.float32]
    room: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Surfaces:
    """
    Points on the walls ``(P, 2)`` and floors ``(Q, 2)`` of a graph's rooms, in the graph's units.

    ``length (P,)`` is the wall length that a point represents, less if the room borders on unknown
    space; ``room (Q,)`` the room of a point on a floor, in ascending order.
    """

    wall: Array
    length: Array
    floor: Array
    room: NDArray[np.int64]

    def thinned(self) -> Surfaces:
        """Return a subset of the points, for comparing many placements."""
        wall, floor = (1 + len(points) // _FEW_POINTS for points in (self.wall, self.floor))
        return Surfaces(
            self.wall[::wall], self.length[::wall], self.floor[::floor], self.room[::floor].copy()
        )


def painted(outlines: Sequence[Array], is_door: NDArray[np.bool_]) -> Painted:
    """Rasterize the regions with these ``outlines (V, 2)``; walls between rooms are kept."""
    extent = np.ptp(np.concatenate(outlines), axis=0) + 2.0 * _FAR
    cell = max(_CELL, float(np.sqrt(extent.prod() / _MOST_CELLS)))
    low, shape = _frame(outlines, _FAR + 2.0 * cell, cell)
    free, room = np.zeros(shape, np.uint8), np.zeros(shape, np.int32)
    rings = [_pixels(ring, low, cell) for ring in outlines]
    rooms = np.flatnonzero(~is_door).tolist()
    for index in rooms:
        cv2.fillPoly(free, [rings[index]], (1,), shift=PIXEL_BITS)
        cv2.fillPoly(room, [rings[index]], (index + 1,), shift=PIXEL_BITS)
    for index in rooms:
        cv2.polylines(free, [rings[index]], True, (0,), 1, shift=PIXEL_BITS)
    for index in np.flatnonzero(is_door).tolist():
        cv2.fillPoly(free, [rings[index]], (1,), shift=PIXEL_BITS)
    inside, outside = (cv2.distanceTransform(m, cv2.DIST_L2, 3) for m in (free, 1 - free))
    depth = np.clip((inside - outside) * cell, -_FAR, _FAR)
    return Painted(low, cell, depth.astype(np.float32), room)


def seen(
    outlines: Sequence[Array], is_door: NDArray[np.bool_], box: Array, unseen: Array
) -> Surfaces:
    """
    Sample the walls and floors of the regions with these ``outlines (V, 2)``.

    ``box (R, 5)`` as in :class:`fpnet_core.matching.geometry.GraphGeometry`; ``unseen (R,)`` is
    the share of each outline that borders on unknown space.
    """
    rooms = np.flatnonzero(~is_door)
    if not len(rooms):
        nothing = np.zeros((0, 2))
        return Surfaces(nothing, np.zeros(0), nothing, np.zeros(0, np.int64))
    rings = [outlines[index] for index in rooms.tolist()]
    start = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    room = np.repeat(rooms, [len(ring) for ring in rings])
    long = np.linalg.norm(end - start, axis=1)
    count = np.maximum(1, np.round(long / max(_WALL_STEP, long.sum() / _MOST_POINTS)))
    side = np.repeat(np.arange(len(long)), count.astype(np.int64))
    first = np.concatenate([[0.0], np.cumsum(count)[:-1]])
    share = (np.arange(len(side)) - first[side] + 0.5) / count[side]
    wall = start[side] + share[:, None] * (end - start)[side]
    length = ((1.0 - unseen[room]) * long / count)[side]
    away = _away_from(wall, box[is_door, :2], box[is_door, 2] + _AT_DOOR)
    return Surfaces(wall[away], length[away], *_floor(rings, rooms))


def explained(similarity: Array, plan: Painted, sub: Surfaces) -> Array:
    """
    Return how well the plan explains the seen surfaces under each of ``similarity (C, 4)``.

    Returns
    -------
    ``(C, 5)``, as in :data:`EXPLAINED`: the mean over walls of ``log(1 + (gap / spread)^2)``, the
    same as a sum over their length in the plan, the share of walls on walls of the plan, the mean
    distance of floors outside the plan's floors, and the share of floor points outside the plan
    room that holds most of their room.
    """
    label = np.empty((len(similarity), len(sub.floor)), np.int64)
    depth = _depths(similarity, plan, sub.floor, label)
    outside = np.minimum(np.maximum(0.0, -depth), _OUTSIDE).sum(axis=1) / _OUTSIDE
    pure, count = np.zeros(len(similarity), np.int64), np.zeros(int(plan.room.max()) + 1, np.int64)
    _count_pure(label, sub.room, count, pure)
    points = max(len(sub.floor), 1)
    walls = _walls(similarity, plan, sub)
    return np.column_stack([*walls, outside / points, 1.0 - pure / points])


def walls_apart(similarity: Array, plan: Painted, sub: Surfaces) -> Array:
    """Return the first column of :func:`explained`, ``(C,)``."""
    return _walls(similarity, plan, sub)[0]


def _walls(similarity: Array, plan: Painted, sub: Surfaces) -> tuple[Array, Array, Array]:
    """Return the first three columns of :func:`explained`, ``(C,)`` each."""
    gap = _depths(similarity, plan, sub.wall, np.empty((0, 0), np.int64))
    total = max(float(sub.length.sum()), 1e-9)
    apart = np.log1p((gap / _SPREAD) ** 2) @ sub.length
    met = (np.abs(gap) < _SPREAD) @ sub.length
    return apart / total, apart * np.hypot(*similarity.T[:2]), met / total


def _depths(similarity: Array, plan: Painted, points: Array, label: NDArray[np.int64]) -> Array:
    """
    Return the plan's depth at placed ``points (P, 2)``, interpolated, ``(C, P)``.

    Writes their rooms, 0 for none, to ``label (C, P)`` unless that is empty.
    """
    depth = np.empty((len(similarity), len(points)))
    read = each_unwritable(similarity, points, plan.low, plan.depth, plan.room)
    _look_up(*[*read, plan.cell, depth, label])
    return depth


def _frame(rings: Sequence[Array], margin: float, cell: float) -> tuple[Array, tuple[int, int]]:
    """Return the lower corner of a raster around all ``rings``, and its rows and columns."""
    points = np.concatenate(rings)
    low = points.min(axis=0) - margin
    columns, rows = np.ceil((points.max(axis=0) + margin - low) / cell).astype(int).tolist()
    return low, (rows, columns)


def _pixels(ring: Array, low: Array, cell: float) -> NDArray[np.int32]:
    """Return points in OpenCV's fixed-point drawing format."""
    return fixed_point((ring - low) / cell - 0.5)


def _floor(rings: Sequence[Array], index: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Return points inside ``rings`` and the ``index`` of each one's ring, ascending."""
    extent = np.ptp(np.concatenate(rings), axis=0)
    step = max(_FLOOR_STEP, float(np.sqrt(extent.prod() / _MOST_POINTS)))
    # Drawn finer than sampled: OpenCV fills every cell that an outline touches.
    cell = step / _FLOOR_FINER
    low, shape = _frame(rings, step, cell)
    room = np.full(shape, -1, np.int32)
    for ring, number in zip(rings, index.tolist(), strict=True):
        cv2.fillPoly(room, [_pixels(ring, low, cell)], (number,), shift=PIXEL_BITS)
    room = room[::_FLOOR_FINER, ::_FLOOR_FINER]
    row, column = np.nonzero(room >= 0)
    order = np.argsort(room[row, column], kind='stable')
    row, column = row[order], column[order]
    floor = low + (np.stack([column, row], axis=1) * _FLOOR_FINER + 0.5) * cell
    return floor, room[row, column].astype(np.int64)


def _away_from(point: Array, middle: Array, reach: Array) -> NDArray[np.bool_]:
    """Return which of ``point (P, 2)`` lie beyond ``reach (D,)`` of every ``middle (D, 2)``."""
    x, y = (point[:, None] - middle).transpose(2, 0, 1)
    return np.asarray((x * x + y * y >= reach * reach).all(axis=1))


@numba.njit(cache=True, nogil=True)
def _look_up(  # type: ignore[no-untyped-def]
    similarity, points, low, depth, room, cell, depths, labels
):
    """Write what :func:`_depths` returns."""
    rows, cols = depth.shape
    for c in range(len(similarity)):
        a, b, x0, y0 = similarity[c, 0], similarity[c, 1], similarity[c, 2], similarity[c, 3]
        for k in range(len(points)):
            u = (a * points[k, 0] - b * points[k, 1] + x0 - low[0]) / cell
            v = (b * points[k, 0] + a * points[k, 1] + y0 - low[1]) / cell
            if len(labels):
                is_on = 0.0 <= u < cols and 0.0 <= v < rows
                labels[c, k] = room[int(v), int(u)] if is_on else 0
            u, v = u - 0.5, v - 0.5
            if u < 0.0 or v < 0.0 or u >= cols - 1 or v >= rows - 1:
                depths[c, k] = -_FAR
                continue
            i, j = int(u), int(v)
            u, v = u - i, v - j
            lower = depth[j, i] * (1.0 - u) + depth[j, i + 1] * u
            upper = depth[j + 1, i] * (1.0 - u) + depth[j + 1, i + 1] * u
            depths[c, k] = lower * (1.0 - v) + upper * v


@numba.njit(cache=True, nogil=True)
def _count_pure(label, index, count, pure):  # type: ignore[no-untyped-def]
    """
    Write how many floor points lie in the plan room that holds most of their room, ``(C,)``.

    ``index (Q,)`` are their rooms in ascending order, ``label (C, Q)`` those of the plan or 0, and
    ``count`` is zero for each room of the plan.
    """
    for c in range(len(label)):
        first = 0
        for k in range(len(index)):
            count[label[c, k]] += 1
            if k + 1 < len(index) and index[k + 1] == index[k]:
                continue
            # Last point of a room: find the plan room with most of its points.
            count[0], most = 0, 0
            for m in range(first, k + 1):
                most = max(most, count[label[c, m]])
            for m in range(first, k + 1):
                count[label[c, m]] = 0
            pure[c], first = pure[c] + most, k + 1
