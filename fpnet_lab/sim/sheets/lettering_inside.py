# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Texts inside the rooms of a varied sheet: labels, dimensions of rooms and doorways."""

from __future__ import annotations

import numpy as np
import shapely

from fpnet_lab.sim.sheets.artwork import Area, Array, Letters, Lines, Mark, Role, lines_of
from fpnet_lab.sim.sheets.door_styles import openings_of
from fpnet_lab.sim.sheets.hatching import chord
from fpnet_lab.sim.sheets.interior_style import InteriorStyle, TagStyle
from fpnet_lab.sim.sheets.lengths_written import area_text, length_text, size_text
from fpnet_lab.sim.sheets.lettering import LETTER_ASPECT
from fpnet_lab.sim.sheets.looks import MIN_LETTER_PX, THIN_PEN_MM, Look
from fpnet_lab.sim.sheets.room_frame import disc
from fpnet_lab.sim.sheets.storeys import PlacedStorey, arrow_head

_NAMES: dict[str, tuple[str, ...]] = {
    'latin': (
        'Office', 'LAB', 'Meeting', 'Store', 'Kitchen', 'WC', 'Bedroom', 'BATH', 'Living room',
        'Hall', 'Server', 'Lobby', 'Reception', 'Class room', 'Workshop', 'Plant', 'CL', 'Garage',
    ),
    'accents': (
        'Büro', 'Küche', 'Flur', 'Salle de réunion', 'Dégagement', 'Baño', 'Almacén', 'Ufficio',
        'Möten', 'Kök', 'Biuro', 'Łazienka', 'Kancelář', 'Előtér', 'Umkleide H', 'Gänge', 'Größe',
    ),
    'cyrillic': ('Кабинет', 'Коридор', 'Кухня', 'Склад', 'Санузел', 'Холл', 'Зал', 'Гостиная'),
    'greek': ('Γραφείο', 'Κουζίνα', 'Αίθουσα', 'Διάδρομος', 'Λουτρό', 'Αποθήκη', 'Υπνοδωμάτιο'),
}  # fmt: skip
# Chosen, not measured:
_PITCH = 1.7  # line spacing relative to the height of a capital
_TIGHT = 0.5  # minimum scale of letters to fit into a room
_SHORTEST_M = 0.6
_TICK_MM = 1.6
_TEXT_GAP = 0.9  # distance of a number above its line relative to the height of a capital


def tag_marks(
    storey: PlacedStorey, look: Look, style: TagStyle, rng: np.random.Generator
) -> list[Mark]:
    """Return the labels of rooms."""
    marks: list[Mark] = []
    font = look.font
    if style.script in {'cyrillic', 'greek'} and 'DejaVu' not in font:
        font = 'DejaVu Sans'
    polygons = storey.on_page.outlines
    places = shapely.get_coordinates(shapely.point_on_surface(polygons))
    areas, boxes = shapely.area(polygons), shapely.oriented_envelope(polygons)
    prefix = int(rng.integers(0, 6))
    for number, room in enumerate(storey.on_page.rooms):
        if rng.random() > style.share:
            continue
        sides = np.hypot(*np.diff(shapely.get_coordinates(boxes[number])[:3], axis=0).T)
        lines = _lines(number + 100 * prefix, float(areas[number]), sides, style, rng)
        marks += _tag(room.polygon, places[number], lines, look, style, font)
    return marks


def _lines(
    number: int, area: float, sides: Array, style: TagStyle, rng: np.random.Generator
) -> list[str]:
    names = _NAMES[style.script]
    name = names[int(rng.integers(len(names)))]
    written = {
        'number': f'{number:03d}' if style.unit % 2 else f'{number // 100}.{number % 100:02d}',
        'name': name.upper() if style.unit == 2 else name,
        'area': area_text(area, style.unit),
        'size': size_text(float(sides.max()), float(sides.min()), style.unit),
    }
    return [written[kind] for kind in style.lines]


def _tag(
    room: Array, place: Array, lines: list[str], look: Look, style: TagStyle, font: str
) -> list[Mark]:
    along = np.array([np.cos(style.angle_rad), np.sin(style.angle_rad)])
    up = np.array([-along[1], along[0]])
    reach = [chord(room, place, direction) for direction in (along, up)]
    if reach[0] is None or reach[1] is None:
        return []
    width, tall = (2.0 * min(float(np.linalg.norm(e - place)) for e in r) for r in reach if r)
    longest = max(len(line) for line in lines)
    wanted = style.scale * look.letter_m
    fits = min(0.9 * width / (longest * LETTER_ASPECT), 0.8 * tall / (len(lines) * _PITCH))
    height = float(min(wanted, fits))
    if height < _TIGHT * wanted or height < 0.8 * MIN_LETTER_PX * look.resolution_m:
        return []
    colour = style.colour or look.letters
    half = np.array([longest * LETTER_ASPECT, len(lines) * _PITCH]) * height / 2.0
    marks = _framed(place, half, height, np.stack([along, up]), look, style)
    for row, line in enumerate(lines):
        x, y = (place + ((len(lines) - 1) / 2.0 - row) * _PITCH * height * up).tolist()
        marks.append(Letters(Role.TEXT, line, (x, y), height, colour, font, style.angle_rad))
    return marks


