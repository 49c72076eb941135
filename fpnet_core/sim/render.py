# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A building's plan as a drawing: the raster that a robot is given."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.sim.types import BuildingPlan, PlanDoor
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

_SUBPIXEL_BITS = 6
"""Binary digits after the point of polygon corners handed to the rasteriser."""

DOOR_OVERLAP_M = 0.05
"""How far a door's cut reaches into the rooms, so that no skin of wall remains."""

MIN_WALL_PX = 1.5
"""Thinner walls would leak where they run diagonally."""


def render_plan(
    plan: BuildingPlan,
    resolution_m: float,
    wall_m: float | None = None,
    T_plan_building: Affine2D | None = None,
    margin_m: float = 1.0,
) -> GridMap:
    """
    Draw rooms and doors free, walls occupied, the outside unknown.

    Parameters
    ----------
    plan : the storey, frame ``building``
    resolution_m : cell edge [m]
    wall_m : drawn wall thickness; None takes the plan's. Never under 1.5 cells
    T_plan_building : where and how (rotated, stretched) the drawing shows the building
    margin_m : unknown border around the drawing

    Returns
    -------
    GridMap in frame ``plan``; its lower left corner is the drawing's.
    """
    A = T_plan_building if T_plan_building is not None else Affine2D.identity()
    wall = max(wall_m if wall_m is not None else plan.wall_m, MIN_WALL_PX * resolution_m)
    outlines = room_outlines(plan, wall)
    free = [A.apply(outline) for outline in outlines]
    doors = [A.apply(door_outline(door, wall, plan.wall_m)) for door in plan.doors]
    shell = [A.apply(ring) for ring in shell_outlines(plan, wall)]
    corners = np.concatenate(shell)
    origin = corners.min(axis=0) - margin_m
    columns, rows = np.ceil((corners.max(axis=0) + margin_m - origin) / resolution_m).astype(int)
    cells = np.full((rows, columns), UNKNOWN, np.int8)
    fill_polygons(cells, [(ring - origin) / resolution_m for ring in shell], OCCUPIED)
    fill_polygons(cells, [(ring - origin) / resolution_m for ring in free + doors], FREE)
    return GridMap(cells, resolution_m, SE2.from_xy_yaw(origin[0], origin[1], 0.0), 'plan')


def room_outlines(plan: BuildingPlan, wall_m: float) -> list[NDArray[np.float64]]:
    """Return each room's outline (V, 2) for walls of another thickness; none vanishes."""
    polygons = shapely.polygons([shapely.linearrings(room.polygon) for room in plan.rooms])
    grown = shapely.buffer(polygons, (plan.wall_m - wall_m) / 2.0, join_style='mitre')
    kept = np.where(shapely.get_type_id(grown) == shapely.GeometryType.POLYGON, grown, polygons)
    kept = np.where(shapely.is_empty(kept), polygons, kept)
    return [shapely.get_coordinates(polygon.exterior)[:-1] for polygon in kept]


def door_outline(door: PlanDoor, wall_m: float, true_wall_m: float) -> NDArray[np.float64]:
    """
    Return the rectangle (4, 2) that a door cuts out of a wall drawn ``wall_m`` thick.

    A full-height opening narrows with its corridor where walls are drawn thicker than they are.
    """
    along = (door.ends[1] - door.ends[0]) / max(door.width_m, 1e-9)
    inset = along * (wall_m - true_wall_m) / 2.0 if door.is_open else np.zeros(2)
    normal = np.array([-along[1], along[0]]) * (max(wall_m, true_wall_m) / 2.0 + DOOR_OVERLAP_M)
    a, b = door.ends[0] + inset, door.ends[1] - inset
    return np.stack([a - normal, b - normal, b + normal, a + normal])


def shell_outlines(plan: BuildingPlan, outer_wall_m: float) -> list[NDArray[np.float64]]:
    """Return the outlines of everything built: rooms grown by their walls, shafts left out."""
    polygons = [shapely.Polygon(room.polygon) for room in plan.rooms]
    grown = shapely.buffer(polygons, max(outer_wall_m, plan.wall_m), join_style='mitre')
    return [shapely.get_coordinates(polygon.exterior)[:-1] for polygon in grown]


def fill_polygons(
    cells: NDArray[np.integer[Any]],
    rings_px: list[NDArray[np.float64]],
    value: int,
    keep_thin: bool = False,
) -> None:
    """
    Set the cells whose centres lie in any of the rings, in place.

    ``rings_px (V, 2)`` are x, y in cells from the raster's outer corner. The rasteriser also
    covers cells that an outline merely touches, hence the inset by half a cell; ``keep_thin``
    leaves it out, so that chair legs and the like cover a cell at least.
    """
    rings = list(rings_px)
    if not keep_thin:
        polygons = shapely.buffer(
            [shapely.Polygon(ring) for ring in rings_px], -0.5, join_style='mitre'
        )
        parts = shapely.get_parts(polygons).tolist()
        rings = [shapely.get_coordinates(part.exterior)[:-1] for part in parts]
    scale = 1 << _SUBPIXEL_BITS
    for ring in rings:
        corners = np.rint((ring - 0.5) * scale).astype(np.int32)
        if len(corners):
            cv2.fillPoly(cells, [corners], value, shift=_SUBPIXEL_BITS)
