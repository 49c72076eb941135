# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layout families that split rectangles: suites, flats, houses, open plans with cubicles."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_lab.sim.plans.families import bank_depth, corridor_width
from fpnet_lab.sim.plans.layout import Cell, Style, absorb_slivers, cut_holes, polygons_of
from fpnet_lab.sim.plans.skeleton import Arm, build_cells, split_length

MIN_SIDE_M = 1.9  # chosen


def bisect(
    rng: np.random.Generator, outline: tuple[float, float, float, float], style: Style
) -> list[Polygon]:
    """Split a rectangle (x0, y0, x1, y1) into rooms by recursively cutting the longer side."""
    x0, y0, x1, y1 = outline
    width, height = x1 - x0, y1 - y0
    target = style.room_side_m**2 * math.exp(2.0 * style.spread * rng.standard_normal())
    longer = max(width, height)
    if width * height < 1.6 * target or longer < 2.0 * MIN_SIDE_M:
        return [shapely.box(*outline)]
    cut = float(np.clip(rng.uniform(0.3, 0.7) * longer, MIN_SIDE_M, longer - MIN_SIDE_M))
    if width > height:
        halves = ((x0, y0, x0 + cut, y1), (x0 + cut, y0, x1, y1))
    else:
        halves = ((x0, y0, x1, y0 + cut), (x0, y0 + cut, x1, y1))
    return [room for half in halves for room in bisect(rng, half, style)]


