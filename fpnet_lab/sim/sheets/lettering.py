# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Texts on a storey: room labels, dimensions with true lengths, column axes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from fpnet_lab.sim.drawn.symbols import room_labels
from fpnet_lab.sim.sheets.artwork import Array, Dimension, Letters, Mark, Role, circles, lines_of
from fpnet_lab.sim.sheets.details import stair_rooms
from fpnet_lab.sim.sheets.looks import Look, Trait
from fpnet_lab.sim.sheets.storeys import PlacedStorey
from fpnet_lab.sim.types import PlanRoom

LETTER_ASPECT = 0.85
"""Mean width of a letter relative to the height of a capital. Chosen."""

# Chosen, not measured:
_LINE_PITCH = 1.7  # line spacing relative to the height of a capital
_LINES_SHOWN = ((0,), (1,), (2,), (0, 1), (0, 2), (0, 1, 2), (1, 2))
_TIGHT = 0.65  # minimum scale of letters to fit into a room
_DIMENSION_PEN_MM = 0.13
_DIMENSION_MM, _ROW_MM, _TICK_MM = 2.0, 9.0, 2.0
_EDGE_M = 1.2  # maximum distance to a side of the building of the rooms dimensioned there
_SHORTEST_DIMENSION_M = 0.8
_AXIS_MM, _AXIS_EVERY_M = 4.0, 6.0
_AXIS_DASHES_MM = (8.0, 2.0, 1.0, 2.0)

Number = Callable[[float], str]


