# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where one can stand in a building: rooms, and the openings that join them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import MultiPolygon, Polygon

from fpnet_lab.sim.types import BuildingPlan, PlanDoor

# Numerical: an opening reaches this far into both rooms, so that unions have no hair-thin walls.
_OVERLAP_M = 0.01


def room_polygons(plan: BuildingPlan) -> list[Polygon]:
    """Return the rooms' outlines, in the plan's order."""
    return [Polygon(room.polygon) for room in plan.rooms]


def door_normal(door: PlanDoor) -> NDArray[np.float64]:
    """Return the unit normal (2,) of a door's opening line; its sign is arbitrary."""
    along = (door.ends[1] - door.ends[0]) / door.width_m
    return np.array([-along[1], along[0]])


def opening_polygon(plan: BuildingPlan, door: PlanDoor) -> Polygon:
    """Return the opening of ``door`` through the whole wall, overlapping both rooms a little."""
    # A door frame of its own may stand nearer to the ends than the wall's face to the middle.
    along = shapely.points([*door.ends, door.ends.mean(axis=0)])
    rooms = [Polygon(plan.rooms[index].polygon) for index in door.rooms]
    gap_m = max(float(shapely.distance(room, along).max()) for room in rooms)
    reach = (gap_m + _OVERLAP_M) * door_normal(door)
    return Polygon([*(door.ends - reach), *(door.ends + reach)[::-1]])


def walkable_area(plan: BuildingPlan) -> Polygon | MultiPolygon:
    """Return the union of all rooms and openings; several parts for disconnected wings."""
    openings = [opening_polygon(plan, door) for door in plan.doors]
    return shapely.union_all([*room_polygons(plan), *openings])
