# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Contents of rooms: stairs, lifts, columns, furniture, tiles, overhead lines."""

from __future__ import annotations

import numpy as np
import shapely

from fpnet_lab.sim.buildings.furnishing import furnish
from fpnet_lab.sim.buildings.furniture import DRAWN
from fpnet_lab.sim.drawn.symbols import hatch
from fpnet_lab.sim.sheets.artwork import (
    Area,
    Array,
    Colour,
    Lines,
    Mark,
    Pen,
    Role,
    circles,
    lines_of,
)
from fpnet_lab.sim.sheets.looks import FAINT_PEN_MM, THIN_PEN_MM, WALL_PEN_MM, Look, Trait
from fpnet_lab.sim.sheets.storeys import PlacedStorey, arrow_head, outlines_of
from fpnet_lab.sim.types import polygons_from_rings

# Chosen, not measured:
_TREAD_M = 0.28
_STAIR_AREA_M2, _LIFT_AREA_M2 = (7.0, 30.0), (1.5, 5.0)
_SQUARE = 0.95  # minimum share of its bounding rectangle that a stair room covers
_COLUMN_M, _COLUMN_EVERY_M = 0.4, 5.4
_EAVES_M = (0.5, 1.2)  # overhang of a roof beyond the walls
_BEAM_EVERY_M = (1.2, 3.0)
_OVERHEAD_DASHES_MM = (3.0, 1.5)
_TILE_M = (0.3, 0.6)
_FAINT = 0.6  # mixing ratio of white in a line's colour


