# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doors and entrances of a varied sheet, in several styles per sheet."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fpnet_lab.sim.sheets.artwork import Arcs, Area, Array, Mark, Pen, Role, lines_of
from fpnet_lab.sim.sheets.interior_style import DoorPaint, InteriorStyle
from fpnet_lab.sim.sheets.looks import Look
from fpnet_lab.sim.sheets.storeys import PlacedStorey, facade
from fpnet_lab.sim.types import DOUBLE_LEAF_M

# Chosen, not measured:
_DASHES_MM = (1.5, 1.0)
_FOLDS = 4
_PANEL_OVERLAP = 0.1  # overlap of two sliding panels relative to the width of the opening
_CLOSED_LEAF = 0.3  # thickness of a closed leaf relative to its wall


@dataclass(frozen=True, eq=False)
class DoorHole:
    """A door opening in a wall, with its local axes; vectors (2,), frame ``page`` [m]."""

    start: Array  # on the wall's centre line
    along: Array  # unit vector along the wall
    normal: Array  # unit vector in the opening direction of leaves
    width_m: float
    wall_m: float  # thickness of the wall

    def at(self, along_m: float, normal_m: float) -> Array:
        """Return the point (2,) at offsets along and normal to the wall, from the start."""
        return np.asarray(self.start + along_m * self.along + normal_m * self.normal)

    def slab(self, a: Array, b: Array, thick_m: float) -> Array:
        """Return a rectangle (4, 2) on the left of the line from ``a`` to ``b``."""
        step = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
        across = thick_m * np.array([-step[1], step[0]])
        return np.stack([a, b, b + across, a + across])


@dataclass
class Drawn:
    """Lines, slabs (4, 2), arcs (centre, radius, start, end) and sills of doors in one style."""

    lines: list[Array]
    slabs: list[Array]
    arcs: list[tuple[Array, float, float, float]]
    sills: list[Array]


def openings_of(storey: PlacedStorey, look: Look) -> list[DoorHole]:
    """Return all doors and entrances of a storey."""
    found: list[DoorHole] = []
    for door in storey.on_page.doors:
        if door.is_open:
            continue
        first, last = door.ends[door.hinge], door.ends[1 - door.hinge]
        along = (last - first) / max(door.width_m, 1e-9)
        side = 1.0 if door.swing == 0 else -1.0
        normal = side * np.array([-along[1], along[0]])
        found.append(DoorHole(first, along, normal, door.width_m, storey.drawn_wall_m))
    for a, b, _, far_a in facade(storey, look).entrances:
        width, depth = float(np.linalg.norm(b - a)), float(np.linalg.norm(far_a - a))
        normal = (far_a - a) / depth * (1.0 if int(1e3 * width) % 2 else -1.0)
        found.append(DoorHole((a + far_a) / 2.0, (b - a) / width, normal, width, depth))
    return found


def door_marks(
    storey: PlacedStorey, look: Look, style: InteriorStyle, rng: np.random.Generator
) -> list[Mark]:
    """Return the doors of a storey, each in one of the sheet's door styles."""
    drawn: dict[int, Drawn] = defaultdict(lambda: Drawn([], [], [], []))
    for opening in openings_of(storey, look):
        number = int(rng.integers(len(style.doors)))
        paint = style.doors[number]
        into = drawn[number]
        _DRAW[paint.kind](opening, paint, into)
        offsets = {0: (), 1: (0.0,), 2: (-0.5, 0.5)}[paint.sills]
        for offset in offsets:
            at = offset * opening.wall_m
            into.sills.append(np.stack([opening.at(0.0, at), opening.at(opening.width_m, at)]))
    marks: list[Mark] = []
    for number, into in sorted(drawn.items()):
        marks += _marks(into, style.doors[number], look)
    return marks


def _marks(drawn: Drawn, paint: DoorPaint, look: Look) -> list[Mark]:
    pen = look.pen(paint.pen_mm, paint.colour)
    thin = look.pen(min(paint.pen_mm, 0.18), paint.colour)
    swept = look.pen(0.13, paint.colour, _DASHES_MM) if paint.has_dashes else thin
    marks = lines_of(Role.DOOR, drawn.sills, look.pen(0.13))
    marks += lines_of(Role.DOOR, drawn.lines, pen)
    if drawn.slabs and paint.is_filled:
        marks.append(Area(Role.DOOR, tuple(drawn.slabs), pen.colour))
    marks += lines_of(Role.DOOR, drawn.slabs, thin, is_closed=True)
    return marks + _arc_marks(drawn, swept)


