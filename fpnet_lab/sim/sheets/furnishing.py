# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The symbols that architects furnish rooms with: desks, tables, shelves, kitchens, washrooms.

Where :mod:`fpnet_lab.sim.furniture` says what a scanner meets, here is what is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_lab.sim.sheets.artwork import Arcs, Array, Lines, Pen, Role, Stroke, circles
from fpnet_lab.sim.types import BuildingPlan

DOOR_CLEARANCE_M = 1.1
"""Pieces keep this far from the middle of a door. Chosen."""

# Chosen, not measured:
_CHAIR_M = 0.45
_TRIES = 12  # numerical: places tried for a piece
_GAP_M = 0.1  # between pieces
_WALL_GAP_M = 0.04
_WASHROOM_M2, _OFFICE_M2, _MEETING_M2 = 6.0, 14.0, 28.0
_MOST_PIECES = 8


@dataclass(frozen=True, eq=False)
class Piece:
    """
    A symbol in its own frame: x along the wall, y into the room, the middle of its back at zero.

    ``rings`` are closed lines (V, 2) [m], ``discs (N, 3)`` circles as x, y and radius.
    """

    rings: tuple[Array, ...]
    discs: Array

    @property
    def bounds(self) -> Array:
        """Corners (4, 2) of the smallest rectangle around all of it."""
        low = [ring.min(axis=0) for ring in self.rings]
        high = [ring.max(axis=0) for ring in self.rings]
        low += list(self.discs[:, :2] - self.discs[:, 2:])
        high += list(self.discs[:, :2] + self.discs[:, 2:])
        (x0, y0), (x1, y1) = np.min(low, axis=0), np.max(high, axis=0)
        return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


Maker = Callable[[np.random.Generator], Piece]


def _box(x: float, y: float, width: float, depth: float) -> Array:
    """Return a rectangle (4, 2) whose back's middle is at ``x, y``."""
    half = width / 2.0
    return np.array([(x - half, y), (x + half, y), (x + half, y + depth), (x - half, y + depth)])


def _piece(rings: Sequence[Array], discs: Sequence[tuple[float, float, float]] = ()) -> Piece:
    return Piece(tuple(rings), np.array(discs, np.float64).reshape(-1, 3))


def _desk(rng: np.random.Generator) -> Piece:
    width, depth = rng.uniform(1.2, 1.8), rng.uniform(0.7, 0.85)
    at = rng.uniform(-0.2, 0.2)
    rings = [_box(0.0, 0.0, width, depth), _box(at, 0.1, 0.5, 0.08)]
    return _piece(rings, [(at, depth + 0.3, 0.26), (at, depth + 0.3, 0.18)])


def _shelf(rng: np.random.Generator) -> Piece:
    width, depth = rng.uniform(0.8, 2.4), rng.uniform(0.3, 0.5)
    half = width / 2.0
    diagonal = np.array([(-half, 0.0), (half, depth)])
    return _piece([_box(0.0, 0.0, width, depth), diagonal])


def _sofa(rng: np.random.Generator) -> Piece:
    width, depth = rng.uniform(1.4, 2.2), rng.uniform(0.8, 0.95)
    return _piece([_box(0.0, 0.0, width, depth), _box(0.0, 0.2, width - 0.4, depth - 0.2)])


def _toilet(_rng: np.random.Generator) -> Piece:
    return _piece([_box(0.0, 0.0, 0.4, 0.18), _box(0.0, 0.18, 0.3, 0.2)], [(0.0, 0.42, 0.19)])


def _basin(rng: np.random.Generator) -> Piece:
    return _piece([_box(0.0, 0.0, 0.6, 0.45)], [(0.0, 0.24, float(rng.uniform(0.12, 0.18)))])


def _counter(rng: np.random.Generator) -> Piece:
    width = rng.uniform(2.0, 3.2)
    left, right = -width / 2.0 + 0.5, width / 2.0 - 0.5
    stove = [(right + dx, 0.3 + dy, 0.09) for dx in (-0.13, 0.13) for dy in (-0.13, 0.13)]
    return _piece([_box(0.0, 0.0, width, 0.6), _box(left, 0.12, 0.5, 0.36)], stove)


def _table(rng: np.random.Generator) -> Piece:
    width, depth = rng.uniform(1.4, 3.6), rng.uniform(0.8, 1.2)
    rings = [_box(0.0, _CHAIR_M, width, depth)]
    for x in np.arange(-width / 2.0 + 0.4, width / 2.0 - 0.3, 0.7).tolist():
        rings += [_box(x, 0.0, _CHAIR_M, _CHAIR_M - 0.05)]
        rings += [_box(x, _CHAIR_M + depth + 0.05, _CHAIR_M, _CHAIR_M - 0.05)]
    return _piece(rings)


