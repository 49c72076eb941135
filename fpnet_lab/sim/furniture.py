# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Furniture: what a scanner sees in rooms and no floorplan shows.

Every piece is a handful of upright boxes (a table is a top and four legs), so that low beams pass
below tables and between chair legs as they do in offices and flats. One catalogue serves lidars,
which meet all of it, planar scanners, which meet a slice, and drawings, which show it from above.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_lab.sim.meshes import TriangleMesh, extrude_polygon, merge_meshes
from fpnet_lab.sim.openings import opening_polygon
from fpnet_lab.sim.types import BuildingPlan, PlanRoom

Array = NDArray[np.float64]

DOOR_CLEARANCE_M = 0.9
"""Furniture keeps this far from the opening of a door, on both sides of the wall. Chosen."""

LOOSE_DOOR_CLEARANCE_M = 1.2
"""Where only a slice of it matters, furniture keeps this far from the middle of a door. Chosen."""

ROOM_DENSITY_PER_M2 = (0.10, 0.28)
CORRIDOR_DENSITY_PER_M2 = (0.0, 0.06)
"""Pieces per square metre; each building draws its own density from the range. Chosen."""

FIXTURE_SPACING_M = 5.0
"""Length of corridor wall per radiator, notice board or fire extinguisher. Chosen."""

# Chosen, not measured:
_MAX_PIECES = 16
_TRIES_PER_PIECE = 6
_WALL_GAP_M = (0.01, 0.06)
_PIECE_GAP_M = 0.1
_PASSAGE_M = 0.8  # what a cabinet in a corridor must leave free
_LEG_M = 0.05
_SKEW_RAD = 0.05  # by how much tables are out of line

# Given: where a box's corners lie, in units of its half sides.
_CORNERS = np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])


