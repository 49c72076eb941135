# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random irregularities of rooms: closets, exchanged corners, shafts, merged rooms."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon, affinity

from fpnet_lab.sim.plans.layout import (
    SNAP_M,
    Cell,
    is_too_small,
    polygons_of,
    shared_length,
    unite,
)
from fpnet_lab.sim.types import ring_of

CLOSET_SHARE = 0.08
CORNER_SHARE = 0.06
TRADE_SHARE = 0.07
SHAFT_SHARE = 0.06
JOIN_SHARE = 0.02
"""
Shares of affected rooms. Fitted by hand to the development split (docs/simulator.md).
"""

SHAFT_SIDE_M = (0.5, 1.4)
CORNER_SIDE_M = (1.7, 2.7)
"""Side lengths of a toilet or a closet in the corner of a room. Chosen."""
MIN_DIVISIBLE_M2 = 11.0
MAX_CLOSET_ASPECT = 2.2
"""Largest aspect ratio of a piece of a divided room. Chosen."""

LARGEST_JOINED_M2 = 120.0  # chosen


def roughen(rng: np.random.Generator, cells: list[Cell]) -> list[Cell]:
    """Return the cells with a few random changes to single rooms and pairs of neighbours."""
    cells = _divide_some(rng, cells)
    for share, change in ((TRADE_SHARE, _trade_corner), (JOIN_SHARE, _join)):
        rooms = [i for i, cell in enumerate(cells) if cell.kind == 'room']
        for i in rng.permutation(rooms)[: rng.binomial(len(rooms), share)].tolist():
            j = _neighbour(rng, cells, i)
            changed = change(rng, cells[i].polygon, cells[j].polygon) if j is not None else None
            if changed is not None and j is not None:
                cells[i] = replace(cells[i], polygon=changed[0])
                cells[j] = replace(cells[j], polygon=changed[1])
        cells = [cell for cell in cells if not cell.polygon.is_empty]
    return [_add_shaft(rng, cell) if rng.random() < SHAFT_SHARE else cell for cell in cells]


def _divide_some(rng: np.random.Generator, cells: list[Cell]) -> list[Cell]:
    """Divide some rooms by a straight wall, or by a toilet or a closet in a corner."""
    divided = []
    for cell in cells:
        is_candidate = cell.kind == 'room' and cell.polygon.area > MIN_DIVISIBLE_M2
        draw = rng.random() if is_candidate else 1.0
        parts: list[Polygon] = []
        if draw < CLOSET_SHARE:
            parts = _halves(cell.polygon, float(rng.uniform(0.25, 0.5)), bool(rng.random() < 0.5))
        elif draw < CLOSET_SHARE + CORNER_SHARE:
            parts = _corner_cut(rng, cell.polygon, rng.uniform(*CORNER_SIDE_M, 2))
        if len(parts) == 2 and all(_is_sensible(part) for part in parts):
            divided += [replace(cell, polygon=part) for part in parts]
        else:
            divided.append(cell)
    return divided


def _corner_cut(
    rng: np.random.Generator, polygon: Polygon, sides: NDArray[np.float64]
) -> list[Polygon]:
    """Cut a box of ``sides`` [m] out of one corner and return the rest and the cut-out parts."""
    corners = ring_of(polygon)
    (x, y), (a, b) = corners[int(rng.integers(len(corners)))], sides
    box = affinity.rotate(
        shapely.box(x - a, y - b, x + a, y + b), _principal_angle(polygon), use_radians=True
    )
    rest, cut = polygons_of(polygon.difference(box)), polygons_of(polygon.intersection(box))
    return [*rest, *cut] if not any(part.interiors for part in rest) else []


def _is_sensible(polygon: Polygon) -> bool:
    """Return whether a piece of a divided room is neither tiny nor a narrow strip."""
    if is_too_small(polygon):
        return False
    corners = shapely.get_coordinates(polygon.minimum_rotated_rectangle)
    sides = np.hypot(*(corners[1:3] - corners[:2]).T)
    return bool(sides.max() < MAX_CLOSET_ASPECT * sides.min())


def _halves(polygon: Polygon, fraction: float, is_across: bool) -> list[Polygon]:
    """Cut a polygon perpendicular to its longer (or shorter) side."""
    angle = _principal_angle(polygon)
    local = affinity.rotate(polygon, -angle, origin=(0.0, 0.0), use_radians=True)
    x0, y0, x1, y1 = local.bounds
    if is_across == (x1 - x0 > y1 - y0):
        cut = x0 + fraction * (x1 - x0)
        boxes = shapely.box(x0, y0, cut, y1), shapely.box(cut, y0, x1, y1)
    else:
        cut = y0 + fraction * (y1 - y0)
        boxes = shapely.box(x0, y0, x1, cut), shapely.box(x0, cut, x1, y1)
    parts = [part for box in boxes for part in polygons_of(local.intersection(box))]
    return [affinity.rotate(p, angle, origin=(0.0, 0.0), use_radians=True) for p in parts]


def _principal_angle(polygon: Polygon) -> float:
    corners = shapely.get_coordinates(polygon.minimum_rotated_rectangle)
    side = corners[1] - corners[0]
    return math.atan2(side[1], side[0])


def _neighbour(rng: np.random.Generator, cells: list[Cell], i: int) -> int | None:
    """Sample a room of the same group that shares over 2 m of wall with room ``i``, or None."""
    found = [
        j
        for j, other in enumerate(cells)
        if j != i
        and other.kind == 'room'
        and other.group == cells[i].group
        and other.polygon.distance(cells[i].polygon) < SNAP_M
        and shared_length(cells[i].polygon, other.polygon) > 2.0
    ]
    return int(rng.choice(found)) if found else None


def _trade_corner(
    rng: np.random.Generator, taker: Polygon, giver: Polygon
) -> tuple[Polygon, Polygon] | None:
    """Transfer a corner of one room to its neighbour, so that both become L-shaped."""
    shared = giver.boundary.intersection(taker.buffer(2.0 * SNAP_M, join_style='mitre'))
    x, y = shapely.get_coordinates(shared)[0 if rng.random() < 0.5 else -1]
    sides = rng.uniform(2.2, 4.5, 2)
    corner = affinity.rotate(
        shapely.box(x - sides[0], y - sides[1], x + sides[0], y + sides[1]),
        _principal_angle(giver),
        use_radians=True,
    )
    rest = polygons_of(giver.difference(corner))
    moved = polygons_of(giver.intersection(corner))
    if len(rest) != 1 or len(moved) != 1 or is_too_small(rest[0]):
        return None
    united = unite(taker, moved[0])
    return (united, rest[0]) if united is not None else None


def _join(rng: np.random.Generator, a: Polygon, b: Polygon) -> tuple[Polygon, Polygon] | None:
    """Merge two rooms; the second polygon returned is empty."""
    united = unite(a, b)
    if united is None or united.area > LARGEST_JOINED_M2:
        return None
    return united, Polygon()


def _add_shaft(rng: np.random.Generator, cell: Cell) -> Cell:
    """Cut a duct or a column out of one corner of a cell."""
    parts = _corner_cut(rng, cell.polygon, rng.uniform(*SHAFT_SIDE_M, 2))
    if len(parts) != 2 or is_too_small(parts[0]):
        return cell
    return replace(cell, polygon=parts[0])