def room_letters(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return room numbers, names or areas, where they fit."""
    shown = _LINES_SHOWN[int(rng.integers(len(_LINES_SHOWN)))]
    marks: list[Mark] = []
    labels = room_labels(storey.on_page, rng, int(rng.integers(5)))
    has_stairs = (
        {number for _, number in stair_rooms(storey)} if Trait.STAIRS in look.traits else ()
    )
    for number, (room, label) in enumerate(zip(storey.on_page.rooms, labels, strict=True)):
        lines = [label.text.split('\n')[i] for i in shown]
        longest = max(len(line) for line in lines)
        across, along = (2.0 * _half_chord_m(room, label.xy, axis) for axis in (0, 1))
        height = min(
            look.letter_m,
            0.9 * across / (longest * LETTER_ASPECT),
            0.9 * along / (len(lines) * _LINE_PITCH),
        )
        if height < _TIGHT * look.letter_m or number in has_stairs:
            continue
        top = label.xy[1] + height * _LINE_PITCH * (len(lines) - 1) / 2.0
        for row, line in enumerate(lines):
            xy = (label.xy[0], top - row * _LINE_PITCH * height)
            marks.append(Letters(Role.TEXT, line, xy, height, look.letters, look.font))
    return marks


def _half_chord_m(room: PlanRoom, xy: tuple[float, float], axis: int) -> float:
    """Return the distance along x (0) or y (1) from a point to the nearer wall [m]."""
    edges = np.stack([room.polygon, np.roll(room.polygon, -1, axis=0)], axis=1)
    along, across = edges[..., axis], edges[..., 1 - axis]
    crosses = (across[:, 0] > xy[1 - axis]) != (across[:, 1] > xy[1 - axis])
    start, step = across[crosses, 0], np.diff(across[crosses], axis=1)[:, 0]
    share = (xy[1 - axis] - start) / step
    hit = along[crosses, 0] + share * np.diff(along[crosses], axis=1)[:, 0]
    reach = np.abs(hit - xy[axis])
    return float(reach.min(initial=np.inf))


def draw_number_format(rng: np.random.Generator) -> Number:
    """Sample a notation of lengths: metres with point or comma, millimetres or centimetres."""
    formats: tuple[Number, ...] = (
        lambda metres: f'{metres:.2f}',
        lambda metres: f'{metres:.2f}'.replace('.', ','),
        lambda metres: f'{1e3 * metres:.0f}',
        lambda metres: f'{1e2 * metres:.0f}',
    )
    return formats[int(rng.integers(len(formats)))]


def dimension_marks(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return dimension chains below and left of a building, each with its total."""
    number = draw_number_format(rng)
    outer = look.outer_m
    low, high = storey.on_page.extent + np.array([[-outer], [outer]])
    marks: list[Mark] = []
    for axis in (0, 1):
        total = np.array([low[axis], high[axis]])
        chain = _stations(storey, axis, low[1 - axis])
        for row, stations in enumerate((np.unique(np.concatenate([chain, total])), total)):
            at = low[1 - axis] - look.mm(_ROW_MM) * (row + 1)
            marks += _dimension_row(stations, at, axis, look, number)
    return marks


def dimension_space_m(look: Look) -> float:
    """Return the space for dimensions beside a building [m]."""
    return look.outer_m + look.mm(3.0 * _ROW_MM)


def _stations(storey: PlacedStorey, axis: int, side: float) -> Array:
    """Return the start and end coordinates of rooms along the lower or left side [m]."""
    bounds = np.array([(r.min(axis=0), r.max(axis=0)) for r in storey.rooms])
    near = bounds[:, 0, 1 - axis] < side + _EDGE_M
    stations = np.sort(np.round(bounds[near][:, :, axis], 3).ravel())
    kept: list[float] = []
    for station in stations.tolist():
        if not kept or station - kept[-1] > _SHORTEST_DIMENSION_M:
            kept.append(station)
    return np.array(kept)


def _dimension_row(
    stations: Array, at: float, axis: int, look: Look, number: Number
) -> list[Mark]:
    """Return one row of dimensions along an axis (0: x) below or left of the building."""
    height = max(look.mm(_DIMENSION_MM), 0.8 * look.letter_m)
    tick, pen = look.mm(_TICK_MM), look.pen(_DIMENSION_PEN_MM)
    marks: list[Mark] = []
    for a, b in pairwise(stations.tolist()):
        text = number(b - a) if len(number(b - a)) * LETTER_ASPECT * height < b - a else ''
        start, end = ((a, at), (b, at)) if axis == 0 else ((at, a), (at, b))
        feet = (0.0, 2.0 * tick) if axis == 0 else (2.0 * tick, 0.0)
        marks.append(Dimension(start, end, feet, text, height, tick, pen, look.letters, look.font))
    return marks


def axis_marks(storey: PlacedStorey, look: Look) -> list[Mark]:
    """Return dash-dotted axes across a building, each with a labelled bubble."""
    (x0, y0), (x1, y1) = storey.on_page.extent
    reach, radius = look.mm(14.0), look.mm(_AXIS_MM)
    pen = look.pen(0.13, dashes_mm=_AXIS_DASHES_MM)
    xs, ys = (np.arange(a, b + 0.1, _AXIS_EVERY_M) for a, b in ((x0, x1), (y0, y1)))
    lines = [np.array([(x, y0 - 0.3), (x, y1 + reach)]) for x in xs]
    lines += [np.array([(x0 - 0.3, y), (x1 + reach, y)]) for y in ys]
    centres = np.array(
        [(x, y1 + reach + radius) for x in xs] + [(x1 + reach + radius, y) for y in ys]
    )
    names = [str(i + 1) for i in range(len(xs))] + [chr(65 + i % 26) for i in range(len(ys))]
    marks = lines_of(Role.AXIS, lines, pen)
    marks.append(circles(Role.AXIS, centres, radius, look.pen(0.18)))
    height = 0.9 * radius
    return marks + [
        Letters(Role.AXIS, name, (float(x), float(y)), height, look.letters, look.font)
        for name, (x, y) in zip(names, centres, strict=True)
    ]


def axis_space_m(look: Look) -> float:
    """Return the space for axes above and right of a building [m]."""
    return look.mm(14.0 + 3.0 * _AXIS_MM)
