# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A storey as marks: walls, windows, doors, stairs, columns and furniture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_core.geometry import SE2
from fpnet_core.sim.render import MIN_WALL_PX, door_outline, room_outlines, shell_outlines
from fpnet_core.sim.sheets.furnishing import furnish_symbols
from fpnet_core.sim.sheets.looks import Look, Trait
from fpnet_core.sim.sheets.scene import (
    Arcs,
    Area,
    Array,
    Colour,
    Mark,
    Role,
    lines_of,
)
from fpnet_core.sim.symbols import (
    Leaves,
    door_leaves,
    outer_edges,
    windows,
)
from fpnet_core.sim.types import BuildingPlan, polygons_from_rings

_PROBE_M = 0.05
_WALL_PEN_MM, _THIN_PEN_MM = 0.35, 0.18
_PATTERN_MM = (1.0, 2.5)  # distance of a wall's hatching
_TREAD_M = 0.28
_STAIR_AREA_M2, _LIFT_AREA_M2 = (7.0, 30.0), (1.5, 5.0)
_SQUARE = 0.95  # of its smallest rectangle that a room of stairs covers
_COLUMN_M, _COLUMN_EVERY_M = 0.4, 5.4


@dataclass(frozen=True, eq=False)
class PlacedStorey:
    """
    A storey on a sheet.

    ``plan`` is the building's own, ``T_page_building`` where the sheet shows it; ``drawn_wall_m``
    is how thick inner walls are drawn.
    """

    plan: BuildingPlan
    T_page_building: SE2
    drawn_wall_m: float

    @cached_property
    def on_page(self) -> BuildingPlan:
        """The storey in frame ``page``."""
        return moved_plan(self.plan, self.T_page_building)

    @cached_property
    def rooms(self) -> list[Array]:
        """Rooms' outlines (V, 2) [m, page] as drawn."""
        return room_outlines(self.on_page, self.drawn_wall_m)

    @cached_property
    def openings(self) -> list[Array]:
        """Rectangles (4, 2) [m, page] that doors cut out of walls as drawn."""
        plan = self.on_page
        return [door_outline(door, self.drawn_wall_m, plan.wall_m) for door in plan.doors]

    def shell(self, outer_m: float) -> BaseGeometry:
        """Return all that is built, outer walls of ``outer_m`` included [m, page]."""
        return shapely.union_all(polygons_from_rings(shell_outlines(self.on_page, outer_m)))


def moved_plan(plan: BuildingPlan, T: SE2) -> BuildingPlan:
    """Return a storey elsewhere."""
    rooms = tuple(replace(room, polygon=T.apply(room.polygon)) for room in plan.rooms)
    doors = tuple(replace(door, ends=T.apply(door.ends)) for door in plan.doors)
    return replace(plan, rooms=rooms, doors=doors)


def drawn_wall_m(plan: BuildingPlan, look: Look) -> float:
    """Return how thick a look draws inner walls [m]; never too thin to be seen."""
    thinnest = MIN_WALL_PX * look.resolution_m
    if look.walls == 'thin':
        return max(thinnest, look.mm(_WALL_PEN_MM))
    lines = 5.0 if look.walls != 'solid' else 1.0  # two lines and something between them
    return max(plan.wall_m, lines * thinnest / MIN_WALL_PX, thinnest)


