# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differences between drawing and building: doors, walls, furniture, glass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_lab.sim.buildings.furnishing import furnish_loosely
from fpnet_lab.sim.buildings.furniture import Boxes
from fpnet_lab.sim.config import BuildingConfig
from fpnet_lab.sim.drawn.render import door_outline, fill_polygons, shell_outlines
from fpnet_lab.sim.drawn.walls import WallChanges, draw_wall_changes
from fpnet_lab.sim.pairs.scan2d import EMPTY, GLASS, LINTEL, SOLID
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, ring_of

WORLD_CELL_M = 0.05
"""Numerical: cell edge of the ray casting raster."""

OUTSIDE_M = 6.0
"""Numerical: margin of the raster outside of the building, for rays through glass."""

MAX_SHIFT_M = 1.5
"""Maximum displacement of a door from its drawn position. Chosen."""

# Chosen, not measured:
_CORNER_M = 0.25
_SIDE_M = 0.1  # distance from the wall at which a door must be inside its rooms


@dataclass(frozen=True, eq=False)
class Changes:
    """Differences between a building and its plan: doors, walls and furniture."""

    doors: tuple[PlanDoor, ...]
    closed: frozenset[int]
    walls: WallChanges
    furniture: Boxes | None


@dataclass(frozen=True, eq=False)
class World:
    """
    A building for ray casting; rasters (H, W) uint8 with codes of :mod:`..scan2d`.

    ``body`` contains the obstacles at the scanner's height, ``high`` those above door height,
    including lintels; ``room_of (H, W) int32`` is the room index or -1.
    """

    body: NDArray[np.uint8]
    high: NDArray[np.uint8]
    room_of: NDArray[np.int32]
    origin: NDArray[np.float64]

    def to_cells(self, xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert positions (..., 2) in the building [m] to x, y in cells."""
        return (xy - self.origin) / WORLD_CELL_M


def draw_changes(plan: BuildingPlan, rng: np.random.Generator, config: BuildingConfig) -> Changes:
    """Sample the differences between the building and its plan."""
    share = rng.uniform(*config.closed_doors)
    shut = [i for i, door in enumerate(plan.doors) if not door.is_open and rng.random() < share]
    return Changes(
        doors=move_doors(plan, rng, config.moved_doors),
        closed=frozenset(shut),
        walls=draw_wall_changes(plan, rng, config),
        furniture=furnish_loosely(plan, rng) if rng.random() < config.furnished else None,
    )


def move_doors(plan: BuildingPlan, rng: np.random.Generator, share: float) -> tuple[PlanDoor, ...]:
    """Return the doors, with a ``share`` of them moved along their walls where they fit."""
    doors = list(plan.doors)
    for i, door in enumerate(doors):
        if not door.is_open and rng.random() < share:
            moved = replace(
                door, ends=door.ends + door.along * rng.uniform(-MAX_SHIFT_M, MAX_SHIFT_M)
            )
            a, b = plan.outlines[list(door.rooms)]
            if _is_in_wall(moved, a, b, plan.wall_m):
                doors[i] = moved
    return tuple(doors)


def _is_in_wall(door: PlanDoor, a: Polygon, b: Polygon, wall_m: float) -> bool:
    """Return whether a door, with a margin at its ends, has its two rooms on both sides."""
    normal = door.normal * (wall_m / 2.0 + _SIDE_M)
    ends = door.ends + np.array([-1.0, 1.0])[:, None] * door.along * _CORNER_M
    over, under = shapely.points(ends + normal), shapely.points(ends - normal)
    return any(
        bool(shapely.contains(first, over).all() and shapely.contains(second, under).all())
        for first, second in ((a, b), (b, a))
    )


def build_world(plan: BuildingPlan, changes: Changes, scan_height_m: float) -> World:
    """
    Rasterize a building for rays at ``scan_height_m`` and for rays above its doors.

    Furniture blocks a horizontal ray if one of its boxes spans the scanner's height. No furniture
    reaches above the doors.
    """
    shell = shell_outlines(plan, plan.wall_m)
    corners = np.concatenate(shell)
    origin = corners.min(axis=0) - OUTSIDE_M
    cols, rows = np.ceil((corners.max(axis=0) + OUTSIDE_M - origin) / WORLD_CELL_M).astype(int)

    def cells(rings: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
        return [(ring - origin) / WORLD_CELL_M for ring in rings]

    def paint(raster: NDArray[np.uint8], polygons: Sequence[Polygon], code: int) -> None:
        rings = [ring_of(polygon) for polygon in polygons]
        fill_polygons(raster, cells(rings), code)

    high = np.full((rows, cols), EMPTY, np.uint8)
    fill_polygons(high, cells(shell), SOLID)
    glass = np.zeros_like(high)
    paint(glass, changes.walls.glass, 1)
    high[(glass == 1) & (high == SOLID)] = GLASS
    rooms = cells([room.polygon for room in plan.rooms])
    fill_polygons(high, rooms, EMPTY)
    paint(high, changes.walls.removed, EMPTY)
    openings = cells([door_outline(door, plan.wall_m, plan.wall_m) for door in changes.doors])
    is_open = np.array([door.is_open for door in changes.doors], dtype=np.bool_)
    is_shut = np.isin(np.arange(len(openings)), list(changes.closed))
    fill_polygons(high, list(compress(openings, is_open)), EMPTY)
    paint(high, changes.walls.added, SOLID)
    body = high.copy()
    fill_polygons(body, list(compress(openings, ~is_open & ~is_shut)), EMPTY)
    high[(high != EMPTY) & (body == EMPTY)] = LINTEL
    room_of = np.full((rows, cols), -1, np.int32)
    for i, ring in enumerate(rooms):
        # Rooms may include half a cell of wall, so polygons need not be shrunk.
        fill_polygons(room_of, [ring], i, keep_thin=True)
    if changes.furniture is not None:
        standing = np.zeros_like(body)
        fill_polygons(standing, cells(changes.furniture.met_at(scan_height_m)), 1, keep_thin=True)
        body[(standing == 1) & (room_of >= 0)] = SOLID
    return World(body, high, room_of, origin)
