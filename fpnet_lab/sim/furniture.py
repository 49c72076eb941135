# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Furniture: what a lidar sees in rooms and no floorplan shows.

Every piece is a handful of upright prisms (a table is a top and four legs), so that low beams
pass below tables and between chair legs as they do in offices and flats.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_lab.sim.meshes import TriangleMesh, extrude_polygon, merge_meshes
from fpnet_lab.sim.openings import opening_polygon
from fpnet_lab.sim.types import BuildingPlan, PlanRoom

DOOR_CLEARANCE_M = 0.9
"""Furniture keeps this far from the opening of a door, on both sides of the wall. Chosen."""

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


class Solid(NamedTuple):
    """An upright prism: its base and the heights of its lower and upper face [m]."""

    base: Polygon
    bottom_m: float
    top_m: float


@dataclass(frozen=True, eq=False)
class FurniturePiece:
    """One piece: ``footprint`` is the convex hull of its solids on the floor, in metres."""

    kind: str
    solids: tuple[Solid, ...]
    footprint: Polygon

    def moved(self, xy: NDArray[np.float64], yaw_rad: float) -> FurniturePiece:
        """Return the piece with its own origin at ``xy (2,)``, turned by ``yaw_rad``."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        R = np.array([[c, -s], [s, c]])

        def move(polygon: Polygon) -> Polygon:
            return shapely.transform(polygon, lambda points: points @ R.T + xy)

        solids = tuple(solid._replace(base=move(solid.base)) for solid in self.solids)
        return FurniturePiece(self.kind, solids, move(self.footprint))

    def mesh(self) -> TriangleMesh:
        """Return the surface of all solids."""
        return merge_meshes([extrude_polygon(*solid) for solid in self.solids])


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
    densities = {
        'room': rng.uniform(*ROOM_DENSITY_PER_M2),
        'corridor': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
        'hall': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
    }
    pieces: list[FurniturePiece] = []
    for room, outline in zip(plan.rooms, plan.outlines, strict=True):
        count = min(_MAX_PIECES, int(rng.poisson(densities[room.kind] * outline.area)))
        makers: list[Maker] = [_draw_piece if room.kind == 'room' else _corridor_cabinet] * count
        if room.kind != 'room':
            makers += [_fixture] * int(rng.poisson(outline.length / FIXTURE_SPACING_M))
        pieces += _furnish_room(room, outline, blocked, makers, rng)
    return tuple(pieces)


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
    piece: FurniturePiece, ring: NDArray[np.float64], outline: Polygon, rng: np.random.Generator
) -> FurniturePiece:
    """Draw a place: tables stand anywhere in a room, all else against a wall."""
    if piece.kind != 'table':
        return _against_wall(piece, ring, rng)
    x0, y0, x1, y1 = outline.bounds
    xy = rng.uniform((x0, y0), (x1, y1))
    return piece.moved(xy, _edge_yaw(ring, rng) + rng.normal(0.0, 0.05))


def _edge_yaw(ring: NDArray[np.float64], rng: np.random.Generator) -> float:
    """Return the direction of the longest edge, or of its normal."""
    edges = np.roll(ring, -1, axis=0) - ring
    longest = edges[int(np.argmax(np.linalg.norm(edges, axis=1)))]
    return float(np.arctan2(longest[1], longest[0]) + np.pi / 2.0 * rng.integers(2))


def _against_wall(
    piece: FurniturePiece, ring: NDArray[np.float64], rng: np.random.Generator
) -> FurniturePiece:
    """Put the piece's back at a random place along the outline (V, 2), counter-clockwise."""
    edges = np.roll(ring, -1, axis=0) - ring
    lengths = np.linalg.norm(edges, axis=1)
    index = int(rng.choice(len(ring), p=lengths / lengths.sum()))
    along = edges[index] / lengths[index]
    inwards = np.array([-along[1], along[0]])
    offset = rng.uniform(0.0, lengths[index])
    xy = ring[index] + offset * along + rng.uniform(*_WALL_GAP_M) * inwards
    return piece.moved(xy, float(np.arctan2(along[1], along[0])))


def _piece(kind: str, *solids: Solid) -> FurniturePiece:
    bases = [solid.base for solid in solids]
    return FurniturePiece(kind, solids, shapely.convex_hull(shapely.union_all(bases)))


def _block(x: float, y: float, width: float, depth: float, bottom: float, top: float) -> Solid:
    """Return a box whose base starts at the corner (x, y); metres."""
    return Solid(shapely.box(x, y, x + width, y + depth), bottom, top)


def _legs(x: float, y: float, width: float, depth: float, top: float) -> list[Solid]:
    """Return four legs at the corners of a base that starts at (x, y); metres."""
    columns, rows = (x, x + width - _LEG_M), (y, y + depth - _LEG_M)
    return [_block(cx, cy, _LEG_M, _LEG_M, 0.0, top) for cx in columns for cy in rows]


