# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Wall areas and wall lines of a model with their doors cut out, for exports."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from shapely import LineString, Polygon, unary_union

from fpnet_core.drawings.model import FloorplanModel, ModelRoom, Rings
from fpnet_core.drawings.model_raster import WALL_M, rectangle
from fpnet_core.drawings.types import Array

_MITRE = 2  # given: shapely's code for mitred corners
_MARGIN_M = 0.02  # numerical: doors are cut this far beyond the faces of walls
_LEAST_M2 = 1e-4  # numerical: smaller fragments of walls are dropped


def solid_walls(model: FloorplanModel) -> list[Rings]:
    """Return the areas of walls; without walls, bands around the rooms."""
    walls = unary_union([polygon_of(wall.rings) for wall in model.walls])
    if not model.walls:
        rooms = unary_union([polygon_of(room.rings) for room in model.rooms])
        around = [polygon_of(room.rings).buffer(WALL_M, join_style=_MITRE) for room in model.rooms]
        walls = unary_union(around).difference(rooms)
    doors = [Polygon(rectangle(door, 2.0 * _MARGIN_M, WALL_M)) for door in model.doors]
    return rings_of(walls.difference(unary_union(doors)))


def wall_lines(model: FloorplanModel, thickness_m: float) -> list[Array]:
    """Return centre lines (2, 2) of walls around each room, with gaps at doors."""
    doors = unary_union([
        Polygon(rectangle(door, 2.0 * thickness_m, 3.0 * thickness_m)) for door in model.doors
    ])  # fmt: skip
    lines: list[Array] = []
    for room in model.rooms:
        around = polygon_of(room.rings).buffer(0.5 * thickness_m, join_style=_MITRE)
        for rings in rings_of(around):
            for ring in rings:
                closed = np.concatenate([ring, ring[:1]])
                for start, end in pairwise(closed):
                    left = LineString([start, end]).difference(doors)
                    lines.extend(_pieces(left, thickness_m))
    return lines


def _pieces(geometry: Any, least_m: float) -> list[Array]:
    parts = getattr(geometry, 'geoms', [geometry])
    return [
        np.asarray(part.coords)[[0, -1]]
        for part in parts
        if part.geom_type == 'LineString' and part.length > 0.1 * least_m
    ]


def polygon_of(rings: Rings) -> Any:
    """Return a valid polygon of rings."""
    return Polygon(rings[0], list(rings[1:])).buffer(0.0)


def rings_of(geometry: Any) -> list[Rings]:
    """Return the rings of each polygon of a shapely geometry, without small fragments."""
    found: list[Rings] = []
    for part in getattr(geometry, 'geoms', [geometry]):
        if part.geom_type == 'Polygon' and part.area > _LEAST_M2:
            rings = (part.exterior, *part.interiors)
            found.append(tuple(np.asarray(ring.coords)[:-1, :2] for ring in rings))
    return found


def middle_of(room: ModelRoom) -> Array:
    """Return a point (2,) well inside of a room, for its name."""
    place = polygon_of(room.rings).representative_point()
    return np.array([place.x, place.y])