def _arc_marks(drawn: Drawn, pen: Pen) -> list[Mark]:
    if not drawn.arcs:
        return []
    centre = np.stack([arc[0] for arc in drawn.arcs])
    radius = np.array([arc[1] for arc in drawn.arcs])
    span = np.array([arc[2:] for arc in drawn.arcs])
    return [Arcs(Role.DOOR, centre, radius, span, pen)]


def _hinges(o: DoorHole) -> list[tuple[Array, Array, float]]:
    """Return the hinge, the closed direction and the length of each leaf."""
    if o.width_m <= DOUBLE_LEAF_M:
        return [(o.start, o.along, o.width_m)]
    return [
        (o.start, o.along, o.width_m / 2.0),
        (o.at(o.width_m, 0.0), -o.along, o.width_m / 2.0),
    ]


def _swing(
    o: DoorHole, paint: DoorPaint, into: Drawn, normal: Array, has_leaf: bool, has_arc: bool
) -> None:
    for hinge, along, length in _hinges(o):
        foot = hinge + normal * o.wall_m / 2.0
        tip = np.cos(paint.angle_rad) * along + np.sin(paint.angle_rad) * normal
        if has_leaf and paint.slab_m > 0.0:
            into.slabs.append(o.slab(foot, foot + length * tip, paint.slab_m))
        elif has_leaf:
            into.lines.append(np.stack([foot, foot + length * tip]))
        if has_arc:
            is_left = along[0] * normal[1] > along[1] * normal[0]
            shut = float(np.arctan2(along[1], along[0]))
            sweep = (shut, shut + paint.angle_rad) if is_left else (shut - paint.angle_rad, shut)
            into.arcs.append((foot, length, *sweep))


def _gap(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    del o, paint, into


def _leaf(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    _swing(o, paint, into, o.normal, has_leaf=True, has_arc=False)


def _arc(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    _swing(o, paint, into, o.normal, has_leaf=True, has_arc=True)


def _arc_only(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    _swing(o, paint, into, o.normal, has_leaf=False, has_arc=True)


def _both_ways(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    for normal in (o.normal, -o.normal):
        _swing(o, paint, into, normal, has_leaf=normal is o.normal, has_arc=True)


def _sliding(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    """Add two overlapping sliding panels inside the opening."""
    thick = max(paint.slab_m, 0.05)
    half = (0.5 + _PANEL_OVERLAP / 2.0) * o.width_m
    into.slabs.append(o.slab(o.at(0.0, 0.0), o.at(half, 0.0), thick))
    into.slabs.append(o.slab(o.at(o.width_m - half, -thick), o.at(o.width_m, -thick), thick))


def _pocket(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    """Add one partly open panel that slides along the wall's face, sometimes as thick as it."""
    thick = o.wall_m if paint.is_filled and paint.slab_m > 0.0 else max(paint.slab_m, 0.05)
    face = o.wall_m / 2.0 + thick
    start = -np.cos(paint.angle_rad) * o.width_m
    into.slabs.append(o.slab(o.at(start, face), o.at(start + o.width_m, face), thick))


def _folding(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    """Add a zigzag line across part of the opening."""
    reach = o.width_m * (0.3 + 0.6 * abs(np.cos(paint.angle_rad)))
    fold = 0.5 * o.width_m / _FOLDS
    at = np.linspace(0.0, reach, _FOLDS + 1)
    into.lines.append(np.stack([o.at(u, fold * (i % 2)) for i, u in enumerate(at.tolist())]))


def _closed(o: DoorHole, paint: DoorPaint, into: Drawn) -> None:
    if paint.slab_m > 0.0:
        thick = max(_CLOSED_LEAF * o.wall_m, 0.03)
        into.slabs.append(o.slab(o.at(0.0, -thick), o.at(o.width_m, -thick), thick))
    else:
        into.lines.append(np.stack([o.at(0.0, 0.0), o.at(o.width_m, 0.0)]))


_DRAW: dict[str, Callable[[DoorHole, DoorPaint, Drawn], None]] = {
    'gap': _gap,
    'leaf': _leaf,
    'arc': _arc,
    'arc only': _arc_only,
    'both ways': _both_ways,
    'sliding': _sliding,
    'pocket': _pocket,
    'folding': _folding,
    'closed': _closed,
}
