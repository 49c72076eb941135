# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Marks of a storey: walls, windows and doors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from fpnet_core.geometry import SE2
from fpnet_lab.sim.drawn.render import MIN_WALL_PX, door_outline, room_outlines, shell_outlines
from fpnet_lab.sim.drawn.symbols import Leaves, door_leaves, glazing, hatch, windows
from fpnet_lab.sim.sheets.artwork import (
    Arcs,
    Area,
    Array,
    Colour,
    Mark,
    Role,
    lines_of,
)
from fpnet_lab.sim.sheets.facade import Facade, draw_facade
from fpnet_lab.sim.sheets.looks import THIN_PEN_MM, WALL_PEN_MM, Look, Trait
from fpnet_lab.sim.types import BuildingPlan, polygons_from_rings

MIN_DOUBLE_WALL_PX = 5.0
"""Minimum thickness of walls that are drawn as two lines. Chosen."""

_PROBE_M = 0.05  # numerical
# Chosen, not measured:
_PATTERN_MM = (1.0, 2.5)  # spacing of a wall's hatching


@dataclass(frozen=True, eq=False)
class PlacedStorey:
    """
    A storey on a sheet.

    ``plan`` is in the building frame, ``T_page_building`` its pose on the sheet, ``drawn_wall_m``
    the drawn thickness of inner walls.
    """

    plan: BuildingPlan
    T_page_building: SE2
    drawn_wall_m: float

    @cached_property
    def on_page(self) -> BuildingPlan:
        """Storey in frame ``page``."""
        return self.plan.mapped(self.T_page_building)

    @cached_property
    def rooms(self) -> list[Array]:
        """Room outlines (V, 2) [m, page] as drawn."""
        return room_outlines(self.on_page, self.drawn_wall_m)

    @cached_property
    def openings(self) -> list[Array]:
        """Rectangles (4, 2) [m, page] of door openings as drawn."""
        plan = self.on_page
        return [door_outline(door, self.drawn_wall_m, plan.wall_m) for door in plan.doors]

    def shell(self, outer_m: float) -> BaseGeometry:
        """Return the building's shape including outer walls of ``outer_m`` [m, page]."""
        return shapely.union_all(polygons_from_rings(shell_outlines(self.on_page, outer_m)))


def drawn_wall_m(plan: BuildingPlan, look: Look) -> float:
    """Return the drawn thickness of inner walls [m], large enough to be visible."""
    thinnest = MIN_WALL_PX * look.resolution_m
    has_lines = look.interior is not None and look.interior.has_lines
    if look.walls == 'thin' or has_lines:
        return max(thinnest, look.mm(WALL_PEN_MM))
    least = thinnest if look.walls == 'solid' else MIN_DOUBLE_WALL_PX * look.resolution_m
    return max(plan.wall_m, least)


