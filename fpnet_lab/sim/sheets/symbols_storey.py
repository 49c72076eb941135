# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Symbols across a storey of a varied sheet: columns, escape signs, routes, sections, wires."""

from __future__ import annotations

import numpy as np
import shapely

from fpnet_lab.sim.buildings.furnishing import furnish
from fpnet_lab.sim.buildings.furniture import DRAWN
from fpnet_lab.sim.sheets.artwork import (
    Area,
    Array,
    Colour,
    Letters,
    Lines,
    Mark,
    Role,
    lines_of,
)
from fpnet_lab.sim.sheets.interior_style import InteriorStyle, hue_colour
from fpnet_lab.sim.sheets.looks import THIN_PEN_MM, Look
from fpnet_lab.sim.sheets.room_frame import Brush, disc
from fpnet_lab.sim.sheets.storeys import PlacedStorey, arrow_head
from fpnet_lab.sim.types import polygons_from_rings

# Chosen, not measured:
_GREENS: tuple[Colour, ...] = ((0.0, 0.55, 0.25), (0.1, 0.7, 0.2), (0.85, 0.1, 0.1))
_COLUMN_ROOM_M2 = 25.0
_SECTION_DASHES_MM = (8.0, 2.0, 1.0, 2.0)
_MOST_FURNISHED = 25  # maximum number of furnished rooms, because furnishing is slow
_WHITE: Colour = (1.0, 1.0, 1.0)


