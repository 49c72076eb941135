# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Building kinds that are used by varied sheets only: :func:`generate_special_plan`.

Halls, towers, churches and terraced houses have few rooms, one dominant room or no corridor.
Robots rarely operate there, but users supply their plans.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
import math

import numpy as np
import shapely
from shapely import Polygon, affinity, box

from fpnet_lab.sim.plans.finish import finish
from fpnet_lab.sim.plans.gates import with_gates
from fpnet_lab.sim.plans.generate import draw_style
from fpnet_lab.sim.plans.layout import Cell, Kind, Style, absorb_slivers, cut_holes, polygons_of
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom

Rng = np.random.Generator
Box = tuple[float, float, float, float]
Layout = Callable[[Rng, Style], list[Cell]]

MAX_ROOMS = 60
MAX_AREA_M2 = 4000.0
"""Largest storey that fits on a single sheet. Chosen."""

_ATTEMPTS = 40  # numerical


def generate_special_plan(
    rng: Rng, max_rooms: int = MAX_ROOMS, max_area_m2: float = MAX_AREA_M2
) -> BuildingPlan:
    """Return a storey of a random kind of :data:`SPECIAL`, mostly with outside doors."""
    names = list(SPECIAL)
    plan = None
    for _ in range(_ATTEMPTS):
        name = names[int(rng.integers(len(names)))]
        plan = special_plan(rng, name)
        if len(plan.rooms) <= max_rooms and plan.floor_area_m2 <= max_area_m2:
            return plan
    return special_plan(rng, 'one_room') if plan is None else plan


def special_plan(rng: Rng, name: str) -> BuildingPlan:
    """Return a storey of the kind ``name``, a key of :data:`SPECIAL`."""
    style = draw_style(rng)
    if name == 'terraced':
        return _terraced(rng, style)
    plan = finish(rng, SPECIAL[name](rng, style), style, name)
    return with_gates(rng, plan, int(rng.integers(1, 6)) if rng.random() < 0.8 else 0)


def _log(rng: Rng, low: float, high: float) -> float:
    """Sample a length from a log-uniform distribution."""
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def _row(rng: Rng, bounds: Box, side_m: float, jitter: float = 0.25) -> list[Box]:
    """Split a box across its longer axis into pieces about ``side_m`` wide."""
    x0, y0, x1, y1 = bounds
    is_wide = x1 - x0 > y1 - y0
    low, high = (x0, x1) if is_wide else (y0, y1)
    count = max(1, round((high - low) / side_m))
    cuts = np.linspace(low, high, count + 1)
    cuts[1:-1] += rng.uniform(-0.5, 0.5, count - 1) * jitter * (high - low) / count
    pairs = zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True)
    return [(a, y0, b, y1) if is_wide else (x0, a, x1, b) for a, b in pairs]


def _cells(boxes: list[Box], kind: Kind = 'room', group: int = -1) -> list[Cell]:
    return [Cell(box(*b), kind, group) for b in boxes]


def _divided(rng: Rng, bounds: Box, count: int) -> list[Box]:
    """Split a box into ``count`` boxes by repeatedly splitting the largest at random."""
    boxes = [bounds]
    while len(boxes) < count:
        boxes.sort(key=lambda b: (b[2] - b[0]) * (b[3] - b[1]))
        x0, y0, x1, y1 = boxes.pop()
        share = float(rng.uniform(0.32, 0.68))
        if x1 - x0 > (y1 - y0) * rng.uniform(0.8, 1.25):
            x = x0 + share * (x1 - x0)
            boxes += [(x0, y0, x, y1), (x, y0, x1, y1)]
        else:
            y = y0 + share * (y1 - y0)
            boxes += [(x0, y0, x1, y), (x0, y, x1, y1)]
    return boxes


