# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Door leaves, windows and glass fronts in the walls of a building."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_core.geometry import rotation
from fpnet_lab.sim.buildings.openings import opening_polygon
from fpnet_lab.sim.types import BuildingPlan, PlanDoor

Array = NDArray[np.float64]

# Chosen, not measured:
_LEAF_M = 0.04  # thickness of a door leaf
_LEAF_GAP_M = 0.02  # between a leaf's upper edge and the lintel
_WIDE_OPEN_RAD = (1.5, 2.0, 2.7, 1.2)  # opening angles of leaves, in the order of trial
_CORNER_M = 0.3  # minimum distance of windows from a room's corners and doors
_WINDOW_M = (0.9, 2.2)
_PLINTH_M = 0.1  # height of the wall below a glass front
_PIER_M = (0.4, 1.5)  # wall between two windows


class Pane(NamedTuple):
    """A wall opening ``hole`` with glass in its middle, and the heights of its edges [m]."""

    hole: Polygon
    glass: shapely.LineString
    bottom_m: float
    top_m: float


@dataclass(frozen=True)
class BuildingStyle:
    """
    Parameters of extrusion; lengths in metres, shares in [0, 1].

    ``ceiling_m`` and ``lintel_m`` are sampled uniformly from their ranges, once per building.
    ``frameless`` is the share of ceiling-high doors without a lintel, ``leaves`` that of doors
    with leaves, ``closed`` that of closed leaves (never on the robot's path).
    ``windows`` is the share of rooms with windows in their outer walls, ``glass_fronts`` that of
    rooms with a glass wall towards their corridor.
    """

    ceiling_m: tuple[float, float] = (2.7, 2.7)
    lintel_m: tuple[float, float] = (2.05, 2.05)
    frameless: float = 0.0
    leaves: float = 0.0
    closed: float = 0.0
    windows: float = 0.0
    glass_fronts: float = 0.0
    sill_m: tuple[float, float] = (0.7, 1.0)
    window_top_m: float = 2.1


BUILDING_STYLES: dict[str, BuildingStyle] = {
    'plain': BuildingStyle(),
    'lived_in': BuildingStyle(
        ceiling_m=(2.4, 3.2), lintel_m=(1.98, 2.15), leaves=0.7, closed=0.2, windows=0.8
    ),
    'frameless': BuildingStyle(frameless=1.0),
    'glass': BuildingStyle(leaves=0.7, windows=1.0, glass_fronts=0.4),
}
"""Extrusion styles by name. Chosen."""


def hang_leaves(
    plan: BuildingPlan,
    style: BuildingStyle,
    lintel_m: float,
    rng: np.random.Generator,
    keep_clear: shapely.Geometry | None,
) -> list[tuple[Polygon, float]]:
    """
    Return door leaves as base polygons and heights [m].

    A leaf hangs at its door's hinge and opens into the room of its swing, at the first angle that
    does not obstruct ``keep_clear``. It is omitted if every angle obstructs it.
    """
    clear = keep_clear if keep_clear is not None else Polygon()
    leaves: list[tuple[Polygon, float]] = []
    for door in plan.doors:
        if door.is_open or rng.random() >= style.leaves:
            continue
        is_shut = rng.random() < style.closed and not clear.intersects(opening_polygon(plan, door))
        for hinge, other in _hinges(door):
            leaf = (
                _leaf(hinge, other - hinge, 0.0)
                if is_shut
                else _open_leaf(plan, door, hinge, other, clear)
            )
            if leaf is not None:
                leaves.append((leaf, lintel_m - _LEAF_GAP_M))
    return leaves


def _hinges(door: PlanDoor) -> Iterator[tuple[Array, Array]]:
    """Yield each leaf's hinge (2,) and the position (2,) of its other edge when closed."""
    first, last = door.ends[door.hinge], door.ends[1 - door.hinge]
    if door.leaves == 1:
        yield first, last
    else:
        middle = (first + last) / 2.0
        yield first, middle
        yield last, middle