def columns(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return round or square columns, filled or outlined, in large rooms or along walls."""
    polygons = polygons_from_rings(storey.rooms)
    side = float(rng.uniform(0.2, 0.8))
    pitch = rng.uniform(3.0, 8.0, 2)
    rim = side / 2.0 if rng.random() < 0.3 else 1.2
    large = shapely.buffer(polygons[shapely.area(polygons) > _COLUMN_ROOM_M2], -rim)
    (x0, y0), (x1, y1) = storey.on_page.extent
    xs, ys = np.meshgrid(np.arange(x0, x1, pitch[0]), np.arange(y0, y1, pitch[1]))
    at = np.stack([xs.ravel(), ys.ravel()], axis=1)
    kept = at[shapely.contains_xy(shapely.union_all(large), *at.T)]
    if not len(kept):
        return []
    square = side / 2.0 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    is_round, is_filled = rng.random(2) < (0.5, 0.6)
    colour = look.ink if rng.random() < 0.8 else hue_colour(rng, 0.8, 0.6)
    rings = [disc(xy, side / 2.0) if is_round else xy + square for xy in kept]
    marks: list[Mark] = [Area(Role.WALL, (r,), colour if is_filled else _WHITE) for r in rings]
    if not is_filled:
        marks += lines_of(Role.WALL, rings, look.pen(0.25, look.ink), is_closed=True)
        if rng.random() < 0.3:
            crosses = [np.stack([xy - s, xy + s]) for xy in kept for s in square[:2]]
            marks += lines_of(Role.WALL_PATTERN, crosses, look.pen(THIN_PEN_MM))
    return marks


def escape_signs(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return escape arrows near doors, some in coloured boxes."""
    colour = _GREENS[int(rng.integers(len(_GREENS)))]
    size = look.mm(float(rng.uniform(2.0, 6.0)))
    marks: list[Mark] = []
    for door in storey.on_page.doors[: int(rng.integers(4, 30))]:
        if rng.random() < 0.5:
            continue
        along = door.normal * (1.0 if rng.random() < 0.5 else -1.0)
        across = np.array([-along[1], along[0]])
        at = door.ends.mean(axis=0) - (size + storey.drawn_wall_m) * along
        shaft = np.stack([at - 0.5 * size * along, at + 0.5 * size * along])
        ink = colour
        if rng.random() < 0.5:
            step = 0.8 * size * np.array([-1.0, 1.0])
            ring = at + np.array([step[[0, 1, 1, 0]], step[[0, 0, 1, 1]] * 0.6]).T @ np.stack(
                [along, across]
            )
            marks.append(Area(Role.FURNITURE, (ring,), colour))
            ink = _WHITE
        strokes = (shaft, *arrow_head(shaft[0], shaft[1], 0.45 * size))
        marks.append(Lines(Role.FURNITURE, strokes, look.pen(0.6, ink)))
    return marks


def routes(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return escape routes with arrows, from the centres of rooms through doors."""
    plan = storey.on_page
    middles = [room.mean(axis=0) for room in storey.rooms]
    doors = [door for door in plan.doors if not door.is_open]
    if not doors:
        return []
    colour = _GREENS[int(rng.integers(len(_GREENS)))]
    dashes = (3.0, 1.5) if rng.random() < 0.5 else ()
    lines: list[Array] = []
    for number in rng.permutation(len(doors))[: int(rng.integers(3, 20))].tolist():
        first, last = doors[number].rooms
        middle = doors[number].ends.mean(axis=0)
        lines.append(np.stack([middles[first], middle, middles[last]]))
    heads = [stroke for line in lines for stroke in arrow_head(line[1], line[2], look.mm(2.5))]
    pen = look.pen(float(rng.uniform(0.3, 1.0)), colour, dashes)
    return lines_of(Role.FURNITURE, lines, pen) + lines_of(
        Role.FURNITURE, heads, look.pen(0.5, colour)
    )


def sections(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return dash-dotted section lines through the building with a letter at both ends."""
    low, high = storey.on_page.extent + np.array([[-1.0], [1.0]]) * look.mm(6.0)
    marks: list[Mark] = []
    colour = hue_colour(rng, 0.9, 0.7) if rng.random() < 0.3 else look.line
    pen = look.pen(float(rng.uniform(0.15, 0.6)), colour, _SECTION_DASHES_MM)
    for letter in 'ABC'[: int(rng.integers(1, 4))]:
        axis = int(rng.integers(2))
        across = float(rng.uniform(low[1 - axis], high[1 - axis]))
        ends = np.array([(low[axis], across), (high[axis], across)])
        ends = ends if axis == 0 else ends[:, ::-1]
        marks.append(Lines(Role.AXIS, (ends,), pen))
        for x, y in ends.tolist():
            height = 1.3 * look.letter_m
            text = letter if rng.random() < 0.5 else f"{letter}'"
            at = (x, y + 1.2 * height)
            marks.append(Letters(Role.TEXT, text, at, height, look.letters, look.font))
    return marks


def wires(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return wires and pipes: rectangular polylines across rooms and walls."""
    low, high = storey.on_page.extent
    marks: list[Mark] = []
    for _ in range(int(rng.integers(1, 4))):
        corners = [rng.uniform(low, high)]
        for _step in range(int(rng.integers(3, 9))):
            corner = corners[-1].copy()
            axis = int(rng.integers(2))
            corner[axis] = float(rng.uniform(low[axis], high[axis]))
            corners.append(corner)
        colour = hue_colour(rng, 0.9, 0.8) if rng.random() < 0.6 else look.line
        dashes = (2.0, 1.0) if rng.random() < 0.4 else ()
        pen = look.pen(float(rng.uniform(0.1, 0.5)), colour, dashes)
        marks.append(Lines(Role.FURNITURE, (np.stack(corners),), pen))
    return marks


def loose_furniture(
    storey: PlacedStorey, taken: set[int], style: InteriorStyle, brush: Brush
) -> list[Mark]:
    """Return standard furniture in free rooms, filled if the brush has a fill colour."""
    plan = storey.on_page
    free = [n for n, room in enumerate(plan.rooms) if room.kind == 'room' and n not in taken]
    count = min(_MOST_FURNISHED, round(style.density * len(free)))
    chosen = set(brush.rng.permutation(free)[:count].tolist()) if free else set()
    empty = set(range(len(plan.rooms))) - chosen
    marks: list[Mark] = []
    rings: list[Array] = []
    for piece in furnish(plan, brush.rng, stocks=DRAWN, empty=empty):
        rings += list(piece.rings)
        if piece.rounded:
            rings += [disc(xy, radius) for *xy, radius in piece.discs[:, :3].tolist()]
    return marks + brush.boxes(rings)


def icons(at: Array, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return a small coloured disc or square, optionally with a letter."""
    size = look.mm(float(rng.uniform(1.5, 3.5)))
    colour = hue_colour(rng, 0.9, 0.85)
    square = size * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    ring = disc(at, size) if rng.random() < 0.5 else at + square
    marks: list[Mark] = [Area(Role.FURNITURE, (ring,), colour)]
    if rng.random() < 0.7:
        letter = 'iPHWFE+?!x12'[int(rng.integers(12))]
        x, y = at.tolist()
        marks.append(Letters(Role.TEXT, letter, (x, y), size, _WHITE, look.font, is_bold=True))
    return marks