def _chair(x: float, y: float, faces_up: bool) -> list[Solid]:
    """Return a chair around the centre (x, y) that looks along +y or -y."""
    size, seat_m, back_m = 0.45, 0.45, 0.9
    x0, y0 = x - size / 2.0, y - size / 2.0
    back_y = y0 if faces_up else y0 + size - _LEG_M
    return [
        *_legs(x0, y0, size, size, seat_m - 0.04),
        _block(x0, y0, size, size, seat_m - 0.04, seat_m),
        _block(x0, back_y, size, _LEG_M, seat_m, back_m),
    ]


# The makers below draw one piece in its own frame: x along the wall, y into the room, origin in
# the middle of its back; a table's origin is its centre.


def _cabinet(rng: np.random.Generator, deepest_m: float = 0.6) -> FurniturePiece:
    width, depth = rng.uniform(0.8, 1.8), rng.uniform(0.3, deepest_m)
    height = rng.uniform(0.8, 2.1)
    return _piece('cabinet', _block(-width / 2.0, 0.0, width, depth, 0.0, height))


def _corridor_cabinet(rng: np.random.Generator) -> FurniturePiece:
    return _cabinet(rng, deepest_m=0.45)


def _fixture(rng: np.random.Generator) -> FurniturePiece:
    width, depth, bottom = rng.uniform(0.25, 1.4), rng.uniform(0.06, 0.2), rng.uniform(0.0, 1.2)
    top = bottom + rng.uniform(0.4, 1.0)
    return _piece('fixture', _block(-width / 2.0, 0.0, width, depth, bottom, top))


def _shelf(rng: np.random.Generator) -> FurniturePiece:
    width, height = rng.uniform(0.8, 2.4), rng.uniform(1.7, 2.2)
    boards = [
        _block(-width / 2.0, 0.0, width, 0.3, z, z + 0.03) for z in np.arange(0, height, 0.4)
    ]
    sides = [_block(x, 0.0, 0.03, 0.3, 0.0, height) for x in (-width / 2.0, width / 2.0 - 0.03)]
    return _piece('shelf', *boards, *sides, _block(-width / 2.0, 0.0, width, 0.02, 0.0, height))


def _desk(rng: np.random.Generator) -> FurniturePiece:
    width, depth, height = rng.uniform(1.2, 1.8), rng.uniform(0.7, 0.85), rng.uniform(0.7, 0.76)
    x0 = -width / 2.0
    return _piece(
        'desk',
        *_legs(x0, 0.0, width, depth, height - 0.03),
        _block(x0, 0.0, width, depth, height - 0.03, height),
        _block(x0 + 0.06, 0.1, 0.4, depth - 0.15, 0.05, height - 0.05),
        _block(rng.uniform(-0.3, 0.0), 0.1, 0.55, 0.06, height, height + 0.4),
        *_chair(rng.uniform(-0.1, 0.3), depth + rng.uniform(0.0, 0.3), faces_up=False),
    )


def _sofa(rng: np.random.Generator) -> FurniturePiece:
    width, depth = rng.uniform(1.4, 2.3), rng.uniform(0.8, 0.95)
    return _piece(
        'sofa',
        _block(-width / 2.0, 0.0, width, depth, 0.0, 0.42),
        _block(-width / 2.0, 0.0, width, 0.2, 0.42, rng.uniform(0.75, 0.95)),
    )


def _bed(rng: np.random.Generator) -> FurniturePiece:
    width = rng.uniform(0.9, 1.8)
    return _piece(
        'bed',
        _block(-width / 2.0, 0.0, width, 0.05, 0.0, rng.uniform(0.8, 1.1)),
        _block(-width / 2.0, 0.05, width, 2.0, 0.15, 0.5),
    )


def _table(rng: np.random.Generator) -> FurniturePiece:
    width, depth = rng.uniform(1.2, 2.2), rng.uniform(0.8, 1.1)
    x0, y0 = -width / 2.0, -depth / 2.0
    solids = [*_legs(x0, y0, width, depth, 0.71), _block(x0, y0, width, depth, 0.71, 0.75)]
    for x in np.linspace(-width / 2.0, width / 2.0, int(width / 0.6) + 2)[1:-1]:
        for side in (-1.0, 1.0):
            if rng.random() < 0.7:
                y = side * (depth / 2.0 + rng.uniform(0.0, 0.3))
                solids += _chair(float(x), y, faces_up=side < 0.0)
    return _piece('table', *solids)


_CATALOGUE: tuple[Maker, ...] = (_cabinet, _shelf, _desk, _sofa, _bed, _table)
_FREQUENCIES = (0.25, 0.2, 0.25, 0.08, 0.07, 0.15)  # chosen


def _draw_piece(rng: np.random.Generator) -> FurniturePiece:
    return _CATALOGUE[int(rng.choice(len(_CATALOGUE), p=_FREQUENCIES))](rng)
