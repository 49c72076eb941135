# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Placement of furniture in rooms, clear of doors and paths.

Simulated worlds and drawings are furnished by the same rule but with different stocks: drawings
include bathroom fixtures and plants that simulated worlds do not have.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_lab.sim.buildings.furniture import (
    STANDING,
    Boxes,
    FurniturePiece,
    Maker,
    Stock,
    corridor_cabinet,
    fixture,
    joined,
)
from fpnet_lab.sim.buildings.openings import opening_polygon
from fpnet_lab.sim.types import BuildingPlan, PlanRoom

Array = NDArray[np.float64]

DOOR_CLEARANCE_M = 0.9
"""Minimum distance of furniture from a door opening, on both sides of the wall. Chosen."""

LOOSE_DOOR_CLEARANCE_M = 1.2
"""Minimum distance of furniture from the middle of a door in loose furnishing. Chosen."""

ROOM_DENSITY_PER_M2 = (0.10, 0.28)
CORRIDOR_DENSITY_PER_M2 = (0.0, 0.06)
"""Pieces per square metre; each building samples its density from the range. Chosen."""

FIXTURE_SPACING_M = 5.0
"""Length of corridor wall per radiator, notice board or fire extinguisher. Chosen."""

# Chosen, not measured:
_MAX_PIECES = 16
_TRIES_PER_PIECE = 6
_WALL_GAP_M = (0.01, 0.06)
_PIECE_GAP_M = 0.1
_PASSAGE_M = 0.8  # minimum passage width beside a cabinet in a corridor
_SKEW_RAD = 0.05  # standard deviation of table angles
_FREE_STANDING = {'table', 'round table'}  # all other pieces have their back to a wall


def furnish(
    plan: BuildingPlan,
    rng: np.random.Generator,
    keep_clear: shapely.Geometry | None = None,
    stocks: Sequence[Stock] = STANDING,
    empty: Collection[int] = (),
) -> tuple[FurniturePiece, ...]:
    """
    Place furniture in rooms and occasional cabinets in corridors.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
    keep_clear : shapely geometry, frame ``building``
        Area to keep clear, for example the robot's path with its clearance; doors stay clear.
    stocks : sequence of Stock
        Furniture of rooms, starting with small rooms.
    empty : indices of rooms that stay empty

    Returns
    -------
    tuple of FurniturePiece, frame ``building``; empty if nothing fits.
    """
    zones = [_door_zone(plan, index) for index in range(len(plan.doors))]
    blocked = shapely.union_all([*zones, *([keep_clear] if keep_clear is not None else [])])
    shapely.prepare(blocked)
    densities = _draw_densities(rng)
    pieces: list[FurniturePiece] = []
    for number, (room, outline) in enumerate(zip(plan.rooms, plan.outlines, strict=True)):
        if number in empty:
            continue
        makers = _draw_makers(room, outline, densities, stocks, rng)
        pieces += _furnish_room(room, outline, blocked, makers, rng)
    return tuple(pieces)


def furnish_loosely(plan: BuildingPlan, rng: np.random.Generator) -> Boxes:
    """
    Furnish a storey quickly; pieces may overlap or extend into walls.

    This suffices for a planar slice or a drawing; callers must clip the rasterized pieces to the
    rooms. Doors stay clear.
    """
    doors = np.array([door.ends.mean(axis=0) for door in plan.doors]).reshape(-1, 2)
    densities = _draw_densities(rng)
    pieces: list[FurniturePiece] = []
    places, yaws = [np.zeros((0, 2))], [np.zeros(0)]
    for room, outline in zip(plan.rooms, plan.outlines, strict=True):
        found = [make(rng) for make in _draw_makers(room, outline, densities, STANDING, rng)]
        is_free = np.array([piece.kind in _FREE_STANDING for piece in found], dtype=np.bool_)
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
    """Sample the number of pieces per square metre for each kind of room of a building."""
    return {
        'room': rng.uniform(*ROOM_DENSITY_PER_M2),
        'corridor': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
        'hall': rng.uniform(*CORRIDOR_DENSITY_PER_M2),
    }


def _draw_makers(
    room: PlanRoom,
    outline: Polygon,
    densities: dict[str, float],
    stocks: Sequence[Stock],
    rng: np.random.Generator,
) -> list[Maker]:
    """Sample the makers of a room's furniture, without positions."""
    count = min(_MAX_PIECES, int(rng.poisson(densities[room.kind] * outline.area)))
    if room.kind == 'room':
        stock = next(stock for stock in stocks if outline.area <= stock.most_m2)
        return [stock.draw] * count
    fixtures = int(rng.poisson(outline.length / FIXTURE_SPACING_M))
    return [*[corridor_cabinet] * count, *[fixture] * fixtures]


def _loose_places(
    rng: np.random.Generator, ring: Array, is_free: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """
    Return positions (B, 2) and angles (B,) for pieces in a room.

    They are on the counter-clockwise outline ``ring (V, 2)`` or midway between two points on it.
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
    """Return a door's opening, extended by the clearance into both rooms."""
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
    """Place one piece per maker, clear of other pieces and of ``blocked``, where it fits."""
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
    """Return whether the pieces leave a passage through the corridor."""
    half = _PASSAGE_M / 2.0
    free = shapely.difference(outline, shapely.union_all([p.footprint for p in pieces]))
    before = shapely.get_num_geometries(outline.buffer(-half))
    return bool(shapely.get_num_geometries(free.buffer(-half)) == before)


def _place(
    piece: FurniturePiece, ring: Array, outline: Polygon, rng: np.random.Generator
) -> FurniturePiece:
    """Return the piece at a random pose: tables anywhere in a room, others against a wall."""
    if piece.kind not in _FREE_STANDING:
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
    """Return the piece at a random position along a counter-clockwise outline (V, 2)."""
    edges = np.roll(ring, -1, axis=0) - ring
    lengths = np.linalg.norm(edges, axis=1)
    index = int(rng.choice(len(ring), p=lengths / lengths.sum()))
    along = edges[index] / lengths[index]
    inwards = np.array([-along[1], along[0]])
    offset = rng.uniform(0.0, lengths[index])
    xy = ring[index] + offset * along + rng.uniform(*_WALL_GAP_M) * inwards
    return piece.moved(xy, float(np.arctan2(along[1], along[0])))
