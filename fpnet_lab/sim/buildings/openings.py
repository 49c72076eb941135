# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Walkable area of a building: rooms and the openings between them."""

from __future__ import annotations

import shapely
from shapely import MultiPolygon, Polygon

from fpnet_lab.sim.types import BuildingPlan, PlanDoor

# Numerical: an opening extends this far into both rooms, so that unions leave no thin gaps.
_OVERLAP_M = 0.01


def opening_polygon(plan: BuildingPlan, door: PlanDoor) -> Polygon:
    """Return the opening of ``door`` through the whole wall, slightly overlapping both rooms."""
    # Rooms may be farther from the door's ends than from its middle, so the maximum is used.
    along = shapely.points([*door.ends, door.ends.mean(axis=0)])
    rooms = plan.outlines[list(door.rooms)]
    gap_m = float(shapely.distance(rooms[:, None], along).max())
    reach = (gap_m + _OVERLAP_M) * door.normal
    return Polygon([*(door.ends - reach), *(door.ends + reach)[::-1]])


def walkable_area(plan: BuildingPlan) -> Polygon | MultiPolygon:
    """Return the union of all rooms and openings; several parts for disconnected wings."""
    openings = [opening_polygon(plan, door) for door in plan.doors]
    return shapely.union_all([*plan.outlines, *openings])
