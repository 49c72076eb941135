# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What differs between the drawing and the building: doors, walls, furniture, glass."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_core.sim.clutter import Boxes, furnish_boxes
from fpnet_core.sim.config import BuildingConfig
from fpnet_core.sim.render import door_outline, fill_polygons, shell_outlines
from fpnet_core.sim.scan2d import EMPTY, GLASS, LINTEL, SOLID
from fpnet_core.sim.types import BuildingPlan, PlanDoor

WORLD_CELL_M = 0.05
"""Cell edge of the raster that rays are cast in."""

OUTSIDE_M = 6.0
"""How far the world goes on outside, for rays that leave through glass."""

MAX_SHIFT_M = 1.5
"""Doors are drawn at most this far from where they are."""

_CORNER_M = 0.25
_PARTITION_M = 0.1
_GLASS_PIECE_M = (0.8, 3.0)


@dataclass(frozen=True, eq=False)
class Changes:
    """How a building differs from its plan: shut doors, removed and added walls, furniture."""

    closed: frozenset[int]
    removed: tuple[Polygon, ...]
    added: tuple[Polygon, ...]
    glass: tuple[Polygon, ...]
    furniture: Boxes | None


@dataclass(frozen=True, eq=False)
class World:
    """
    A building as rays meet it; rasters (H, W) uint8 of the codes in :mod:`..scan2d`.

    ``body`` is what a level ray at the scanner's height meets; ``high`` what a ray above door
    height meets, lintels included; ``room_of (H, W) int32`` is the room's index or -1.
    """

    body: NDArray[np.uint8]
    high: NDArray[np.uint8]
    room_of: NDArray[np.int32]
    origin: NDArray[np.float64]

    def to_cells(self, xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Map building metres (..., 2) to x, y in cells."""
        return (xy - self.origin) / WORLD_CELL_M


def draw_changes(plan: BuildingPlan, rng: np.random.Generator, config: BuildingConfig) -> Changes:
    """Draw how the building differs from its plan."""
    share = rng.uniform(*config.closed_doors)
    shut = [i for i, door in enumerate(plan.doors) if not door.is_open and rng.random() < share]
    return Changes(
        closed=frozenset(shut),
        removed=_removed_walls(plan, rng) if rng.random() < config.removed_walls else (),
        added=_added_walls(plan, rng) if rng.random() < config.added_walls else (),
        glass=_glass(plan, rng, rng.uniform(*config.glass)),
        furniture=furnish_boxes(plan, rng) if rng.random() < config.furnished else None,
    )


def move_doors(plan: BuildingPlan, rng: np.random.Generator, share: float) -> BuildingPlan:
    """Return the plan with a ``share`` of its doors moved along their walls, where that fits."""
    outlines = [Polygon(room.polygon) for room in plan.rooms]
    doors = list(plan.doors)
    for i, door in enumerate(doors):
        if not door.is_open and rng.random() < share:
            along = (door.ends[1] - door.ends[0]) / door.width_m
            moved = replace(door, ends=door.ends + along * rng.uniform(-MAX_SHIFT_M, MAX_SHIFT_M))
            if _is_in_wall(moved, outlines, plan.wall_m):
                doors[i] = moved
    return replace(plan, doors=tuple(doors))


def _is_in_wall(door: PlanDoor, outlines: list[Polygon], wall_m: float) -> bool:
    """Say whether a door, with a margin at its ends, has one of its rooms on either side."""
    along = (door.ends[1] - door.ends[0]) / door.width_m
    normal = np.array([-along[1], along[0]]) * (wall_m / 2.0 + _PARTITION_M)
    ends = door.ends + np.array([-1.0, 1.0])[:, None] * along * _CORNER_M
    a, b = (outlines[i] for i in door.rooms)
    over, under = shapely.points(ends + normal), shapely.points(ends - normal)
    return any(
        bool(shapely.contains(first, over).all() and shapely.contains(second, under).all())
        for first, second in ((a, b), (b, a))
    )


def _removed_walls(plan: BuildingPlan, rng: np.random.Generator) -> tuple[Polygon, ...]:
    """Return wall pieces between one or two pairs of neighbouring rooms, as if taken down."""
    outlines = [Polygon(room.polygon) for room in plan.rooms]
    rooms = [i for i, room in enumerate(plan.rooms) if room.kind == 'room']
    grown = [outlines[i].buffer(plan.wall_m, join_style='mitre') for i in rooms]
    tree, removed = shapely.STRtree(grown), []
    for pick in rng.permutation(len(rooms))[: int(rng.integers(1, 3))].tolist():
        near = [k for k in tree.query(grown[pick], 'intersects').tolist() if k != pick]
        if near:
            other = int(rng.choice(near))
            gap = grown[pick].intersection(grown[other])
            keep = shapely.union_all(
                [o for i, o in enumerate(outlines) if i not in (rooms[pick], rooms[other])]
            )
            parts = shapely.get_parts(gap.difference(keep.buffer(plan.wall_m / 2.0)))
            removed += [p for p in parts.tolist() if isinstance(p, Polygon) and p.area > 0.2]
    return tuple(removed)


def _added_walls(plan: BuildingPlan, rng: np.random.Generator) -> tuple[Polygon, ...]:
    """Return partitions that cross one or two large rooms, each with a gap to pass."""
    large = [r for r in plan.rooms if r.kind == 'room' and Polygon(r.polygon).area > 18.0]
    added = []
    for pick in rng.permutation(len(large))[: int(rng.integers(1, 3))].tolist():
        box = Polygon(large[pick].polygon).minimum_rotated_rectangle
        a, b, c, d = shapely.get_coordinates(box)[:4]
        if np.hypot(*(b - a)) < np.hypot(*(c - b)):
            a, b, c, d = b, c, d, a
        at, gap = rng.uniform(0.35, 0.65), rng.uniform(0.1, 0.8)
        start, end = a + at * (b - a), d + at * (c - d)
        length = float(np.hypot(*(end - start)))
        left = np.clip(gap - 0.5 / length, 0.0, 1.0)
        right = np.clip(gap + 0.5 / length, 0.0, 1.0)
        for f0, f1 in ((0.0, left), (right, 1.0)):
            wall = shapely.LineString([start + f0 * (end - start), start + f1 * (end - start)])
            added.append(wall.buffer(_PARTITION_M / 2.0, cap_style='flat'))
    return tuple(wall for wall in added if not wall.is_empty)


def _glass(plan: BuildingPlan, rng: np.random.Generator, share: float) -> tuple[Polygon, ...]:
    """Return pieces of wall that are glass, about ``share`` of the length of all walls."""
    edges = np.concatenate(
        [
            np.stack([room.polygon, np.roll(room.polygon, -1, axis=0)], axis=1)
            for room in plan.rooms
        ]
    )
    lengths = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    pieces, budget = [], share * lengths.sum()
    while budget > 0.0:
        start, end = edges[rng.choice(len(edges), p=lengths / lengths.sum())]
        length = float(np.hypot(*(end - start)))
        size = min(length, rng.uniform(*_GLASS_PIECE_M))
        along = (end - start) / length
        first = start + along * rng.uniform(0.0, length - size)
        outwards = np.array([along[1], -along[0]]) * (plan.wall_m + WORLD_CELL_M)
        pieces.append(
            Polygon(
                [first, first + along * size, first + along * size + outwards, first + outwards]
            )
        )
        budget -= size
    return tuple(pieces)


def build_world(plan: BuildingPlan, changes: Changes, scan_height_m: float) -> World:
    """
    Rasterise a building for rays at ``scan_height_m`` and for rays above its doors.

    Furniture blocks a level ray where one of its boxes spans the scanner's height; nothing
    reaches above the doors.
    """
    shell = shell_outlines(plan, plan.wall_m)
    corners = np.concatenate(shell)
    origin = corners.min(axis=0) - OUTSIDE_M
    cols, rows = np.ceil((corners.max(axis=0) + OUTSIDE_M - origin) / WORLD_CELL_M).astype(int)

    def cells(rings: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
        return [(ring - origin) / WORLD_CELL_M for ring in rings]

    def paint(raster: NDArray[np.uint8], polygons: list[Polygon], code: int) -> None:
        rings = [shapely.get_coordinates(polygon.exterior)[:-1] for polygon in polygons]
        fill_polygons(raster, cells(rings), code)

    high = np.full((rows, cols), EMPTY, np.uint8)
    fill_polygons(high, cells(shell), SOLID)
    glass = np.zeros_like(high)
    paint(glass, list(changes.glass), 1)
    high[(glass == 1) & (high == SOLID)] = GLASS
    rooms = cells([room.polygon for room in plan.rooms])
    fill_polygons(high, rooms, EMPTY)
    paint(high, list(changes.removed), EMPTY)
    openings = [door_outline(door, plan.wall_m, plan.wall_m) for door in plan.doors]
    fill_polygons(
        high, cells([o for o, d in zip(openings, plan.doors, strict=True) if d.is_open]), EMPTY
    )
    paint(high, list(changes.added), SOLID)
    body = high.copy()
    for i, (door, opening) in enumerate(zip(plan.doors, openings, strict=True)):
        if not door.is_open and i not in changes.closed:
            fill_polygons(body, cells([opening]), EMPTY)
    room_of = np.full((rows, cols), -1, np.int32)
    for i, ring in enumerate(rooms):
        fill_polygons(room_of, [ring], i)
    high[(high != EMPTY) & (body == EMPTY)] = LINTEL
    if changes.furniture is not None:
        standing = np.zeros_like(body)
        fill_polygons(standing, cells(changes.furniture.met_at(scan_height_m)), 1, keep_thin=True)
        body[(standing == 1) & (room_of >= 0)] = SOLID
    return World(body, high, room_of, origin)
