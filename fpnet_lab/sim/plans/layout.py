# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Cells: the tiling of a storey before walls are given a thickness.

A layout family splits the storey into cells that touch along shared lines. All later steps
(wall thickness, doors, reachability) are the same for every family, see
:mod:`fpnet_lab.sim.plans.finish`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

Kind = Literal['room', 'corridor', 'hall']
Warp = Callable[[NDArray[np.float64]], NDArray[np.float64]]

SNAP_M = 0.005
"""Numerical: gaps up to twice this value between touching cells are closed by a union."""

_BENT_STEP_M = 0.6  # numerical: point spacing along warped edges

MIN_CELL_AREA_M2 = 3.0
MIN_CELL_WIDTH_M = 1.5
"""Smaller or narrower cells are merged into a neighbour, as too small for a room. Chosen."""


@dataclass(frozen=True, eq=False)
class Cell:
    """
    One piece of the tiling, in metres.

    ``group`` is the number of the cell's suite or flat (-1: none). Rooms of a group are
    connected to each other first and share an entrance.
    """

    polygon: Polygon
    kind: Kind = 'room'
    group: int = -1

    @property
    def is_circulation(self) -> bool:
        """Whether the cell is a corridor or a hall, which give access to other rooms."""
        return self.kind != 'room'


@dataclass(frozen=True)
class Style:
    """
    Design parameters of one building.

    ``room_side_m`` is the side of a typical square room, ``spread`` the standard deviation of
    the logarithm of its aspect ratio. ``is_uniform`` repeats one room size and one door position.
    ``room_to_room`` is the probability of a door between neighbouring rooms, ``second_door`` that
    of a second door of a large room.
    """

    wall_m: float = 0.15
    room_side_m: float = 4.6
    spread: float = 0.35
    is_uniform: bool = False
    room_to_room: float = 0.04
    second_door: float = 0.2
    door_width_m: float | None = None


def polygons_of(geometry: shapely.Geometry) -> list[Polygon]:
    """Return the polygons of any geometry, without its points and lines."""
    return [g for g in shapely.get_parts(geometry).tolist() if isinstance(g, Polygon)]


def unite(a: Polygon, b: Polygon) -> Polygon | None:
    """Return the union of two touching cells, or None if it is not one polygon without holes."""
    grown = shapely.union(
        a.buffer(SNAP_M, join_style='mitre'), b.buffer(SNAP_M, join_style='mitre')
    )
    united = grown.buffer(-SNAP_M, join_style='mitre')
    return united if isinstance(united, Polygon) and not united.interiors else None


def shared_length(a: Polygon, b: Polygon) -> float:
    """Return the length of the line that two cells share [m]."""
    return float(a.boundary.intersection(b.buffer(2.0 * SNAP_M, join_style='mitre')).length)


def is_too_small(polygon: Polygon) -> bool:
    """Return whether a cell is smaller than the smallest plausible room."""
    return bool(
        polygon.area < MIN_CELL_AREA_M2 or polygon.buffer(-MIN_CELL_WIDTH_M / 2.0).is_empty
    )


def absorb_slivers(cells: list[Cell]) -> list[Cell]:
    """Merge each room that is too small into the neighbour with the longest shared wall."""
    kept = list(cells)
    queue = [cell for cell in kept if not cell.is_circulation and is_too_small(cell.polygon)]
    while queue:
        cell = min(queue, key=lambda c: float(c.polygon.area))
        queue.remove(cell)
        kept.remove(cell)
        host = _absorbing_neighbour(cell, kept)
        if host is None:
            continue
        united = unite(host.polygon, cell.polygon)
        if united is not None:
            merged = Cell(united, host.kind, host.group)
            kept[kept.index(host)] = merged
            if host in queue:
                queue.remove(host)
                queue += [merged] if is_too_small(united) else []
    return kept


def _absorbing_neighbour(cell: Cell, cells: list[Cell]) -> Cell | None:
    rooms = [
        other
        for other in cells
        if not other.is_circulation
        and other.group == cell.group
        and other.polygon.distance(cell.polygon) < SNAP_M
    ]
    lengths = [shared_length(cell.polygon, room.polygon) for room in rooms]
    if not rooms or max(lengths) < MIN_CELL_WIDTH_M / 2.0:
        return None
    return rooms[int(np.argmax(lengths))]


def cut_holes(polygon: Polygon) -> list[Polygon]:
    """Split a polygon along axis-parallel lines through its holes until no piece has a hole."""
    pieces, done = [polygon], []
    while pieces:
        piece = pieces.pop()
        if not piece.interiors:
            done.append(piece)
            continue
        x, y = Polygon(piece.interiors[0]).representative_point().coords[0]
        x0, y0, x1, y1 = piece.bounds
        if x1 - x0 > y1 - y0:
            halves = shapely.box(x0, y0, x, y1), shapely.box(x, y0, x1, y1)
        else:
            halves = shapely.box(x0, y0, x1, y), shapely.box(x0, y, x1, y1)
        for half in halves:
            pieces += polygons_of(piece.intersection(half))
    return done


def warp_cells(cells: list[Cell], warp: Warp) -> list[Cell]:
    """Transform cells by a smooth ``warp`` of points (V, 2) -> (V, 2); edges become curved."""
    warped = []
    for cell in cells:
        ring = shapely.get_coordinates(cell.polygon.exterior.segmentize(_BENT_STEP_M))
        warped.append(Cell(Polygon(warp(ring)).simplify(SNAP_M), cell.kind, cell.group))
    return warped


def clip_cells(cells: list[Cell], outline: Polygon) -> list[Cell]:
    """Return each cell's largest part inside ``outline``, after merging cells too small."""
    clipped = []
    for cell in cells:
        parts = polygons_of(cell.polygon.intersection(outline))
        if parts:
            largest = max(parts, key=lambda part: float(part.area))
            clipped.append(Cell(largest, cell.kind, cell.group))
    return absorb_slivers(clipped)