def storey_marks(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return the marks of walls, windows and doors, the lowest first."""
    walls, panes = solid_parts(storey, look)
    marks = _wall_marks(walls, look, rng)
    marks += _pane_marks(panes, look)
    marks += _door_marks(storey, look)
    return marks


def solid_parts(storey: PlacedStorey, look: Look) -> tuple[BaseGeometry, Array]:
    """Return the solid walls, and the windows (N, 4, 2), as drawn [m, page]."""
    outer_m = outer_wall_m(storey, look)
    if look.interior is not None:
        found = facade(storey, look)
        openings = [*found.panes, *found.entrances]
        return _walls(storey, outer_m, np.array(openings).reshape(-1, 4, 2)), found.panes
    panes = _panes(storey, outer_m) if Trait.WINDOWS in look.traits else np.zeros((0, 4, 2))
    return _walls(storey, outer_m, panes), panes


def outer_wall_m(storey: PlacedStorey, look: Look) -> float:
    """Return the extent of outer walls beyond the true rooms [m]."""
    if look.interior is not None and look.interior.has_thin_outer:
        return (storey.plan.wall_m + storey.drawn_wall_m) / 2.0
    outer_m = max(storey.plan.wall_m, storey.drawn_wall_m)
    return outer_m if look.walls == 'thin' else max(outer_m, look.outer_m)


def facade(storey: PlacedStorey, look: Look) -> Facade:
    """Return windows and entrances of a varied sheet; other sheets have none."""
    if look.interior is None:
        return Facade(np.zeros((0, 4, 2)), np.zeros((0, 4, 2)))
    outer_m = outer_wall_m(storey, look)
    depth = outer_m + (storey.drawn_wall_m - storey.plan.wall_m) / 2.0
    has_windows = Trait.WINDOWS in look.traits
    return draw_facade(storey.rooms, depth, storey.shell(outer_m), look.interior, has_windows)


def _walls(storey: PlacedStorey, outer_m: float, panes: Array) -> BaseGeometry:
    """Return the solid walls [m, page]."""
    holes = polygons_from_rings([*storey.rooms, *storey.openings, *panes])
    return shapely.difference(storey.shell(outer_m), shapely.union_all(holes))


def _panes(storey: PlacedStorey, outer_m: float) -> Array:
    """Return windows (N, 4, 2) [m, page] in walls that face the outside."""
    depth = outer_m + (storey.drawn_wall_m - storey.plan.wall_m) / 2.0
    panes, beyond = windows(storey.rooms, depth, _PROBE_M)
    shell = storey.shell(outer_m)
    shapely.prepare(shell)
    is_outside = ~shapely.contains_xy(shell, beyond[..., 0], beyond[..., 1])
    return np.asarray(panes[is_outside.all(axis=1)])


def areas_of(shape: BaseGeometry, role: Role, colour: Colour) -> list[Mark]:
    """Return a shape's polygons as filled areas, with holes oriented against outlines."""
    parts = [part for part in shapely.get_parts(shape).tolist() if part.geom_type == 'Polygon']
    return [
        Area(role, tuple(_rings(part)), colour)
        for part in (orient(part) for part in parts if not part.is_empty)
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
        pen = look.pen(THIN_PEN_MM)
        spacing = max(look.mm(float(rng.uniform(*_PATTERN_MM))), 4.0 * pen.width_m)
        marks += lines_of(Role.WALL_PATTERN, hatch(walls, np.pi / 4.0, spacing), pen)
    pen = look.pen(WALL_PEN_MM, look.ink)
    return marks + lines_of(Role.WALL, outlines_of(walls), pen, is_closed=True)


def _paler(value: float, share: float) -> float:
    return value + share * (1.0 - value)


def _pane_marks(panes: Array, look: Look) -> list[Mark]:
    if not len(panes):
        return []
    pen = look.pen(THIN_PEN_MM)
    faces = lines_of(Role.WINDOW, list(panes), pen, is_closed=True)
    return faces + lines_of(Role.WINDOW, glazing(panes), pen)


def _door_marks(storey: PlacedStorey, look: Look) -> list[Mark]:
    pen = look.pen(THIN_PEN_MM)
    marks: list[Mark] = []
    if Trait.THRESHOLDS in look.traits:
        marks += lines_of(Role.DOOR, _thresholds(storey), pen)
    if look.doors == 'gap':
        return marks
    leaves = door_leaves(storey.on_page, storey.drawn_wall_m)
    if not len(leaves.hinge):
        return marks
    lines = np.stack([leaves.hinge, leaves.tips], axis=1)
    marks += lines_of(Role.DOOR, list(lines), look.pen(WALL_PEN_MM))
    if look.doors == 'arc':
        marks.append(Arcs(Role.DOOR, leaves.hinge, leaves.length[:, 0], _spans(leaves), pen))
    return marks


def _spans(leaves: Leaves) -> Array:
    """Return counter-clockwise spans (L, 2) [rad] between the closed and the open leaf."""
    shut = np.arctan2(leaves.along[:, 1], leaves.along[:, 0])
    is_left = leaves.along[:, 0] * leaves.normal[:, 1] > leaves.along[:, 1] * leaves.normal[:, 0]
    start = np.where(is_left, shut, shut - np.pi / 2.0)
    return np.stack([start, start + np.pi / 2.0], axis=1)


def _thresholds(storey: PlacedStorey) -> list[Array]:
    """Return lines (2, 2) across each door, on both faces of the wall."""
    lines = []
    for door in storey.on_page.doors:
        if door.is_open:
            continue
        along = (door.ends[1] - door.ends[0]) / door.width_m
        normal = np.array([-along[1], along[0]]) * storey.drawn_wall_m / 2.0
        lines += [door.ends + normal, door.ends - normal]
    return lines


def arrow_head(start: Array, end: Array, length_m: float) -> list[Array]:
    """Return the two strokes (2, 2) of an arrowhead at ``end``."""
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    across = np.array([-along[1], along[0]])
    back = end - length_m * along
    return [np.stack([end, back + side * 0.4 * length_m * across]) for side in (-1.0, 1.0)]