def house(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Split a rectangle, sometimes without a corner room, into interconnected rooms."""
    size = rng.uniform(12.0, 26.0, 2)
    rooms = [Cell(room) for room in bisect(rng, (0.0, 0.0, size[0], size[1]), style)]
    if len(rooms) > 8 and rng.random() < 0.5:
        corner = min(rooms, key=lambda c: float(np.hypot(*c.polygon.centroid.coords[0])))
        rooms.remove(corner)
    hub = max(rooms, key=lambda c: float(c.polygon.area))
    rooms[rooms.index(hub)] = Cell(hub.polygon, 'hall')
    return rooms


def suites(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a corridor with deep banks of suites, each an anteroom with back rooms."""
    width, depth = corridor_width(rng), rng.uniform(7.5, 11.0)
    length = rng.uniform(26.0, 60.0)
    other = depth if rng.random() < 0.6 else bank_depth(rng, style)
    cells = [Cell(shapely.box(0.0, -width / 2.0, length, width / 2.0), 'corridor')]
    group = 0
    for side, bank in ((1.0, depth), (-1.0, other)):
        cuts = split_length(rng, length, min(bank, 6.0), style)
        for x0, x1 in itertools.pairwise(cuts):
            bay = _bay(x0, x1, side * width / 2.0, side * (width / 2.0 + bank))
            if bank > 7.0 and rng.random() < 0.8:
                cells += [Cell(room, 'room', group) for room in _front_and_back(rng, bay)]
                group += 1
            else:
                cells.append(Cell(shapely.box(*bay)))
    return absorb_slivers(cells)


def _bay(x0: float, x1: float, y0: float, y1: float) -> tuple[float, float, float, float]:
    return x0, min(y0, y1), x1, max(y0, y1)


def _front_and_back(
    rng: np.random.Generator, bay: tuple[float, float, float, float]
) -> list[Polygon]:
    """Split a bay parallel to the corridor; the back of a wide bay is split once more."""
    x0, y0, x1, y1 = bay
    front = rng.uniform(0.35, 0.6) * (y1 - y0)
    y = y0 + front if y0 > 0.0 else y1 - front
    rows = [(y0, y), (y, y1)] if y0 > 0.0 else [(y, y1), (y0, y)]
    rooms = [shapely.box(x0, rows[0][0], x1, rows[0][1])]
    back = rows[1]
    if x1 - x0 > 6.0:
        x = rng.uniform(0.4, 0.6) * (x1 - x0) + x0
        rooms += [shapely.box(x0, back[0], x, back[1]), shapely.box(x, back[0], x1, back[1])]
    else:
        rooms.append(shapely.box(x0, back[0], x1, back[1]))
    return rooms


def apartments(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a corridor with flats on both sides, each with several rooms around a hallway."""
    width, depth = rng.uniform(1.5, 2.2), rng.uniform(8.0, 11.5)
    count = int(rng.integers(2, 5))
    length = count * rng.uniform(8.5, 13.0)
    cells = [Cell(shapely.box(0.0, -width / 2.0, length, width / 2.0), 'corridor')]
    edges = np.linspace(0.0, length, count + 1)
    edges[1:-1] += rng.uniform(-1.0, 1.0, count - 1)
    layouts: list[list[Cell]] = []
    for side in (1.0, -1.0):
        for i in range(count):
            size = np.array([edges[i + 1] - edges[i], depth])
            flat = layouts[-1] if layouts and rng.random() < 0.3 else _flat(rng)
            layouts.append(flat)
            cells += _place_flat(flat, edges[i], size, side, width / 2.0, group=len(layouts))
    return absorb_slivers(cells)


def _flat(rng: np.random.Generator) -> list[Cell]:
    """Return a flat on the unit square: a hallway from the entrance at y = 0 and its rooms."""
    x, hall, deep = rng.uniform(0.35, 0.6), rng.uniform(0.12, 0.18), rng.uniform(0.55, 0.75)
    left = np.sort(rng.uniform(0.3, 0.7, int(rng.integers(1, 3)))) * deep
    right = np.sort(rng.uniform(0.3, 0.7, int(rng.integers(1, 3)))) * deep
    cells = [Cell(shapely.box(x, 0.0, x + hall, deep), 'corridor')]
    for x0, x1, cuts in ((0.0, x, left), (x + hall, 1.0, right)):
        stops = [0.0, *cuts.tolist(), deep]
        cells += [Cell(shapely.box(x0, a, x1, b)) for a, b in itertools.pairwise(stops)]
    split = rng.uniform(0.35, 0.65)
    return [
        *cells,
        Cell(shapely.box(0.0, deep, split, 1.0)),
        Cell(shapely.box(split, deep, 1.0, 1.0)),
    ]


def _place_flat(
    flat: list[Cell], x: float, size: NDArray[np.float64], side: float, y: float, group: int
) -> list[Cell]:
    """Scale a unit flat to ``size`` and place it on the corridor's upper or lower side."""
    placed = []
    for cell in flat:
        ring = shapely.get_coordinates(cell.polygon.exterior) * size
        outline = Polygon(np.stack([x + ring[:, 0], side * (y + ring[:, 1])], axis=1))
        placed.append(Cell(outline, cell.kind, group))
    return placed


def open_plan(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a large hall with cubicle islands and banks of rooms along one to three sides."""
    hall = np.array([rng.uniform(18.0, 34.0), rng.uniform(11.0, 18.0)])
    depth, half = bank_depth(rng, style), hall[1] / 2.0
    below = depth if rng.random() < 0.6 else 0.0
    arm = Arm(
        (0.0, 0.0),
        (float(hall[0]), 0.0),
        float(hall[1]),
        depth,
        below,
        kind='hall',
        cap_m=depth if rng.random() < 0.5 else 0.0,
    )
    cells = build_cells(rng, [arm], style)
    islands = _islands(rng, hall, half)
    floor = next(cell for cell in cells if cell.kind == 'hall')
    cells.remove(floor)
    rest = floor.polygon.difference(shapely.union_all(islands, grid_size=1e-3))
    for part in polygons_of(rest):
        cells += [Cell(piece, 'hall') for piece in cut_holes(part)]
    return cells + [Cell(island) for island in islands]


def _islands(rng: np.random.Generator, hall: NDArray[np.float64], half: float) -> list[Polygon]:
    """Return the cubicles: back-to-back pairs in rows, with aisles between the rows."""
    side, aisle = rng.uniform(2.4, 3.4), rng.uniform(1.6, 2.4)
    rows = max(1, int((hall[1] - aisle) // (2.0 * side + aisle)))
    gap = (hall[1] - rows * 2.0 * side) / (rows + 1)
    columns = max(1, int((hall[0] - 2.0 * aisle) // side))
    x0 = (hall[0] - columns * side) / 2.0
    aisle_column = columns // 2 if columns > 5 else -1
    islands = []
    for row in range(rows):
        y = -half + gap + row * (2.0 * side + gap)
        for column in range(columns):
            if column != aisle_column:
                x = x0 + column * side
                islands += [
                    shapely.box(x, y, x + side, y + side),
                    shapely.box(x, y + side, x + side, y + 2.0 * side),
                ]
    return islands
