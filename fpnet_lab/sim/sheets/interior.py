# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Marks of a storey of a varied sheet: floors, walls, doors, room contents, texts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely

from fpnet_lab.sim.sheets import symbols_built, symbols_room, symbols_storey
from fpnet_lab.sim.sheets.artwork import Mark
from fpnet_lab.sim.sheets.details import stair_rooms
from fpnet_lab.sim.sheets.door_styles import door_marks
from fpnet_lab.sim.sheets.floor_styles import floor_marks
from fpnet_lab.sim.sheets.interior_style import InteriorStyle
from fpnet_lab.sim.sheets.lettering_inside import dimension_marks_inside, tag_marks
from fpnet_lab.sim.sheets.looks import Look, Trait
from fpnet_lab.sim.sheets.room_frame import Brush, RoomFrame, room_frame
from fpnet_lab.sim.sheets.storeys import PlacedStorey
from fpnet_lab.sim.sheets.wall_styles import wall_marks

Draw = Callable[[RoomFrame, Brush], list[Mark]]

# Chosen, not measured: symbols with the room's minimum shorter side [m] and range of area [m2].
_ROOMY: dict[str, tuple[Draw, float, float, float]] = {
    'desks': (symbols_room.desks, 1.8, 6.0, 200.0),
    'wall to wall': (symbols_room.wall_to_wall, 1.2, 2.0, 60.0),
    'cubicles': (symbols_room.cubicles, 4.0, 25.0, 900.0),
    'seats': (symbols_room.seats, 3.5, 20.0, 400.0),
    'racks': (symbols_room.racks, 2.5, 10.0, 900.0),
    'beds': (symbols_room.beds, 2.2, 6.0, 60.0),
    'bath': (symbols_room.bath, 1.2, 1.8, 20.0),
    'kitchen': (symbols_room.kitchen, 1.6, 4.0, 40.0),
    'cars': (symbols_room.cars, 4.5, 15.0, 900.0),
    'pots': (symbols_room.pots, 2.0, 6.0, 900.0),
    'machines': (symbols_room.machines, 1.5, 4.0, 300.0),
    'table': (symbols_room.table, 2.5, 9.0, 120.0),
    'straight stairs': (symbols_built.straight_stairs, 1.1, 4.0, 30.0),
    'turning stairs': (symbols_built.turning_stairs, 2.0, 7.0, 60.0),
    'spiral stairs': (symbols_built.spiral_stairs, 1.8, 3.5, 60.0),
    'ramp': (symbols_built.ramp, 1.3, 6.0, 80.0),
    'escalator': (symbols_built.escalator, 1.8, 18.0, 900.0),
    'lift': (symbols_built.lift, 1.3, 1.7, 8.0),
    'void': (symbols_built.void, 1.2, 2.0, 60.0),
    'shaft': (symbols_built.shaft, 0.3, 0.3, 6.0),
}
_OVERHEAD: dict[str, Draw] = {
    'ceiling': symbols_built.ceiling,
    'beams': symbols_built.beams,
    'sprinklers': symbols_built.sprinklers,
}


def interior_marks(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return marks of floors, walls, windows, doors and symbols, the lowest first."""
    style = look.interior
    if style is None:
        return []
    marks = floor_marks(storey, look, style, rng)
    marks += wall_marks(storey, look, style)
    marks += door_marks(storey, look, style, rng)
    taken = {number for _, number in stair_rooms(storey)} if Trait.STAIRS in look.traits else set()
    has_furniture = 'furniture' in style.storey_symbols or Trait.FURNITURE in look.traits
    marks += _room_symbols(storey, look, style, rng, taken)
    if has_furniture:
        brush = _brush(look, style, rng)
        marks += symbols_storey.loose_furniture(storey, taken, style, brush)
    for name, draw in (
        ('columns', symbols_storey.columns),
        ('wires', symbols_storey.wires),
        ('routes', symbols_storey.routes),
        ('escape', symbols_storey.escape_signs),
        ('sections', symbols_storey.sections),
    ):
        if name in style.storey_symbols:
            marks += draw(storey, look, rng)
    return marks


def interior_letters(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return icons, labels and dimensions inside rooms."""
    style = look.interior
    if style is None:
        return []
    marks: list[Mark] = []
    if 'icons' in style.room_symbols:
        for room in storey.on_page.outlines[rng.random(len(storey.rooms)) < 0.5 * style.density]:
            at = shapely.get_coordinates(shapely.point_on_surface(room))[0]
            marks += symbols_storey.icons(at, look, rng)
    if style.tags is not None:
        marks += tag_marks(storey, look, style.tags, rng)
    return marks + dimension_marks_inside(storey, look, style, rng)


def _brush(look: Look, style: InteriorStyle, rng: np.random.Generator) -> Brush:
    return Brush(look, style.furniture[int(rng.integers(len(style.furniture)))], rng)


def _room_symbols(
    storey: PlacedStorey,
    look: Look,
    style: InteriorStyle,
    rng: np.random.Generator,
    taken: set[int],
) -> list[Mark]:
    """Return one fitting symbol per room, and overhead marks; add used rooms to ``taken``."""
    marks: list[Mark] = []
    overhead = [_OVERHEAD[name] for name in style.room_symbols if name in _OVERHEAD]
    for number, room in enumerate(storey.rooms):
        chances = rng.random(2)
        frame = room_frame(room) if number not in taken and chances.min() < style.density else None
        if frame is None:
            continue
        area = frame.length * frame.width
        fitting = [
            entry[0]
            for name in style.room_symbols
            if (entry := _ROOMY.get(name)) is not None
            and frame.width > entry[1]
            and entry[2] < area < entry[3]
        ]
        brush = _brush(look, style, rng)
        if fitting and chances[0] < style.density and storey.plan.rooms[number].kind == 'room':
            marks += fitting[int(rng.integers(len(fitting)))](frame, brush)
            taken.add(number)
        if overhead and chances[1] < style.density:
            marks += overhead[int(rng.integers(len(overhead)))](frame, brush)
    return marks
