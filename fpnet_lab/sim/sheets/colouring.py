# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fills and patterns by room or department, and visitor arrows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely.geometry.polygon import orient

from fpnet_lab.sim.drawn.symbols import hatch
from fpnet_lab.sim.sheets.artwork import Area, Array, Colour, Lines, Mark, Pen, Role
from fpnet_lab.sim.sheets.looks import Look, Trait
from fpnet_lab.sim.sheets.storeys import PlacedStorey, areas_of, arrow_head
from fpnet_lab.sim.types import polygons_from_rings, ring_of

_DEPARTMENTS = (
    'Physics',
    'Chemistry',
    'Mathematics',
    'Informatics',
    'Administration',
    'Library',
    'Mechanics',
    'Biology',
    'Dean',
    'Seminar rooms',
    'Workshops',
)
# Chosen, not measured:
_STRONG = (
    (0.89, 0.10, 0.11),
    (0.95, 0.55, 0.05),
    (0.15, 0.35, 0.75),
)
_MOST_DEPARTMENTS = 7
_STRONG_ARROW_MM = (6.0, 14.0)


@dataclass(frozen=True, eq=False)
class Departments:
    """Departments with fill colours, owner of each room (R,) (-1: none), and hatching flags."""

    names: tuple[str, ...]
    colours: tuple[Colour, ...]
    of_room: NDArray[np.int64]
    is_hatched: NDArray[np.bool_]


def draw_departments(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> Departments:
    """Sample the departments' rooms, mostly in clusters; corridors usually have no department."""
    count = int(rng.integers(3, _MOST_DEPARTMENTS + 1))
    names = tuple(rng.permutation(_DEPARTMENTS)[:count].tolist())
    middles = np.array([room.mean(axis=0) for room in storey.rooms])
    seeds = middles[rng.integers(len(middles), size=count)]
    nearest = np.argmin(np.linalg.norm(middles[:, None] - seeds, axis=2), axis=1)
    stray = rng.random(len(middles)) < 0.1
    owner = np.where(stray, rng.integers(count, size=len(middles)), nearest)
    is_room = np.array([room.kind == 'room' for room in storey.plan.rooms])
    is_room |= rng.random() < 0.3  # some sheets also colour corridors
    hatched = rng.random(count) < (0.5 if Trait.PATTERNS in look.traits else 0.0)
    return Departments(names, _fills(rng, count), np.where(is_room, owner, -1), hatched)


def _fills(rng: np.random.Generator, count: int) -> tuple[Colour, ...]:
    """Sample distinguishable, mostly pale fill colours with evenly spaced hues."""
    hue = (rng.random() + np.arange(count) / count) % 1.0
    depth, value = float(rng.uniform(0.1, 0.55)), rng.uniform(0.82, 1.0, count)
    colours = []
    for h, v in zip(hue.tolist(), value.tolist(), strict=True):
        phase = (np.array([h, h + 1 / 3, h + 2 / 3]) * 2.0 * np.pi).tolist()
        r, g, b = (float(v * (1.0 - depth * (0.5 + 0.5 * np.cos(angle)))) for angle in phase)
        colours.append((r, g, b))
    return tuple(colours)


def fill_marks(
    storey: PlacedStorey, departments: Departments, look: Look, rng: np.random.Generator
) -> list[Mark]:
    """Return fills and patterns of all departments' rooms, and sometimes a fill of all floors."""
    marks: list[Mark] = []
    if rng.random() < 0.6:
        grey = float(rng.uniform(0.88, 1.0))
        ground = (grey, grey, float(rng.uniform(0.75, 1.0)) * grey)
        floors = shapely.union_all(polygons_from_rings([*storey.rooms, *storey.openings]))
        marks += areas_of(floors, Role.FILL, ground)
    angle = float(rng.choice([np.pi / 4.0, -np.pi / 4.0, 0.0]))
    spacing = max(look.mm(float(rng.uniform(1.5, 4.0))), 5.0 * look.resolution_m)
    for room, owner in zip(storey.rooms, departments.of_room.tolist(), strict=True):
        if owner < 0:
            continue
        colour = departments.colours[owner]
        if departments.is_hatched[owner]:
            strokes = hatch(shapely.Polygon(room), angle, spacing)
            pen = Pen(_darker(colour), max(spacing / 4.0, look.pen(0.2).width_m))
            marks.append(Lines(Role.FILL, tuple(strokes), pen))
        else:
            marks.append(Area(Role.FILL, (room,), colour))
    return marks


def _darker(colour: Colour) -> Colour:
    r, g, b = (0.75 * c for c in colour)
    return r, g, b


def arrow_marks(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return two thick arrows that point from outside at rooms of the building."""
    colour = _STRONG[int(rng.integers(len(_STRONG)))]
    middle = storey.on_page.extent.mean(axis=0)
    marks: list[Mark] = []
    for room in rng.permutation(len(storey.rooms))[:2].tolist():
        at = storey.rooms[room].mean(axis=0)
        length = look.mm(float(rng.uniform(*_STRONG_ARROW_MM)))
        outward = at - middle
        outward /= max(float(np.linalg.norm(outward)), 1e-6)
        marks.append(_fat_arrow(at + length * outward, at, length, colour))
    return marks


def _fat_arrow(start: Array, end: Array, length_m: float, colour: Colour) -> Mark:
    head = arrow_head(start, end, 0.5 * length_m)
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    across = 0.08 * length_m * np.array([-along[1], along[0]])
    neck = end - 0.5 * length_m * along
    ring = [end, head[1][1], neck + across, start + across, start - across, neck - across]
    ring.append(head[0][1])
    polygon = orient(shapely.Polygon(ring))
    return Area(Role.TEXT, (ring_of(polygon),), colour)