@dataclass(frozen=True, eq=False)
class Boxes:
    """Upright boxes: ``centre (B, 2)``, ``half (B, 2)`` [m], ``yaw (B,)``, ``span (B, 2)`` [m]."""

    centre: Array
    half: Array
    yaw: Array
    span: Array

    @property
    def rings(self) -> Array:
        """Outlines (B, 4, 2) on the floor [m]."""
        x, y = np.moveaxis(self.half[:, None] * _CORNERS, 2, 0)
        c, s = np.cos(self.yaw)[:, None], np.sin(self.yaw)[:, None]
        return np.asarray(np.stack([c * x - s * y, s * x + c * y], axis=2) + self.centre[:, None])

    def met_at(self, height_m: float) -> list[Array]:
        """Return the outlines (4, 2) of the boxes that a level ray at this height meets."""
        return list(self.rings[(self.span[:, 0] <= height_m) & (height_m <= self.span[:, 1])])

    def from_above(self) -> Array:
        """Return the outlines (F, 4, 2) of all that is wider than a leg."""
        return np.asarray(self.rings[self.half.min(axis=1) > _LEG_M])

    def moved(self, xy: Array, yaw_rad: Array | float) -> Boxes:
        """Return the boxes, or each of them, with their origin at ``xy`` and turned."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        x, y = self.centre.T
        centre = np.stack([c * x - s * y, s * x + c * y], axis=1) + xy
        return Boxes(centre, self.half, self.yaw + yaw_rad, self.span)

    def mesh(self) -> TriangleMesh:
        """Return the surface of all boxes."""
        return merge_meshes(
            [
                extrude_polygon(Polygon(ring), bottom_m, top_m)
                for ring, (bottom_m, top_m) in zip(self.rings, self.span.tolist(), strict=True)
            ]
        )


def joined(groups: Sequence[Boxes]) -> Boxes:
    """Return all boxes of some groups."""
    if not groups:
        return Boxes(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2)))
    columns = zip(*((g.centre, g.half, g.yaw, g.span) for g in groups), strict=True)
    return Boxes(*(np.concatenate(column) for column in columns))


@dataclass(frozen=True, eq=False)
class FurniturePiece:
    """One piece, for example a table with its chairs [m]."""

    kind: str
    boxes: Boxes

    @cached_property
    def footprint(self) -> Polygon:
        """The convex hull of its boxes on the floor."""
        return shapely.convex_hull(shapely.multipoints(self.boxes.rings.reshape(-1, 2)))

    def moved(self, xy: Array, yaw_rad: float) -> FurniturePiece:
        """Return the piece with its own origin at ``xy (2,)``, turned by ``yaw_rad``."""
        return FurniturePiece(self.kind, self.boxes.moved(xy, yaw_rad))


Maker = Callable[[np.random.Generator], FurniturePiece]
"""Draws a piece in its own frame."""


def furnish(
    plan: BuildingPlan, rng: np.random.Generator, keep_clear: shapely.Geometry | None = None
) -> tuple[FurniturePiece, ...]:
    """
    Fill rooms with furniture and put the odd cabinet into corridors.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
    keep_clear : shapely geometry, frame ``building``
        Stays free, for example the robot's path with its clearance; doors always stay free.

    Returns
    -------
    tuple of FurniturePiece, frame ``building``; empty where nothing fits.
    """
    zones = [_door_zone(plan, index) for index in range(len(plan.doors))]
    blocked = shapely.union_all([*zones, *([keep_clear] if keep_clear is not None else [])])
    shapely.prepare(blocked)
    densities = _draw_densities(rng)
    pieces: list[FurniturePiece] = []
    for room, outline in zip(plan.rooms, plan.outlines, strict=True):
        makers = _draw_makers(room, outline, densities, rng)
        pieces += _furnish_room(room, outline, blocked, makers, rng)
    return tuple(pieces)


def furnish_loosely(plan: BuildingPlan, rng: np.random.Generator) -> Boxes:
    """
    Fill a storey with the same furniture, fast: pieces may touch, or reach into walls.

    That is enough where only a slice is looked at, or a drawing; whoever rasterises it keeps to
    the rooms. Doors stay clear.
    """
    doors = np.array([door.ends.mean(axis=0) for door in plan.doors]).reshape(-1, 2)
    densities = _draw_densities(rng)
    pieces: list[FurniturePiece] = []
    places, yaws = [np.zeros((0, 2))], [np.zeros(0)]
    for room, outline in zip(plan.rooms, plan.outlines, strict=True):
        found = [make(rng) for make in _draw_makers(room, outline, densities, rng)]
        is_free = np.array([piece.kind == 'table' for piece in found], dtype=np.bool_)
        xy, yaw = _loose_places(rng, room.polygon, is_free)
        pieces += found
        places.append(xy)
        yaws.append(yaw)
    xy, yaw = np.concatenate(places), np.concatenate(yaws)
    gaps = np.hypot(*(xy[:, None] - doors).T).min(axis=0, initial=np.inf)
    kept = np.flatnonzero(gaps > LOOSE_DOOR_CLEARANCE_M)
    boxes = [pieces[k].boxes for k in kept.tolist()]
    owner = np.repeat(kept, [len(group.yaw) for group in boxes])
    return joined(boxes).moved(xy[owner], yaw[owner])


def _draw_densities(rng: np.random.Generator) -> dict[str, float]:
    """Draw how many pieces per square metre the kinds of rooms of a building have."""
    return {
        'room': rng.uniform(*ROOM_DENSITY_PER_M2),
        'corridor': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
        'hall': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
    }


def _draw_makers(
    room: PlanRoom, outline: Polygon, densities: dict[str, float], rng: np.random.Generator
) -> list[Maker]:
    """Draw what stands in a room, before it is known where."""
    count = min(_MAX_PIECES, int(rng.poisson(densities[room.kind] * outline.area)))
    if room.kind == 'room':
        return [_draw_piece] * count
    fixtures = int(rng.poisson(outline.length / FIXTURE_SPACING_M))
    return [*[_corridor_cabinet] * count, *[_fixture] * fixtures]


def _loose_places(
    rng: np.random.Generator, ring: Array, is_free: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """
    Return places (B, 2) and angles (B,) for pieces in a room.

    They are at the outline ``ring (V, 2)``, counter-clockwise, or between two places at it.
    """
    count = len(is_free)
    edges = np.roll(ring, -1, axis=0) - ring
    lengths = np.hypot(*edges.T)
    picks = rng.choice(len(ring), (2, count), p=lengths / lengths.sum())
    at_wall, other = ring[picks] + rng.random((2, count, 1)) * edges[picks]
    along = edges[picks[0]] / lengths[picks[0], None]
    gap = rng.uniform(*_WALL_GAP_M, (count, 1))
    beside = at_wall + gap * np.stack([-along[:, 1], along[:, 0]], axis=1)
    places = np.where(is_free[:, None], (at_wall + other) / 2.0, beside)
    yaw = np.arctan2(along[:, 1], along[:, 0])
    return places, yaw + is_free * rng.normal(0.0, _SKEW_RAD, count)


def _door_zone(plan: BuildingPlan, index: int) -> Polygon:
    """Return a door's opening, lengthened by the clearance into both rooms."""
    door = plan.doors[index]
    opening = opening_polygon(plan, door)
    reach = DOOR_CLEARANCE_M * door.normal
    both = [
        shapely.transform(opening, lambda xy, move=move: xy + move) for move in (reach, -reach)
    ]
    return shapely.convex_hull(shapely.union_all(both))


