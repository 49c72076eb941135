# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Styles of walls and windows of a varied sheet: outer and inner walls, glass, separators."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_lab.sim.sheets.artwork import Area, Array, Lines, Mark, Pen, Role, lines_of
from fpnet_lab.sim.sheets.hatching import hatched
from fpnet_lab.sim.sheets.interior_style import InteriorStyle, WallPaint
from fpnet_lab.sim.sheets.looks import THIN_PEN_MM, Look
from fpnet_lab.sim.sheets.storeys import (
    PlacedStorey,
    areas_of,
    outer_wall_m,
    outlines_of,
    solid_parts,
)
from fpnet_lab.sim.types import polygons_from_rings

_SKIN_M = 0.01  # numerical: overlap of wall parts, so that no gap shows between them
# Chosen, not measured:
_MULLION_DEPTH = 0.6  # length of a mullion relative to the depth of the window
_SILL_OUT = 0.5  # overhang of a sill relative to the depth of the window
_GLASS_LIGHT = 0.9


def wall_marks(storey: PlacedStorey, look: Look, style: InteriorStyle) -> list[Mark]:
    """Return the marks of all walls, inner walls first, and of the windows."""
    walls, panes = solid_parts(storey, look)
    depth = outer_wall_m(storey, look) + (storey.drawn_wall_m - storey.plan.wall_m) / 2.0
    shell = storey.shell(outer_wall_m(storey, look))
    core = shapely.buffer(shell, _SKIN_M - depth, join_style='mitre')
    inner, outer = shapely.intersection(walls, core), shapely.difference(walls, core)
    marks: list[Mark] = []
    glass = _glass(inner, storey, style)
    if not glass.is_empty:
        inner = shapely.difference(inner, glass)
        marks += areas_of(glass, Role.WALL_PATTERN, (_GLASS_LIGHT,) * 3)
        pen = look.pen(THIN_PEN_MM, style.glass)
        marks += lines_of(Role.WALL, outlines_of(glass), pen, is_closed=True)
    if style.separator is not None:
        marks += areas_of(inner, Role.WALL, style.separator)
    elif style.inner == style.outer and glass.is_empty:
        return _painted(walls, style.outer, look, depth, shell) + window_marks(panes, look, style)
    else:
        marks += _painted(inner, style.inner, look, 0.0, None)
    if style.separator is not None and style.has_thin_outer and style.outer.kind == 'as look':
        marks += areas_of(outer, Role.WALL, style.separator)
    else:
        marks += _painted(outer, style.outer, look, depth, shell)
    return marks + window_marks(panes, look, style)


def _glass(inner: BaseGeometry, storey: PlacedStorey, style: InteriorStyle) -> BaseGeometry:
    """Return the inner walls around a few rooms, to be drawn as glass."""
    if style.glass_share <= 0.0:
        return shapely.Polygon()
    rng = np.random.default_rng(style.seed)
    chosen = rng.random(len(storey.rooms)) < style.glass_share
    rooms = [
        room for room, is_glass in zip(storey.rooms, chosen.tolist(), strict=True) if is_glass
    ]
    if not rooms:
        return shapely.Polygon()
    reach = storey.drawn_wall_m * 1.02
    around = shapely.buffer(polygons_from_rings(rooms), reach, join_style='mitre')
    return shapely.intersection(inner, shapely.union_all(around))


def _painted(
    walls: BaseGeometry, paint: WallPaint, look: Look, depth_m: float, shell: BaseGeometry | None
) -> list[Mark]:
    """Return walls in one style; a cavity line needs the ``shell`` of outer walls."""
    kind: str = paint.kind
    if kind == 'as look':
        kind = {'solid': 'solid', 'thin': 'solid', 'tinted': 'coloured'}.get(
            look.walls, look.walls
        )
    if kind == 'solid':
        return areas_of(walls, Role.WALL, look.ink)
    if kind == 'pale':
        return areas_of(walls, Role.WALL, paint.colour)
    marks: list[Mark] = []
    pen = look.pen(paint.pen_mm, look.ink)
    rings = outlines_of(walls)
    if kind == 'coloured':
        marks += areas_of(walls, Role.WALL_PATTERN, paint.colour)
    if kind == 'hatched':
        thin = look.pen(min(paint.pen_mm, THIN_PEN_MM))
        spacing = max(look.mm(paint.hatch_mm), 4.0 * thin.width_m)
        strokes = list(hatched(rings, paint.hatch_rad, spacing))
        marks += lines_of(Role.WALL_PATTERN, strokes, thin)
    if kind == 'cavity' and shell is not None:
        middle = shapely.buffer(shell, -depth_m / 2.0, join_style='mitre').boundary
        parts = shapely.get_parts(shapely.intersection(middle, walls)).tolist()
        lines = [shapely.get_coordinates(p) for p in parts if p.geom_type == 'LineString']
        marks += lines_of(Role.WALL_PATTERN, lines, look.pen(THIN_PEN_MM, look.ink))
    return marks + lines_of(Role.WALL, rings, pen, is_closed=True)


def window_marks(panes: Array, look: Look, style: InteriorStyle) -> list[Mark]:
    """Return the marks of windows (N, 4, 2): two inner corners, then two outer corners."""
    if not len(panes):
        return []
    paint = style.windows
    pen = look.pen(THIN_PEN_MM, paint.colour)
    a, b, far_b, far_a = (panes[:, i] for i in range(4))
    out = far_a - a
    marks: list[Mark] = []
    if paint.kind == 'gap':
        return marks
    if paint.kind == 'filled':
        colour = paint.colour or look.line
        return [Area(Role.WINDOW, tuple(panes), colour)]
    jambs = [*np.stack([a, far_a], axis=1), *np.stack([b, far_b], axis=1)]
    marks += lines_of(Role.WINDOW, jambs, pen)
    shares = {1: (0.5,), 2: (0.0, 1.0), 3: (0.0, 0.5, 1.0)}[paint.lines]
    for share in shares:
        strokes = np.stack([a + share * out, b + share * out], axis=1)
        marks += lines_of(Role.WINDOW, list(strokes), pen)
    if paint.kind == 'sill':
        sill = np.stack([far_a, far_b, far_b + _SILL_OUT * out, far_a + _SILL_OUT * out], axis=1)
        marks += lines_of(Role.WINDOW, list(sill), pen, is_closed=True)
    if paint.kind == 'mullions':
        marks += _mullions(a, b, out, paint.mullion_m, look.pen(2.0 * THIN_PEN_MM, paint.colour))
    return marks


def _mullions(a: Array, b: Array, out: Array, pitch_m: float, pen: Pen) -> list[Mark]:
    strokes: list[Array] = []
    for start, end, depth in zip(a, b, out, strict=True):
        count = max(2, round(float(np.linalg.norm(end - start)) / pitch_m) + 1)
        at = start + np.linspace(0.0, 1.0, count)[:, None] * (end - start)
        middle, half = at + depth / 2.0, _MULLION_DEPTH / 2.0 * depth
        strokes += list(np.stack([middle - half, middle + half], axis=1))
    return [Lines(Role.WINDOW, tuple(strokes), pen)]