def detail_marks(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return the marks inside the rooms of a storey, the lowest first."""
    marks: list[Mark] = []
    if Trait.TILES in look.traits:
        marks += _tiles(storey, look, rng)
    stairs = stair_rooms(storey) if Trait.STAIRS in look.traits else []
    for is_lift, number in stairs:
        room = storey.rooms[number]
        marks += _lift(room, look) if is_lift else _stairs(room, look, rng)
    if Trait.FURNITURE in look.traits and look.interior is None:
        marks += _furniture(storey, {number for _, number in stairs}, look, rng)
    if Trait.COLUMNS in look.traits:
        marks += _columns(storey, look)
    if Trait.OVERHEAD in look.traits:
        marks += _overhead(storey, look, rng)
    return marks


def _furniture(
    storey: PlacedStorey, taken: set[int], look: Look, rng: np.random.Generator
) -> list[Mark]:
    """Return furniture symbols in rooms that are neither corridors nor ``taken``."""
    plan, pen = storey.on_page, look.pen(THIN_PEN_MM)
    ways = {number for number, room in enumerate(plan.rooms) if room.kind != 'room'}
    marks: list[Mark] = []
    for piece in furnish(plan, rng, stocks=DRAWN, empty=taken | ways):
        marks += lines_of(Role.FURNITURE, list(piece.rings), pen, is_closed=True)
        if piece.rounded:
            marks.append(circles(Role.FURNITURE, piece.discs[:, :2], piece.discs[:, 2], pen))
    return marks


def _tiles(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return faint floor tiles in a few rooms."""
    side = max(float(rng.uniform(*_TILE_M)), 6.0 * look.resolution_m)
    pen = Pen(_fainter(look.line), look.pen(FAINT_PEN_MM).width_m)
    marks: list[Mark] = []
    for room in storey.rooms:
        if rng.random() < 0.2:
            edge = room[1] - room[0]
            angle = float(np.arctan2(edge[1], edge[0]))
            shape = shapely.Polygon(room)
            strokes = hatch(shape, angle, side) + hatch(shape, angle + np.pi / 2.0, side)
            marks += lines_of(Role.FILL, strokes, pen)
    return marks


def _fainter(colour: Colour) -> Colour:
    r, g, b = (value + _FAINT * (1.0 - value) for value in colour)
    return r, g, b


def _overhead(storey: PlacedStorey, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return dashed lines of the roof's edge and of beams above some rooms."""
    pen = look.pen(THIN_PEN_MM, dashes_mm=_OVERHEAD_DASHES_MM)
    eaves = look.outer_m + float(rng.uniform(*_EAVES_M))
    lines = [np.vstack([ring, ring[:1]]) for ring in outlines_of(storey.shell(eaves))]
    spacing = float(rng.uniform(*_BEAM_EVERY_M))
    for room in storey.rooms:
        if rng.random() < 0.15:
            edge = room[1] - room[0]
            lines += hatch(shapely.Polygon(room), float(np.arctan2(edge[1], edge[0])), spacing)
    return [Lines(Role.STAIRS, tuple(lines), pen)]


def stair_rooms(storey: PlacedStorey) -> list[tuple[bool, int]]:
    """Return (is lift, room index) of up to two stair rooms and up to two lifts."""
    polygons = polygons_from_rings(storey.rooms)
    areas = shapely.area(polygons)
    squareness = areas / np.maximum(shapely.area(shapely.oriented_envelope(polygons)), 1e-9)
    kinds = np.array([room.kind == 'room' for room in storey.plan.rooms])
    found: list[tuple[bool, int]] = []
    for is_lift, (low, high) in ((False, _STAIR_AREA_M2), (True, _LIFT_AREA_M2)):
        fits = np.flatnonzero(kinds & (areas > low) & (areas < high) & (squareness > _SQUARE))
        found += [(is_lift, int(i)) for i in fits[:: max(1, len(fits) - 1)][:2]]
    return found


def _frame_of(room: Array) -> tuple[Array, Array, Array, float, float]:
    """Return a rectangle's corner, unit vectors along and across, and both side lengths [m]."""
    ring = shapely.get_coordinates(shapely.oriented_envelope(shapely.Polygon(room)))[:4]
    sides = np.roll(ring, -1, axis=0) - ring
    lengths = np.hypot(*sides.T)
    first = int(np.argmax(lengths[:2]))
    along, across = sides[first] / lengths[first], -sides[first - 1] / lengths[first - 1]
    return ring[first], along, across, float(lengths[first]), float(lengths[first - 1])


def _stairs(room: Array, look: Look, rng: np.random.Generator) -> list[Mark]:
    """Return two parallel flights of stairs with treads, a centre line and an arrow."""
    corner, along, across, length, width = _frame_of(room)
    landing = min(1.4, 0.3 * length)
    at = np.arange(landing, length - landing, _TREAD_M)
    if not len(at):
        return []
    feet = corner + at[:, None] * along
    treads = np.stack([feet, feet + width * across], axis=1)
    pen = look.pen(THIN_PEN_MM)
    middle = corner + width / 2.0 * across
    well = np.stack([middle + at[0] * along, middle + at[-1] * along])
    walk = corner + width * (0.25 if rng.random() < 0.5 else 0.75) * across
    ends = np.stack([walk + at[0] * along, walk + at[-1] * along])
    marks = lines_of(Role.STAIRS, list(treads), pen)
    marks += lines_of(Role.STAIRS, [well], look.pen(WALL_PEN_MM))
    return marks + lines_of(Role.STAIRS, [ends, *arrow_head(ends[0], ends[1], look.mm(2.0))], pen)


def _lift(room: Array, look: Look) -> list[Mark]:
    corner, along, across, length, width = _frame_of(room)
    ring = corner + 0.1 * (along + across)
    along, across = (length - 0.2) * along, (width - 0.2) * across
    box = np.stack([ring, ring + along, ring + along + across, ring + across])
    pen = look.pen(THIN_PEN_MM)
    cross = [box[[0, 2]], box[[1, 3]]]
    return lines_of(Role.STAIRS, [box], pen, is_closed=True) + lines_of(Role.STAIRS, cross, pen)


def _columns(storey: PlacedStorey, look: Look) -> list[Mark]:
    """Return square columns on a grid, well inside large rooms only."""
    polygons = polygons_from_rings(storey.rooms)
    large = shapely.buffer(polygons[shapely.area(polygons) > 40.0], -1.5)
    (x0, y0), (x1, y1) = storey.on_page.extent
    at = np.stack(
        np.meshgrid(np.arange(x0, x1, _COLUMN_EVERY_M), np.arange(y0, y1, _COLUMN_EVERY_M)), axis=2
    ).reshape(-1, 2)
    kept = at[shapely.contains_xy(shapely.union_all(large), *at.T)]
    square = _COLUMN_M / 2.0 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return [Area(Role.WALL, (centre + square,), look.ink) for centre in kept]