def _framed(
    place: Array, half: Array, height: float, axes: Array, look: Look, style: TagStyle
) -> list[Mark]:
    pen = look.pen(THIN_PEN_MM, style.colour)
    if style.frame == 'box':
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (half + 0.2 * height)
    elif style.frame == 'ellipse':
        corners = disc(np.zeros(2), 1.3) * (half + 0.1 * height)
    elif style.frame == 'leader':
        start = place - (half[0] + 0.3 * height) * axes[0]
        end = start - height * (1.5 * axes[0] + 1.2 * axes[1])
        head = arrow_head(start, end, 0.6 * height)
        return lines_of(Role.TEXT, [np.stack([start, end]), *head], pen)
    else:
        return []
    ring = place + corners @ axes
    marks: list[Mark] = []
    if style.unit % 2:
        marks.append(Area(Role.TEXT, (ring,), (1.0, 1.0, 1.0)))
    return marks + lines_of(Role.TEXT, [ring], pen, is_closed=True)


def dimension(a: Array, b: Array, look: Look, style: InteriorStyle, is_split: bool) -> list[Mark]:
    """Return a dimension line between two points with end marks and its true length."""
    length = float(np.linalg.norm(b - a))
    if length < _SHORTEST_M:
        return []
    along = (b - a) / length
    if along[0] < -1e-6 or (abs(along[0]) <= 1e-6 and along[1] < 0.0):
        a, b, along = b, a, -along
    across = np.array([-along[1], along[0]])
    text, height = length_text(length, style.length_unit), 0.75 * look.letter_m
    wide = len(text) * LETTER_ASPECT * height
    pen, tick = look.pen(style.dimension_mm), look.mm(_TICK_MM)
    middle = (a + b) / 2.0
    has_text = style.has_lengths and wide < 0.8 * length
    lines = [np.stack([a, b])]
    if is_split and has_text:
        gap = (wide / 2.0 + 0.3 * height) * along
        lines = [np.stack([a, middle - gap]), np.stack([middle + gap, b])]
    marks: list[Mark] = []
    if style.arrow == 0:
        lines += arrow_head(a, b, tick) + arrow_head(b, a, tick)
    elif style.arrow == 1:
        slant = (along + across) * tick / 2.0
        lines += [np.stack([end - slant, end + slant]) for end in (a, b)]
    elif style.arrow == 2:
        marks.append(Area(Role.DIMENSION, (disc(a, 0.3 * tick), disc(b, 0.3 * tick)), pen.colour))
    else:
        lines += [np.stack([end - across * tick, end + across * tick]) for end in (a, b)]
    marks.append(Lines(Role.DIMENSION, tuple(lines), pen))
    if has_text:
        x, y = (middle if is_split else middle + _TEXT_GAP * height * across).tolist()
        angle = float(np.arctan2(along[1], along[0]))
        marks.append(Letters(Role.DIMENSION, text, (x, y), height, look.letters, look.font, angle))
    return marks


def dimension_marks_inside(
    storey: PlacedStorey, look: Look, style: InteriorStyle, rng: np.random.Generator
) -> list[Mark]:
    """Return dimensions across single rooms, across several rooms, and in doorways."""
    marks: list[Mark] = []
    is_split = bool(rng.random() < 0.4)
    if 'across room' in style.room_symbols:
        for room in storey.rooms:
            if rng.random() < style.density:
                marks += _across(room, look, style, rng, is_split)
    if 'in doorway' in style.room_symbols:
        for door in openings_of(storey, look):
            if rng.random() < style.density:
                shift = float(rng.choice([0.0, 0.0, 1.2])) * door.wall_m
                ends = door.at(0.0, shift), door.at(door.width_m, shift)
                marks += dimension(*ends, look, style, is_split)
    if 'chain' in style.room_symbols:
        for _ in range(int(rng.integers(1, 4))):
            marks += _chain(storey, look, style, rng)
    return marks


def _across(
    room: Array, look: Look, style: InteriorStyle, rng: np.random.Generator, is_split: bool
) -> list[Mark]:
    marks: list[Mark] = []
    edge = room[1] - room[0]
    along = edge / max(float(np.linalg.norm(edge)), 1e-9)
    low, high = room.min(axis=0), room.max(axis=0)
    for direction in (along, np.array([-along[1], along[0]]))[: int(rng.integers(1, 3))]:
        place = low + rng.uniform(0.15, 0.85, 2) * (high - low)
        ends = chord(room, place, direction)
        if ends is not None and shapely.contains_xy(shapely.Polygon(room), *place):
            marks += dimension(*ends, look, style, is_split)
    return marks


def _chain(
    storey: PlacedStorey,
    look: Look,
    style: InteriorStyle,
    rng: np.random.Generator,
) -> list[Mark]:
    """Return the dimensions of all rooms along one straight line through the storey."""
    middles = np.array([room.mean(axis=0) for room in storey.rooms])
    place = middles[int(rng.integers(len(middles)))] + rng.uniform(-0.5, 0.5, 2)
    edge = storey.rooms[0][1] - storey.rooms[0][0]
    angle = float(np.arctan2(edge[1], edge[0])) + float(rng.integers(2)) * np.pi / 2.0
    along = np.array([np.cos(angle), np.sin(angle)])
    line = shapely.LineString([place - 200.0 * along, place + 200.0 * along])
    marks: list[Mark] = []
    for room in storey.rooms:
        parts = shapely.get_parts(shapely.intersection(line, shapely.Polygon(room))).tolist()
        for part in parts:
            if part.geom_type == 'LineString' and not part.is_empty:
                ends = shapely.get_coordinates(part)
                marks += dimension(ends[0], ends[-1], look, style, is_split=False)
    return marks