def storey_marks(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return the building's own marks, the lowest first; texts and dimensions are elsewhere."""
    outer_m = max(look.outer_m, storey.drawn_wall_m) if look.walls != 'thin' else 0.0
    outer_m = max(outer_m, storey.drawn_wall_m)
    panes = _panes(storey, outer_m) if Trait.WINDOWS in look.traits else np.zeros((0, 4, 2))
    walls = _walls(storey, outer_m, panes)
    marks = _wall_marks(walls, look, rng)
    marks += _pane_marks(panes, look)
    marks += _door_marks(storey, look)
    stairs = stair_rooms(storey) if Trait.STAIRS in look.traits else []
    for is_lift, number in stairs:
        room = storey.rooms[number]
        marks += _lift(room, look) if is_lift else _stairs(room, look, rng)
    if Trait.FURNITURE in look.traits:
        taken = [number for _, number in stairs]
        marks += furnish_symbols(storey.on_page, taken, look.pen(_THIN_PEN_MM), rng)
    if Trait.COLUMNS in look.traits:
        marks += _columns(storey, look)
    return marks


def _walls(storey: PlacedStorey, outer_m: float, panes: Array) -> BaseGeometry:
    """Return everything solid [m, page]."""
    holes = polygons_from_rings([*storey.rooms, *storey.openings, *panes])
    return shapely.difference(storey.shell(outer_m), shapely.union_all(holes))


def _panes(storey: PlacedStorey, outer_m: float) -> Array:
    """Return windows (N, 4, 2) [m, page] in walls behind which there is nothing."""
    depth = outer_m + (storey.drawn_wall_m - storey.plan.wall_m) / 2.0
    edges, normals = outer_edges(storey.rooms)
    panes = windows(edges, normals, depth)
    beyond = panes[:, 2:] + _PROBE_M * normals[:, None]
    shell = storey.shell(outer_m)
    shapely.prepare(shell)
    is_outside = ~shapely.contains_xy(shell, beyond[..., 0], beyond[..., 1])
    return np.asarray(panes[is_outside.all(axis=1)])


def areas_of(shape: BaseGeometry, role: Role, colour: Colour) -> list[Mark]:
    """Return a shape's polygons as filled areas, holes turned against outlines."""
    parts = [part for part in shapely.get_parts(shape).tolist() if part.geom_type == 'Polygon']
    return [
        Area(role, tuple(_rings(part)), colour)
        for part in shapely.orient_polygons(parts).tolist()
        if not part.is_empty
    ]


def _rings(polygon: shapely.Polygon) -> list[Array]:
    return [shapely.get_coordinates(ring)[:-1] for ring in (polygon.exterior, *polygon.interiors)]


def outlines_of(shape: BaseGeometry) -> list[Array]:
    """Return all rings (V, 2) of a shape, not closed."""
    parts = [part for part in shapely.get_parts(shape).tolist() if part.geom_type == 'Polygon']
    return [ring for part in parts for ring in _rings(part)]


def _wall_marks(walls: BaseGeometry, look: Look, rng: np.random.Generator) -> list[Mark]:
    if look.walls in {'solid', 'thin'}:
        return areas_of(walls, Role.WALL, look.ink)
    marks: list[Mark] = []
    if look.walls == 'tinted':
        pale = float(rng.uniform(0.35, 0.75))
        tint = (_paler(look.ink[0], pale), _paler(look.ink[1], pale), _paler(look.ink[2], pale))
        marks += areas_of(walls, Role.WALL_PATTERN, tint)
    if look.walls == 'hatched':
        pen = look.pen(_THIN_PEN_MM)
        spacing = max(look.mm(float(rng.uniform(*_PATTERN_MM))), 4.0 * pen.width_m)
        marks += lines_of(Role.WALL_PATTERN, hatch(walls, np.pi / 4.0, spacing), pen)
    pen = look.pen(_WALL_PEN_MM, look.ink)
    return marks + lines_of(Role.WALL, outlines_of(walls), pen, is_closed=True)


def _paler(value: float, share: float) -> float:
    return value + share * (1.0 - value)


def hatch(shape: BaseGeometry, angle_rad: float, spacing_m: float) -> list[Array]:
    """Return parallel strokes (2, 2) [m] that fill a shape."""
    if shape.is_empty:
        return []
    left, bottom, right, top = shape.bounds
    middle = np.array([(left + right) / 2.0, (bottom + top) / 2.0])
    reach = float(np.hypot(right - left, top - bottom)) / 2.0 + spacing_m
    along = np.array([np.cos(angle_rad), np.sin(angle_rad)])
    across = np.array([-along[1], along[0]])
    offsets = np.arange(-reach, reach, spacing_m)[:, None]
    starts = middle + offsets * across - reach * along
    strokes = shapely.linestrings(np.stack([starts, starts + 2.0 * reach * along], axis=1))
    shapely.prepare(shape)
    parts = shapely.get_parts(shapely.intersection(strokes, shape))
    lines = parts[shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING]
    return [shapely.get_coordinates(line) for line in lines if not shapely.is_empty(line)]


def _pane_marks(panes: Array, look: Look) -> list[Mark]:
    if not len(panes):
        return []
    middle = np.stack([panes[:, [0, 3]].mean(axis=1), panes[:, 1:3].mean(axis=1)], axis=1)
    pen = look.pen(_THIN_PEN_MM)
    faces = lines_of(Role.WINDOW, list(panes), pen, is_closed=True)
    return faces + lines_of(Role.WINDOW, list(middle), pen)


def _door_marks(storey: PlacedStorey, look: Look) -> list[Mark]:
    pen = look.pen(_THIN_PEN_MM)
    marks: list[Mark] = []
    if Trait.THRESHOLDS in look.traits:
        marks += lines_of(Role.DOOR, _thresholds(storey), pen)
    if look.doors == 'gap':
        return marks
    leaves = door_leaves(storey.on_page, storey.drawn_wall_m)
    if not len(leaves.hinge):
        return marks
    lines = np.stack([leaves.hinge, leaves.tips], axis=1)
    marks += lines_of(Role.DOOR, list(lines), look.pen(_WALL_PEN_MM))
    if look.doors == 'arc':
        marks.append(Arcs(Role.DOOR, leaves.hinge, leaves.length[:, 0], _spans(leaves), pen))
    return marks


def _spans(leaves: Leaves) -> Array:
    """Return the angles (L, 2) [rad] between the shut and the open leaf, counter-clockwise."""
    shut = np.arctan2(leaves.along[:, 1], leaves.along[:, 0])
    is_left = leaves.along[:, 0] * leaves.normal[:, 1] > leaves.along[:, 1] * leaves.normal[:, 0]
    start = np.where(is_left, shut, shut - np.pi / 2.0)
    return np.stack([start, start + np.pi / 2.0], axis=1)


def _thresholds(storey: PlacedStorey) -> list[Array]:
    """Return a line (2, 2) on either face of the wall across each door."""
    lines = []
    for door in storey.on_page.doors:
        if door.is_open:
            continue
        along = (door.ends[1] - door.ends[0]) / door.width_m
        normal = np.array([-along[1], along[0]]) * storey.drawn_wall_m / 2.0
        lines += [door.ends + normal, door.ends - normal]
    return lines


def stair_rooms(storey: PlacedStorey) -> list[tuple[bool, int]]:
    """Return the numbers of up to two rooms that are stairs, and closets that are lifts (True)."""
    polygons = polygons_from_rings(storey.rooms)
    areas = shapely.area(polygons)
    squareness = areas / np.maximum(shapely.area(shapely.oriented_envelope(polygons)), 1e-9)
    kinds = np.array([room.kind == 'room' for room in storey.plan.rooms])
    found: list[tuple[bool, int]] = []
    for is_lift, (low, high) in ((False, _STAIR_AREA_M2), (True, _LIFT_AREA_M2)):
        fits = np.flatnonzero(kinds & (areas > low) & (areas < high) & (squareness > _SQUARE))
        found += [(is_lift, int(i)) for i in fits[:: max(1, len(fits) - 1)][:2]]
    return found


def _frame_of(room: Array) -> tuple[Array, Array, Array, float, float]:
    """Return a rectangle's corner, its unit vectors along and across, and both lengths [m]."""
    ring = shapely.get_coordinates(shapely.oriented_envelope(shapely.Polygon(room)))[:4]
    sides = np.roll(ring, -1, axis=0) - ring
    lengths = np.hypot(*sides.T)
    first = int(np.argmax(lengths[:2]))
    along, across = sides[first] / lengths[first], -sides[first - 1] / lengths[first - 1]
    return ring[first], along, across, float(lengths[first]), float(lengths[first - 1])


def _stairs(room: Array, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return two flights side by side with treads, an arrow and a dashed break."""
    corner, along, across, length, width = _frame_of(room)
    landing = min(1.4, 0.3 * length)
    at = np.arange(landing, length - landing, _TREAD_M)
    if not len(at):
        return []
    feet = corner + at[:, None] * along
    treads = np.stack([feet, feet + width * across], axis=1)
    pen = look.pen(_THIN_PEN_MM)
    middle = corner + width / 2.0 * across
    well = np.stack([middle + at[0] * along, middle + at[-1] * along])
    walk = corner + width * (0.25 if rng.random() < 0.5 else 0.75) * across
    ends = np.stack([walk + at[0] * along, walk + at[-1] * along])
    marks = lines_of(Role.STAIRS, list(treads), pen)
    marks += lines_of(Role.STAIRS, [well], look.pen(_WALL_PEN_MM))
    return marks + lines_of(Role.STAIRS, [ends, *arrow_head(ends[0], ends[1], look.mm(2.0))], pen)


def _lift(room: Array, look: Look) -> list[Mark]:
    corner, along, across, length, width = _frame_of(room)
    ring = corner + 0.1 * (along + across)
    along, across = (length - 0.2) * along, (width - 0.2) * across
    box = np.stack([ring, ring + along, ring + along + across, ring + across])
    pen = look.pen(_THIN_PEN_MM)
    cross = [box[[0, 2]], box[[1, 3]]]
    return lines_of(Role.STAIRS, [box], pen, is_closed=True) + lines_of(Role.STAIRS, cross, pen)


def arrow_head(start: Array, end: Array, length_m: float) -> list[Array]:
    """Return the two strokes (2, 2) of an arrow's head at ``end``."""
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    across = np.array([-along[1], along[0]])
    back = end - length_m * along
    return [np.stack([end, back + side * 0.4 * length_m * across]) for side in (-1.0, 1.0)]


def _columns(storey: PlacedStorey, look: Look) -> list[Mark]:
    """Return square columns on a grid, where they stand well inside large rooms."""
    polygons = polygons_from_rings(storey.rooms)
    large = shapely.buffer(polygons[shapely.area(polygons) > 40.0], -1.5)
    (x0, y0), (x1, y1) = storey.on_page.extent
    at = np.stack(
        np.meshgrid(np.arange(x0, x1, _COLUMN_EVERY_M), np.arange(y0, y1, _COLUMN_EVERY_M)), axis=2
    ).reshape(-1, 2)
    kept = at[shapely.contains_xy(shapely.union_all(large), *at.T)]
    square = _COLUMN_M / 2.0 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return [Area(Role.WALL, (centre + square,), look.ink) for centre in kept]