def _frame(inner: Box, width: float) -> tuple[list[Box], Box]:
    """Return the four boxes that frame a box, and the outer box."""
    x0, y0, x1, y1 = inner
    a, b, c, d = x0 - width, y0 - width, x1 + width, y1 + width
    return [(a, b, c, y0), (a, y1, c, d), (a, y0, x0, y1), (x1, y0, c, y1)], (a, b, c, d)


def _with_hall(outline: Polygon, rooms: list[Cell], kind: Kind = 'hall') -> list[Cell]:
    """Return the rooms, and the rest of the outline as cells of ``kind``."""
    rest = shapely.difference(outline, shapely.union_all([room.polygon for room in rooms]))
    parts = [piece for part in polygons_of(rest) for piece in cut_holes(part)]
    return absorb_slivers([*rooms, *(Cell(part, kind) for part in parts if part.area > 4.0)])


def _hall(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a hall with a few offices in its corners."""
    width = _log(rng, 14.0, 55.0)
    depth = width * float(rng.uniform(0.4, 1.0))
    rooms: list[Cell] = []
    for corner in rng.permutation(4)[: int(rng.integers(0, 3))].tolist():
        wide = min(style.room_side_m * float(rng.uniform(0.8, 2.6)), 0.45 * width)
        deep = min(style.room_side_m * float(rng.uniform(0.6, 1.2)), 0.4 * depth)
        x = 0.0 if corner % 2 == 0 else width - wide
        y = 0.0 if corner < 2 else depth - deep
        rooms += _cells(_row(rng, (x, y, x + wide, y + deep), style.room_side_m))
    return _with_hall(box(0.0, 0.0, width, depth), rooms)


def _warehouse(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a very large hall with rooms along one side and optionally a second hall."""
    width, depth = _log(rng, 30.0, 85.0), _log(rng, 18.0, 45.0)
    deep = style.room_side_m * float(rng.uniform(0.8, 1.5))
    reach = width * float(rng.uniform(0.3, 1.0))
    rooms = _cells(_row(rng, (0.0, 0.0, reach, deep), style.room_side_m * 1.2))
    if rng.random() < 0.4:
        x = width * float(rng.uniform(0.4, 0.7))
        rooms.append(Cell(box(x, deep, width, depth), 'room'))
    return _with_hall(box(0.0, 0.0, width, depth), rooms)


def _ringed(rng: Rng, core: list[Cell], inner: Box, style: Style, width_m: float) -> list[Cell]:
    """Lay out a corridor around a core, and rooms on some of its sides."""
    corridor, outer = _frame(inner, width_m)
    deep = style.room_side_m * float(rng.uniform(0.7, 1.4))
    sides, _ = _frame(outer, deep)
    cells = core + _cells(corridor, 'corridor')
    kept = [s for s in sides if rng.random() < 0.85] or sides[:1]
    side_m = style.room_side_m * float(rng.uniform(0.8, 1.6))
    for side in kept:
        cells += _cells(_row(rng, side, side_m))
    return absorb_slivers(cells)


def _gym(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a large room inside a ring of corridor and rooms."""
    inner = (0.0, 0.0, _log(rng, 14.0, 34.0), _log(rng, 10.0, 22.0))
    return _ringed(rng, [Cell(box(*inner), 'room')], inner, style, float(rng.uniform(1.6, 3.2)))


def _tower(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a core of shafts and closets, surrounded by a corridor and offices."""
    inner = (0.0, 0.0, _log(rng, 7.0, 16.0), _log(rng, 5.0, 11.0))
    core = _cells(_divided(rng, inner, int(rng.integers(3, 8))))
    if rng.random() < 0.4:  # open offices
        deep = float(rng.uniform(5.0, 10.0))
        _, outer = _frame(inner, deep)
        return _with_hall(box(*outer), core)
    return _ringed(rng, core, inner, style, float(rng.uniform(1.6, 2.6)))


def _courtyard(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a corridor with rooms around a void."""
    inner = (0.0, 0.0, _log(rng, 8.0, 26.0), _log(rng, 7.0, 18.0))
    return _ringed(rng, [], inner, style, float(rng.uniform(1.8, 3.0)))


def _atrium(rng: Rng, style: Style) -> list[Cell]:
    """Lay out rooms directly around a hall."""
    inner = (0.0, 0.0, _log(rng, 9.0, 24.0), _log(rng, 8.0, 18.0))
    sides, _ = _frame(inner, style.room_side_m * float(rng.uniform(0.8, 1.5)))
    cells = [Cell(box(*inner), 'hall')]
    for side in sides:
        if rng.random() < 0.85:
            cells += _cells(_row(rng, side, style.room_side_m * float(rng.uniform(0.9, 1.8))))
    return absorb_slivers(cells)


def _hotel(rng: Rng, style: Style) -> list[Cell]:
    """Lay out identical rooms with bathrooms along a corridor."""
    wide, deep = float(rng.uniform(3.2, 4.6)), float(rng.uniform(5.5, 7.5))
    aisle, bath = float(rng.uniform(1.6, 2.4)), float(rng.uniform(1.8, 2.4))
    count = int(rng.integers(4, 14))
    cells = [Cell(box(0.0, 0.0, count * wide, aisle), 'corridor')]
    is_double = rng.random() < 0.8
    group = 0
    for i in range(count):
        for sign in (1.0, -1.0)[: 2 if is_double else 1]:
            x = i * wide if i % 2 == 0 else (i + 1) * wide - bath
            y0, y1 = (aisle, aisle + deep) if sign > 0 else (-deep, 0.0)
            low, high = (y0, y0 + 2.2) if sign > 0 else (y1 - 2.2, y1)
            wet = box(x, low, x + bath, high)
            whole = box(i * wide, y0, (i + 1) * wide, y1)
            cells += [Cell(wet, 'room', group), Cell(whole.difference(wet), 'room', group)]
            group += 1
    return cells


def _hospital(rng: Rng, style: Style) -> list[Cell]:
    """Lay out one corridor, or two around a core, with many small rooms."""
    length, aisle = _log(rng, 25.0, 60.0), float(rng.uniform(2.0, 2.8))
    deep, core = float(rng.uniform(3.5, 5.5)), float(rng.uniform(3.5, 6.0))
    side = float(rng.uniform(3.0, 4.2))
    y = [0.0, deep, deep + aisle, deep + aisle + core, deep + 2 * aisle + core]
    top = y[-1] + deep
    rooms = [(0.0, 0.0, length, y[1]), (0.0, y[4], length, top)]
    cells = _cells([(0.0, y[1], length, y[2])], 'corridor')
    if rng.random() < 0.6:
        rooms.append((aisle, y[2], length - aisle, y[3]))
        ends = [(0.0, y[2], aisle, y[3]), (length - aisle, y[2], length, y[3])]
        cells += _cells([(0.0, y[3], length, y[4]), *ends], 'corridor')
    else:
        rooms[1] = (0.0, y[2], length, y[3])
    for band in rooms:
        cells += _cells(_row(rng, band, side * float(rng.uniform(0.9, 1.6)), 0.1))
    return absorb_slivers(cells)


def _mall(rng: Rng, style: Style) -> list[Cell]:
    """Lay out shops on both sides of a wide hall, optionally with an anchor shop at its end."""
    length, way = _log(rng, 30.0, 80.0), float(rng.uniform(5.0, 12.0))
    deep = [float(rng.uniform(8.0, 18.0)) for _ in range(2)]
    cells = _cells([(0.0, 0.0, length, way)], 'hall')
    cells += _cells(_row(rng, (0.0, -deep[0], length, 0.0), float(rng.uniform(6, 12)), 0.6))
    cells += _cells(_row(rng, (0.0, way, length, way + deep[1]), float(rng.uniform(6, 12)), 0.6))
    if rng.random() < 0.6:
        end = float(rng.uniform(10.0, 20.0))
        cells += _cells([(length, -deep[0], length + end, way + deep[1])])
    return cells


def _one_room(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a single room of random size and outline."""
    width = _log(rng, 4.0, 45.0)
    depth = width * float(rng.uniform(0.45, 1.0))
    shape = box(0.0, 0.0, width, depth)
    pick = rng.random()
    if pick < 0.25:
        x, y = rng.uniform(0.4, 0.7, 2).tolist()
        shape = shape.difference(box(x * width, y * depth, width, depth))
    elif pick < 0.4:
        sides = int(rng.choice([5, 6, 8, 12]))
        angle = np.arange(sides) * 2.0 * np.pi / sides
        shape = Polygon(np.stack([np.cos(angle), np.sin(angle)], axis=1) * width / 2.0)
    elif pick < 0.5:
        skew = float(rng.uniform(-0.3, 0.3)) * width
        shape = Polygon([(0, 0), (width, 0), (width + skew, depth), (0.5 * skew, depth)])
    return [Cell(shape, 'room')]


def _tiny_flat(rng: Rng, style: Style) -> list[Cell]:
    """Lay out two to five rooms."""
    count = int(rng.integers(2, 6))
    area = count * float(rng.uniform(8.0, 18.0))
    width = math.sqrt(area) * float(rng.uniform(0.8, 1.5))
    boxes = _divided(rng, (0.0, 0.0, width, area / width), count)
    cells = [Cell(box(*b), 'room', 0) for b in boxes]
    if rng.random() < 0.3 and len(cells) > 2:
        cells.pop(int(rng.integers(len(cells))))
    return absorb_slivers(cells)


def _church(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a nave with an apse, and optionally a transept, a tower and a vestry."""
    width = float(rng.uniform(9.0, 18.0))
    length = width * float(rng.uniform(1.8, 3.2))
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, int(rng.choice([4, 6, 12])))
    apse = np.stack([np.cos(angle), np.sin(angle)], axis=1) * width * 0.5 * rng.uniform(0.6, 1.0)
    shifted = affinity.translate(Polygon([*apse, (-1.0, 0.0)]), length, 0.0)
    nave = shapely.union(box(0.0, -width / 2.0, length, width / 2.0), shifted)
    if rng.random() < 0.5:
        x, arm = length * float(rng.uniform(0.55, 0.75)), width * float(rng.uniform(0.2, 0.5))
        nave = shapely.union(nave, box(x, -width / 2 - arm, x + 0.4 * width, width / 2 + arm))
    cells = [Cell(polygons_of(nave)[0], 'hall')]
    side = float(rng.uniform(3.5, 6.0))
    if rng.random() < 0.7:  # a tower
        cells.append(Cell(box(-side, -side / 2.0, 0.0, side / 2.0), 'room'))
    if rng.random() < 0.7:  # a vestry
        y = width / 2.0
        reach = min(0.5 * length, side * 2.0)
        cells += _cells(_row(rng, (0.5, y, reach, y + side), side))
    return cells


def _theatre(rng: Rng, style: Style) -> list[Cell]:
    """Lay out a fan-shaped auditorium with a stage, a foyer and optional side rooms."""
    front, back = float(rng.uniform(10.0, 18.0)), float(rng.uniform(16.0, 34.0))
    deep, stage = float(rng.uniform(14.0, 26.0)), float(rng.uniform(7.0, 12.0))
    foyer = float(rng.uniform(5.0, 10.0))
    half, wide = back / 2.0, front / 2.0
    fan = Polygon([(-half, 0.0), (half, 0.0), (wide, deep), (-wide, deep)])
    cells = [Cell(fan, 'hall'), Cell(box(-half, -foyer, half, 0.0), 'corridor')]
    cells.append(Cell(box(-wide, deep, wide, deep + stage), 'room'))
    for sign in (1.0, -1.0):
        if rng.random() < 0.7:
            low, high = sorted((sign * wide, sign * (wide + 5.0)))
            cells += _cells(_row(rng, (low, deep, high, deep + stage), style.room_side_m))
    if rng.random() < 0.6:
        low = -foyer - style.room_side_m
        cells += _cells(_row(rng, (-half, low, half, -foyer), style.room_side_m))
    return absorb_slivers(cells)


def _school(rng: Rng, style: Style) -> list[Cell]:
    """Lay out classrooms along a corridor, optionally with a gym at its end."""
    aisle, deep = float(rng.uniform(2.4, 4.0)), float(rng.uniform(6.5, 8.5))
    count = int(rng.integers(3, 9))
    length = count * float(rng.uniform(7.5, 9.5))
    cells = _cells([(0.0, 0.0, length, aisle)], 'corridor')
    cells += _cells(_row(rng, (0.0, aisle, length, aisle + deep), length / count, 0.05))
    if rng.random() < 0.5:
        cells += _cells(_row(rng, (0.0, -0.7 * deep, length, 0.0), 5.0, 0.8))
    if rng.random() < 0.6:
        low = -float(rng.uniform(0.0, 8.0))
        wide, high = float(rng.uniform(13.0, 24.0)), low + float(rng.uniform(12.0, 20.0))
        cells.append(Cell(box(length, low, length + wide, high), 'hall'))
    return absorb_slivers(cells)


def _terraced(rng: Rng, style: Style) -> BuildingPlan:
    """Lay out dwellings in a row without connecting doors, each with its own doors."""
    wide, deep = float(rng.uniform(4.8, 7.5)), float(rng.uniform(8.0, 12.0))
    is_equal = rng.random() < 0.5
    rooms: list[PlanRoom] = []
    doors: list[PlanDoor] = []
    seed = int(rng.integers(1 << 31))
    for i in range(int(rng.integers(2, 9))):
        own = np.random.default_rng([seed, 0 if is_equal else i])
        shift = float(own.uniform(-1.5, 1.5)) if not is_equal else 0.0
        boxes = _divided(own, (i * wide, shift, (i + 1) * wide, shift + deep), 3)
        boxes += _divided(own, boxes.pop(), int(own.integers(1, 4)))
        cells = absorb_slivers([Cell(box(*b), 'room', 0) for b in boxes])
        plan = finish(own, cells, style, 'terraced')
        first = len(rooms)
        rooms += list(plan.rooms)
        doors += [replace(d, rooms=(d.rooms[0] + first, d.rooms[1] + first)) for d in plan.doors]
    whole = BuildingPlan(tuple(rooms), tuple(doors), style.wall_m, 'terraced')
    return with_gates(rng, whole, 2 * int(rng.integers(2, 9)))


def _open_office(rng: Rng, style: Style) -> list[Cell]:
    """Lay out free-standing blocks of rooms in one large space."""
    width, depth = _log(rng, 18.0, 50.0), _log(rng, 12.0, 30.0)
    rooms: list[Cell] = []
    for _ in range(int(rng.integers(1, 5))):
        w, d = (float(rng.uniform(0.15, 0.4)) * side for side in (width, depth))
        x, y = float(rng.uniform(2.5, width - w - 2.5)), float(rng.uniform(2.5, depth - d - 2.5))
        block = box(x, y, x + w, y + d)
        if all(block.distance(room.polygon) > 2.0 for room in rooms):
            rooms += _cells(_row(rng, (x, y, x + w, y + d), style.room_side_m))
    return _with_hall(box(0.0, 0.0, width, depth), rooms)


SPECIAL: dict[str, Layout] = {
    'hall': _hall,
    'warehouse': _warehouse,
    'gym': _gym,
    'tower': _tower,
    'courtyard': _courtyard,
    'atrium': _atrium,
    'hotel': _hotel,
    'hospital': _hospital,
    'mall': _mall,
    'one_room': _one_room,
    'tiny_flat': _tiny_flat,
    'church': _church,
    'theatre': _theatre,
    'school': _school,
    'open_office': _open_office,
    'terraced': lambda rng, style: [],
}
"""Layouts by name; :func:`special_plan` lays out terraced houses dwelling by dwelling."""