def _furnish_room(
    room: PlanRoom,
    outline: Polygon,
    blocked: shapely.Geometry,
    makers: list[Maker],
    rng: np.random.Generator,
) -> list[FurniturePiece]:
    """Place a piece of each maker where it touches neither others nor what is blocked."""
    shapely.prepare(outline)
    pieces: list[FurniturePiece] = []
    for make in makers:
        for _ in range(_TRIES_PER_PIECE):
            piece = _place(make(rng), room.polygon, outline, rng)
            fits = (
                outline.contains(piece.footprint)
                and not blocked.intersects(piece.footprint)
                and all(p.footprint.distance(piece.footprint) > _PIECE_GAP_M for p in pieces)
            )
            if fits and (room.kind == 'room' or _leaves_passage(outline, [*pieces, piece])):
                pieces.append(piece)
                break
    return pieces


def _leaves_passage(outline: Polygon, pieces: list[FurniturePiece]) -> bool:
    """Say whether a robot still gets from one end of a corridor to the other."""
    half = _PASSAGE_M / 2.0
    free = shapely.difference(outline, shapely.union_all([p.footprint for p in pieces]))
    before = shapely.get_num_geometries(outline.buffer(-half))
    return bool(shapely.get_num_geometries(free.buffer(-half)) == before)


def _place(
    piece: FurniturePiece, ring: Array, outline: Polygon, rng: np.random.Generator
) -> FurniturePiece:
    """Draw a place: tables stand anywhere in a room, all else against a wall."""
    if piece.kind != 'table':
        return _against_wall(piece, ring, rng)
    x0, y0, x1, y1 = outline.bounds
    xy = rng.uniform((x0, y0), (x1, y1))
    return piece.moved(xy, _edge_yaw(ring, rng) + rng.normal(0.0, _SKEW_RAD))


def _edge_yaw(ring: Array, rng: np.random.Generator) -> float:
    """Return the direction of the longest edge, or of its normal."""
    edges = np.roll(ring, -1, axis=0) - ring
    longest = edges[int(np.argmax(np.linalg.norm(edges, axis=1)))]
    return float(np.arctan2(longest[1], longest[0]) + np.pi / 2.0 * rng.integers(2))


def _against_wall(piece: FurniturePiece, ring: Array, rng: np.random.Generator) -> FurniturePiece:
    """Put the piece's back at a random place along the outline (V, 2), counter-clockwise."""
    edges = np.roll(ring, -1, axis=0) - ring
    lengths = np.linalg.norm(edges, axis=1)
    index = int(rng.choice(len(ring), p=lengths / lengths.sum()))
    along = edges[index] / lengths[index]
    inwards = np.array([-along[1], along[0]])
    offset = rng.uniform(0.0, lengths[index])
    xy = ring[index] + offset * along + rng.uniform(*_WALL_GAP_M) * inwards
    return piece.moved(xy, float(np.arctan2(along[1], along[0])))


Box = tuple[float, float, float, float, float, float]
"""Corner x and y, width, depth, bottom and top [m]."""


def _piece(kind: str, *boxes: Box) -> FurniturePiece:
    rows = np.array(boxes)
    half = rows[:, 2:4] / 2.0
    return FurniturePiece(kind, Boxes(rows[:, :2] + half, half, np.zeros(len(rows)), rows[:, 4:]))


def _legs(x: float, y: float, width: float, depth: float, top: float) -> list[Box]:
    """Return four legs at the corners of a base that starts at (x, y); metres."""
    columns, rows = (x, x + width - _LEG_M), (y, y + depth - _LEG_M)
    return [(cx, cy, _LEG_M, _LEG_M, 0.0, top) for cx in columns for cy in rows]


def _chair(x: float, y: float, faces_up: bool) -> list[Box]:
    """Return a chair around the centre (x, y) that looks along +y or -y."""
    size, seat_m, back_m = 0.45, 0.45, 0.9
    x0, y0 = x - size / 2.0, y - size / 2.0
    back_y = y0 if faces_up else y0 + size - _LEG_M
    return [
        *_legs(x0, y0, size, size, seat_m - 0.04),
        (x0, y0, size, size, seat_m - 0.04, seat_m),
        (x0, back_y, size, _LEG_M, seat_m, back_m),
    ]