def _round_table(rng: np.random.Generator) -> Piece:
    radius = float(rng.uniform(0.4, 0.8))
    reach = radius + 0.55
    turns = np.arange(4) * np.pi / 2.0 + rng.uniform(0.0, 1.0)
    chairs = [(reach * 0.85 * np.cos(t), reach + reach * 0.85 * np.sin(t), 0.2) for t in turns]
    return _piece([], [(0.0, reach, radius), *chairs])


def _plant(rng: np.random.Generator) -> Piece:
    radius = float(rng.uniform(0.15, 0.3))
    turns = rng.uniform(0.0, 2.0 * np.pi, 5)
    tips = np.stack([radius * np.cos(turns), radius + radius * np.sin(turns)], axis=1)
    leaves = [np.stack([np.array([0.0, radius]), tip]) for tip in tips]
    return _piece(leaves, [(0.0, radius, radius)])


_WASHROOM: tuple[Maker, ...] = (_toilet, _basin)
_OFFICE: tuple[Maker, ...] = (_desk, _desk, _shelf, _shelf, _plant)
_LARGE: tuple[Maker, ...] = (_desk, _desk, _table, _round_table, _shelf, _sofa, _counter, _plant)
_FREE_STANDING = (_table, _round_table)


def furnish_symbols(
    plan: BuildingPlan, taken: Sequence[int], pen: Pen, rng: np.random.Generator
) -> list[Stroke]:
    """
    Return furniture for a storey, none of it in a door's way or across a wall.

    Parameters
    ----------
    plan : in the frame of what is drawn
    taken : numbers of rooms that stay empty
    pen : draws it all
    rng : draws what stands where
    """
    doors = shapely.union_all(
        shapely.buffer(
            shapely.points([door.ends.mean(axis=0) for door in plan.doors]), DOOR_CLEARANCE_M
        )
    )
    density = float(rng.uniform(0.08, 0.25))
    strokes: list[Stroke] = []
    for number, (room, outline) in enumerate(zip(plan.rooms, plan.outlines, strict=True)):
        if room.kind != 'room' or number in taken or rng.random() < 0.15:
            continue
        free = shapely.difference(shapely.buffer(outline, -0.02), doors)
        count = min(_MOST_PIECES, int(rng.poisson(density * outline.area)))
        for maker in _chosen(outline.area, count, rng):
            piece = maker(rng)
            placed = _place(piece, room.polygon, free, maker in _FREE_STANDING, rng)
            if placed is None:
                continue
            T, taken_up = placed
            free = shapely.difference(free, shapely.buffer(taken_up, _GAP_M))
            strokes += _drawn(piece, T, pen)
    return strokes


def _chosen(area_m2: float, count: int, rng: np.random.Generator) -> list[Maker]:
    """Draw what stands in a room of some size."""
    if area_m2 < _WASHROOM_M2:
        return list(_WASHROOM[: max(count, 1)])
    makers = _OFFICE if area_m2 < _OFFICE_M2 else _LARGE
    chosen = [makers[int(i)] for i in rng.integers(len(makers), size=count)]
    return [_table, *chosen] if area_m2 > _MEETING_M2 and rng.random() < 0.5 else chosen


def _place(
    piece: Piece, ring: Array, free: BaseGeometry, stands_free: bool, rng: np.random.Generator
) -> tuple[Array, BaseGeometry] | None:
    """Return a pose (2, 3) of a piece in a room and its outline there; None without a place."""
    edges = np.roll(ring, -1, axis=0) - ring
    lengths = np.hypot(*edges.T)
    shapely.prepare(free)
    for _ in range(_TRIES):
        i = int(rng.choice(len(ring), p=lengths / lengths.sum()))
        along = edges[i] / lengths[i]
        across = np.array([-along[1], along[0]])
        inward = float(rng.uniform(0.5, 2.5)) if stands_free else _WALL_GAP_M
        back = ring[i] + rng.random() * edges[i] + inward * across
        T = np.stack([along, across, back], axis=1)
        outline = shapely.Polygon(_posed(T, piece.bounds))
        if shapely.contains(free, outline):
            return T, outline
    return None


def _posed(T: Array, xy: Array) -> Array:
    return np.asarray(xy @ T[:, :2].T + T[:, 2])


def _drawn(piece: Piece, T: Array, pen: Pen) -> list[Stroke]:
    strokes: list[Stroke] = []
    if piece.rings:
        rings = tuple(_posed(T, ring) for ring in piece.rings)
        strokes.append(Lines(Role.FURNITURE, rings, pen, is_closed=True))
    if len(piece.discs):
        discs: Arcs = circles(
            Role.FURNITURE, _posed(T, piece.discs[:, :2]), piece.discs[:, 2], pen
        )
        strokes.append(discs)
    return strokes