def _open_leaf(
    plan: BuildingPlan, door: PlanDoor, hinge: Array, other: Array, clear: shapely.Geometry
) -> Polygon | None:
    """Return the leaf at the first angle inside its room and outside of ``clear``, or None."""
    room = plan.outlines[door.rooms[door.swing]]
    normal = door.normal
    middle = door.ends.mean(axis=0)
    sides = [float(room.distance(shapely.Point(middle + sign * normal))) for sign in (1.0, -1.0)]
    inwards = normal if sides[0] <= sides[1] else -normal
    depth_m = float(room.distance(shapely.Point(middle)))
    along = other - hinge
    turn = np.sign(along[0] * inwards[1] - along[1] * inwards[0])
    for angle in _WIDE_OPEN_RAD:
        leaf = _leaf(hinge + depth_m * inwards, along, turn * angle)
        if room.buffer(_LEAF_M).covers(leaf) and not leaf.intersects(clear):
            return leaf
    return None


def _leaf(hinge: Array, along: Array, angle_rad: float) -> Polygon:
    """Return the base of a leaf with closed direction ``along``, rotated about its hinge."""
    tip = hinge + rotation(angle_rad) @ along
    return shapely.LineString([hinge, tip]).buffer(_LEAF_M / 2.0, cap_style='flat')


def cut_windows(
    plan: BuildingPlan, style: BuildingStyle, outer_wall_m: float, rng: np.random.Generator
) -> list[Pane]:
    """Sample windows in the outer walls of rooms, and glass fronts between rooms and corridors."""
    built = shapely.union_all(shapely.buffer(plan.outlines, outer_wall_m, join_style='mitre'))
    ways = shapely.union_all(
        [o for o, room in zip(plan.outlines, plan.rooms, strict=True) if room.kind != 'room']
    )
    doors = shapely.union_all([opening_polygon(plan, d).buffer(_CORNER_M) for d in plan.doors])
    panes: list[Pane] = []
    for room in plan.rooms:
        has_windows = rng.random() < style.windows
        has_front = room.kind == 'room' and rng.random() < style.glass_fronts
        sill_m = float(rng.uniform(*style.sill_m))
        for start, end, outwards in _walls_of(room.polygon):
            middle = (start + end) / 2.0
            outside = shapely.Point(middle + (outer_wall_m + _LEAF_M) * outwards)
            beyond = shapely.Point(middle + 2.0 * plan.wall_m * outwards)
            if has_windows and not built.intersects(outside):
                for a, b in _bays(start, end, rng):
                    panes.append(_pane(a, b, outwards * outer_wall_m, sill_m, style.window_top_m))
            elif has_front and ways.intersects(beyond):
                for a, b in _beside_doors(start, end, doors):
                    panes.append(
                        _pane(a, b, outwards * plan.wall_m, _PLINTH_M, style.window_top_m)
                    )
    return panes


def _beside_doors(
    start: Array, end: Array, doors: shapely.Geometry
) -> Iterator[tuple[Array, Array]]:
    """Yield the ends of sufficiently long wall sections clear of corners and doors."""
    inset = (end - start) / np.linalg.norm(end - start) * _CORNER_M
    line = shapely.LineString([start + inset, end - inset])
    for part in shapely.get_parts(shapely.difference(line, doors)).tolist():
        if part.length > _WINDOW_M[0]:
            a, b = shapely.get_coordinates(part)
            yield a, b


def _walls_of(ring: Array) -> Iterator[tuple[Array, Array, Array]]:
    """Yield start, end and outward normal of the long edges of an outline (V, 2)."""
    for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        if length > _WINDOW_M[0] + 2.0 * _CORNER_M:
            along = (end - start) / length
            yield start, end, np.array([along[1], -along[0]])


def _bays(start: Array, end: Array, rng: np.random.Generator) -> Iterator[tuple[Array, Array]]:
    """Yield the ends of one wall's windows, with equal widths and spacing."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    width, pier = rng.uniform(*_WINDOW_M), rng.uniform(*_PIER_M)
    count = int((length - 2.0 * _CORNER_M + pier) // (width + pier))
    first = (length - count * width - (count - 1) * pier) / 2.0
    for k in range(count):
        at = first + k * (width + pier)
        yield start + at * along, start + (at + width) * along


def _pane(start: Array, end: Array, depth: Array, bottom_m: float, top_m: float) -> Pane:
    over = 0.1 * depth  # margin, so that the hole fully penetrates the wall
    hole = Polygon([start - over, end - over, end + depth + over, start + depth + over])
    middle = shapely.LineString([start + depth / 2.0, end + depth / 2.0])
    return Pane(hole, middle, bottom_m, top_m)