# The makers below draw one piece in its own frame: x along the wall, y into the room, origin in
# the middle of its back; a table's origin is its centre.


def _cabinet(rng: np.random.Generator, deepest_m: float = 0.6) -> FurniturePiece:
    width, depth = rng.uniform(0.8, 1.8), rng.uniform(0.3, deepest_m)
    height = rng.uniform(0.8, 2.1)
    return _piece('cabinet', (-width / 2.0, 0.0, width, depth, 0.0, height))


def _corridor_cabinet(rng: np.random.Generator) -> FurniturePiece:
    return _cabinet(rng, deepest_m=0.45)


def _fixture(rng: np.random.Generator) -> FurniturePiece:
    width, depth, bottom = rng.uniform(0.25, 1.4), rng.uniform(0.06, 0.2), rng.uniform(0.0, 1.2)
    top = bottom + rng.uniform(0.4, 1.0)
    return _piece('fixture', (-width / 2.0, 0.0, width, depth, bottom, top))


def _shelf(rng: np.random.Generator) -> FurniturePiece:
    width, height = rng.uniform(0.8, 2.4), rng.uniform(1.7, 2.2)
    boards = [(-width / 2.0, 0.0, width, 0.3, z, z + 0.03) for z in np.arange(0, height, 0.4)]
    sides = [(x, 0.0, 0.03, 0.3, 0.0, height) for x in (-width / 2.0, width / 2.0 - 0.03)]
    return _piece('shelf', *boards, *sides, (-width / 2.0, 0.0, width, 0.02, 0.0, height))


def _desk(rng: np.random.Generator) -> FurniturePiece:
    width, depth, height = rng.uniform(1.2, 1.8), rng.uniform(0.7, 0.85), rng.uniform(0.7, 0.76)
    x0 = -width / 2.0
    return _piece(
        'desk',
        *_legs(x0, 0.0, width, depth, height - 0.03),
        (x0, 0.0, width, depth, height - 0.03, height),
        (x0 + 0.06, 0.1, 0.4, depth - 0.15, 0.05, height - 0.05),
        (rng.uniform(-0.3, 0.0), 0.1, 0.55, 0.06, height, height + 0.4),
        *_chair(rng.uniform(-0.1, 0.3), depth + rng.uniform(0.0, 0.3), faces_up=False),
    )


def _sofa(rng: np.random.Generator) -> FurniturePiece:
    width, depth = rng.uniform(1.4, 2.3), rng.uniform(0.8, 0.95)
    return _piece(
        'sofa',
        (-width / 2.0, 0.0, width, depth, 0.0, 0.42),
        (-width / 2.0, 0.0, width, 0.2, 0.42, rng.uniform(0.75, 0.95)),
    )


def _bed(rng: np.random.Generator) -> FurniturePiece:
    width = rng.uniform(0.9, 1.8)
    return _piece(
        'bed',
        (-width / 2.0, 0.0, width, 0.05, 0.0, rng.uniform(0.8, 1.1)),
        (-width / 2.0, 0.05, width, 2.0, 0.15, 0.5),
    )


def _table(rng: np.random.Generator) -> FurniturePiece:
    width, depth = rng.uniform(1.2, 2.2), rng.uniform(0.8, 1.1)
    x0, y0 = -width / 2.0, -depth / 2.0
    solids = [*_legs(x0, y0, width, depth, 0.71), (x0, y0, width, depth, 0.71, 0.75)]
    for x in np.linspace(-width / 2.0, width / 2.0, int(width / 0.6) + 2)[1:-1]:
        for side in (-1.0, 1.0):
            if rng.random() < 0.7:
                y = side * (depth / 2.0 + rng.uniform(0.0, 0.3))
                solids += _chair(float(x), y, faces_up=side < 0.0)
    return _piece('table', *solids)


_CATALOGUE: tuple[Maker, ...] = (_cabinet, _shelf, _desk, _sofa, _bed, _table)
_UP_TO = np.cumsum([0.25, 0.2, 0.25, 0.08, 0.07, 0.15])  # chosen: shares, summed up
_UP_TO /= _UP_TO[-1]


def _draw_piece(rng: np.random.Generator) -> FurniturePiece:
    # As Generator.choice would, which takes ten times as long.
    return _CATALOGUE[int(np.searchsorted(_UP_TO, rng.random(), 'right'))](rng)
