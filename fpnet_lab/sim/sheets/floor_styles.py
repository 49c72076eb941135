# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floor patterns of a varied sheet: fills, tiles, hatches and dots, by room or department."""

from __future__ import annotations

import numpy as np
import shapely

from fpnet_lab.sim.sheets.artwork import Area, Array, Colour, Lines, Mark, Pen, Role, lines_of
from fpnet_lab.sim.sheets.facade import Facade
from fpnet_lab.sim.sheets.hatching import hatched, pattern, turned
from fpnet_lab.sim.sheets.interior_style import FloorPaint, InteriorStyle, hue_colour
from fpnet_lab.sim.sheets.looks import FAINT_PEN_MM, FINEST_PX, Look
from fpnet_lab.sim.sheets.storeys import PlacedStorey, facade

# Chosen, not measured:
_FINEST_PITCH_PX = 6.0
_MOST_CELLS = 2500  # maximum number of pattern cells per room; larger rooms have larger tiles
_BANDS = 12  # number of bands of a gradient
_BRICK = 2.5  # ratio of length to height
_SEPARATED = (0.5, 0.85)  # brightness of fills that light separator lines contrast with


def floor_marks(
    storey: PlacedStorey, look: Look, style: InteriorStyle, rng: np.random.Generator
) -> list[Mark]:
    """Return the marks of the floors."""
    marks: list[Mark] = []
    if style.separator is not None:
        marks += _separated(storey, facade(storey, look), rng)
    middles = np.array([room.mean(axis=0) for room in storey.rooms])
    for paint in style.floors:
        if style.separator is not None and paint.kind in {'solid', 'gradient'}:
            continue
        centre = middles[int(rng.integers(len(middles)))]
        near = np.argsort(np.linalg.norm(middles - centre, axis=1))
        count = int(np.ceil(paint.share * len(near)))
        chosen = near[:count] if rng.random() < 0.5 else rng.permutation(len(near))[:count]
        for index in chosen.tolist():
            colour = paint.colours[index % len(paint.colours)]
            for ring in _inset(storey.rooms[index], paint.inset_m):
                marks += _floor(ring, paint, colour, look)
    return marks


def _separated(storey: PlacedStorey, openings: Facade, rng: np.random.Generator) -> list[Mark]:
    """Fill all rooms and doorways darkly enough to show light lines between them."""
    count = int(rng.integers(1, 6))
    depth = float(rng.uniform(0.2, 0.9))
    colours = [hue_colour(rng, depth, float(rng.uniform(*_SEPARATED))) for _ in range(count)]
    middles = np.array([room.mean(axis=0) for room in storey.rooms])
    seeds = middles[rng.integers(len(middles), size=count)]
    owner = np.argmin(np.linalg.norm(middles[:, None] - seeds, axis=2), axis=1).tolist()
    marks: list[Mark] = [
        Area(Role.FILL, (room,), colours[number])
        for room, number in zip(storey.rooms, owner, strict=True)
    ]
    for door, ring in zip(storey.on_page.doors, storey.openings, strict=True):
        marks.append(Area(Role.FILL, (ring,), colours[owner[door.rooms[0]]]))
    return marks + [Area(Role.FILL, (ring,), colours[0]) for ring in openings.entrances]


def _inset(room: Array, inset_m: float) -> list[Array]:
    if inset_m <= 0.0:
        return [room]
    parts = shapely.get_parts(shapely.buffer(shapely.Polygon(room), -inset_m, join_style='mitre'))
    return [shapely.get_coordinates(p.exterior)[:-1] for p in parts.tolist() if not p.is_empty]


def _floor(ring: Array, paint: FloorPaint, colour: Colour, look: Look) -> list[Mark]:
    if paint.kind == 'solid':
        return [Area(Role.FILL, (ring,), colour)]
    edge = ring[1] - ring[0]
    angle = float(np.arctan2(edge[1], edge[0]))
    if paint.kind == 'gradient':  # rotated bands would have jagged ends at the walls
        return _gradient(ring, angle, colour)
    angle += paint.angle_rad
    area = float(shapely.area(shapely.Polygon(ring)))
    pitch = max(paint.pitch_m, _FINEST_PITCH_PX * look.resolution_m, np.sqrt(area / _MOST_CELLS))
    pen = Pen(paint.pen, look.pen(FAINT_PEN_MM).width_m)
    marks: list[Mark] = []
    if len(paint.colours) > 2:  # some patterns have a coloured background
        marks.append(Area(Role.FILL, (ring,), colour))
    return marks + lines_of(Role.FILL, list(_strokes(ring, paint.kind, angle, pitch)), pen)


def _strokes(ring: Array, kind: str, angle: float, pitch: float) -> Array:
    """Return the strokes (K, 2, 2) [m] of a pattern."""
    if kind == 'hatch':
        return hatched([ring], angle, pitch)
    if kind == 'squares':
        both = hatched([ring], angle, pitch), hatched([ring], angle + np.pi / 2.0, pitch)
        return np.concatenate(both)
    if kind == 'bricks':
        joint = np.array([[(0.0, 0.0), (0.0, pitch)]])
        joints = pattern(ring, angle, joint, np.array([_BRICK * pitch, pitch]), 0.5)
        return np.concatenate([hatched([ring], angle, pitch), joints])
    if kind == 'herringbone':
        zigzag = pitch * np.array([[(0.0, 0.0), (1.0, 1.0)], [(1.0, 1.0), (2.0, 0.0)]])
        return pattern(ring, angle, zigzag, np.array([2.0 * pitch, 0.7 * pitch]), 0.0)
    dot = 0.12 * pitch * np.array([[(0.0, 0.0), (1.0, 0.0)]])
    return pattern(ring, angle, dot, np.array([pitch, pitch]), 0.5)


def _gradient(ring: Array, angle: float, colour: Colour) -> list[Mark]:
    """Return adjacent thick strokes, each slightly paler than the previous one."""
    R = turned(angle)
    across = ring @ R[1]
    width = float(np.ptp(across)) / _BANDS
    strokes = hatched([ring], angle, width)
    if not len(strokes):
        return [Area(Role.FILL, (ring,), colour)]
    band = np.round((strokes[:, 0] @ R[1] - across.min()) / width).astype(int)
    marks: list[Mark] = [Area(Role.FILL, (ring,), colour)]
    for number in np.unique(band).tolist():
        share = 0.6 * min(number, _BANDS) / _BANDS
        r, g, b = (c + share * (1.0 - c) for c in colour)
        pen = Pen((r, g, b), width * (1.0 + FINEST_PX / 100.0))
        marks.append(Lines(Role.FILL, tuple(strokes[band == number]), pen))
    return marks
