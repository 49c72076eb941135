# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Conversion of cells to a building: wall thickness, doors, removal of unreachable rooms."""

from __future__ import annotations

from dataclasses import dataclass, replace
import itertools

import networkx as nx
import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import LineString, Polygon, STRtree
from shapely.geometry.polygon import orient

from fpnet_lab.sim.plans.layout import SNAP_M, Cell, Style
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom, ring_of

DOOR_WIDTH_QUANTILES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
DOOR_WIDTHS_M = (0.75, 0.8, 0.9, 0.95, 1.2, 2.0, 2.4)
"""
Door widths of buildings with mixed doors; docs/simulator.md shows the resulting distribution.
Fitted by hand to the development split as counted by `fpnet bench simulator`.
"""

CORNER_GAP_M = 0.25
"""Minimum distance between a door and the corners of its rooms. Chosen."""

INTO_ROOM_SHARE = 0.9
"""
Share of leaves that open into the smaller of the two rooms, out of the traffic. Chosen.
"""

# Chosen, not measured:
MIN_OPENING_M = 1.0
LARGE_ROOM_M2 = 40.0
_TRIES = 12  # numerical


@dataclass(frozen=True)
class _Joint:
    """A line shared by two cells, with the cost of placing a door there."""

    cells: tuple[int, int]
    line: LineString
    cost: float


def finish(rng: np.random.Generator, cells: list[Cell], style: Style, family: str) -> BuildingPlan:
    """
    Convert a tiling to a building in which every room is reachable.

    Doors form a minimum spanning tree over shared walls (rooms prefer corridors, flats prefer
    their own rooms), plus openings between corridor pieces, second doors of large rooms and a
    few room-to-room doors. Unreachable cells become solid.
    """
    rooms = [_room_outline(cell, style.wall_m) for cell in cells]
    kept = [i for i, room in enumerate(rooms) if room is not None]
    cells = [cells[i] for i in kept]
    outlines = [room for room in rooms if room is not None]
    shapely.prepare(outlines)
    placer = _DoorPlacer(rng, cells, outlines, style)
    doors = placer.place(_joints(rng, cells, style))
    return _reachable_part(cells, outlines, doors, style, family)


def _room_outline(cell: Cell, wall_m: float) -> Polygon | None:
    inner = cell.polygon.buffer(-wall_m / 2.0, join_style='mitre')
    parts = [p for p in shapely.get_parts(inner).tolist() if p.area > 1.0]
    if not parts:
        return None
    outline = max(parts, key=lambda part: float(part.area)).simplify(SNAP_M)
    return orient(Polygon(outline.exterior))


def _joints(rng: np.random.Generator, cells: list[Cell], style: Style) -> list[_Joint]:
    """Return lines shared by neighbouring cells: all between corridors, otherwise the longest."""
    polygons = [cell.polygon for cell in cells]
    tree = STRtree(polygons)
    grown = [polygon.buffer(2.0 * SNAP_M, join_style='mitre') for polygon in polygons]
    joints = []
    for a, b in sorted(tree.query(polygons, 'dwithin', SNAP_M).T.tolist()):
        if a >= b:
            continue
        shared = polygons[a].boundary.intersection(grown[b])
        merged = shapely.line_merge(
            shapely.multilinestrings(
                [g for g in shapely.get_parts(shared).tolist() if isinstance(g, LineString)]
            )
        )
        lines = sorted(shapely.get_parts(merged).tolist(), key=lambda part: -float(part.length))
        cost = _cost(cells[a], cells[b])
        joints += [
            _Joint((a, b), line, cost + 0.5 * rng.random())
            for line in (lines if cost == 0.0 else lines[:1])
            if line.length > MIN_OPENING_M + style.wall_m
        ]
    return joints


def _cost(a: Cell, b: Cell) -> float:
    if a.is_circulation and b.is_circulation:
        return 0.0
    if a.group >= 0 and a.group == b.group:
        return 1.0
    if a.is_circulation or b.is_circulation:
        return 2.0
    return 4.0 if a.group < 0 and b.group < 0 else 6.0


class _DoorPlacer:
    """Selection of the joints that get doors, and of the doors' positions along the wall."""

    def __init__(
        self,
        rng: np.random.Generator,
        cells: list[Cell],
        outlines: list[Polygon],
        style: Style,
    ) -> None:
        self._rng, self._cells, self._outlines, self._style = rng, cells, outlines, style
        self._habit = rng.random()

    def place(self, joints: list[_Joint]) -> list[PlanDoor]:
        """Return the doors of a spanning forest and the extra doors."""
        doors: list[PlanDoor] = []
        connected = nx.utils.UnionFind(range(len(self._cells)))
        spare = []
        for joint in sorted(joints, key=lambda j: j.cost):
            a, b = joint.cells
            is_seam = self._cells[a].kind == self._cells[b].kind != 'room'
            if not is_seam and connected[a] == connected[b]:
                spare.append(joint)
                continue
            door = self._opening(joint) if is_seam else self._door(joint)
            if door is not None:
                connected.union(a, b)
                doors.append(door)
        for joint in spare:
            if self._rng.random() < self._extra_probability(joint):
                door = self._door(joint)
                doors += [door] if door is not None else []
        return doors

    def _extra_probability(self, joint: _Joint) -> float:
        a, b = (self._cells[i] for i in joint.cells)
        if a.is_circulation and b.is_circulation:
            return 1.0
        if a.is_circulation or b.is_circulation:
            room = b if a.is_circulation else a
            return self._style.second_door if room.polygon.area > LARGE_ROOM_M2 else 0.02
        if a.group != b.group:
            return 0.0
        return self._style.room_to_room

    def _opening(self, joint: _Joint) -> PlanDoor | None:
        """Return an opening over the whole line shared by two pieces of one corridor."""
        half = self._style.wall_m / 2.0
        ends = _span(joint.line, half, float(joint.line.length) - half)
        return PlanDoor(joint.cells, ends, is_open=True) if ends is not None else None

    def _door(self, joint: _Joint) -> PlanDoor | None:
        """Return a door on the shared line, clear of corners, or None if it does not fit."""
        margin = CORNER_GAP_M + self._style.wall_m / 2.0
        room_for = float(joint.line.length) - 2.0 * margin
        width = self._style.door_width_m or float(
            np.interp(self._rng.random(), DOOR_WIDTH_QUANTILES, DOOR_WIDTHS_M)
        )
        for attempt in range(_TRIES):
            if attempt == _TRIES // 2:
                width = DOOR_WIDTHS_M[0]
            if width > room_for:
                width = max(DOOR_WIDTHS_M[0], min(width, room_for))
            if width > room_for:
                return None
            start = margin + self._fraction(attempt) * (room_for - width)
            ends = _span(joint.line, start, start + width)
            if ends is not None and self._is_clear(joint.cells, ends):
                return self._hinged(joint, ends, is_hinged_first=2.0 * start < room_for - width)
        return None

    def _hinged(self, joint: _Joint, ends: NDArray[np.float64], is_hinged_first: bool) -> PlanDoor:
        """Return a door hinged near the closer corner that mostly opens into the smaller room."""
        a, b = (self._cells[i].polygon.area for i in joint.cells)
        is_usual = self._rng.random() < INTO_ROOM_SHARE
        return PlanDoor(
            joint.cells,
            ends,
            hinge=0 if is_hinged_first else 1,
            swing=0 if (a < b) == is_usual else 1,
        )

    def _fraction(self, attempt: int) -> float:
        """Return the door's relative position along the wall; most doors are near a corner."""
        if self._style.is_uniform and attempt == 0:
            return self._habit
        draw = self._rng.random()
        if self._rng.random() < 0.5:
            return float(draw)
        return float(0.1 * draw if self._rng.random() < 0.5 else 1.0 - 0.1 * draw)

    def _is_clear(self, cells: tuple[int, int], ends: NDArray[np.float64]) -> bool:
        """Return whether both sides of the door, widened by the corner gap, lie in its rooms."""
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        normal = np.array([-along[1], along[0]])
        reach = self._style.wall_m / 2.0 + 0.1
        probes = ends + np.array([-1.0, 1.0])[:, None] * along * (CORNER_GAP_M - 0.02)
        sides = [shapely.points(probes + sign * reach * normal) for sign in (1.0, -1.0)]
        a, b = (self._outlines[i] for i in cells)
        return any(
            bool(
                shapely.contains(first, sides[0]).all()
                and shapely.contains(second, sides[1]).all()
            )
            for first, second in ((a, b), (b, a))
        )


def _span(line: LineString, start_m: float, end_m: float) -> NDArray[np.float64] | None:
    """Return the chord (2, 2) over an arc length interval, or None if the line is curved."""
    chord = LineString([line.interpolate(start_m), line.interpolate(end_m)])
    middle = line.interpolate((start_m + end_m) / 2.0)
    if chord.length < 0.98 * (end_m - start_m) or chord.distance(middle) > 0.05:
        return None
    return np.asarray(shapely.get_coordinates(chord))


def _reachable_part(
    cells: list[Cell],
    outlines: list[Polygon],
    doors: list[PlanDoor],
    style: Style,
    family: str,
) -> BuildingPlan:
    """Return the building of the largest connected set of rooms, renumbered."""
    graph = nx.Graph()
    graph.add_nodes_from(range(len(cells)))
    graph.add_edges_from(door.rooms for door in doors)
    parts = sorted((sorted(part) for part in nx.connected_components(graph)), key=len)
    kept = parts[-1]
    new = dict(zip(kept, itertools.count(), strict=False))
    return BuildingPlan(
        rooms=tuple(PlanRoom(ring_of(outlines[i]), cells[i].kind) for i in kept),
        doors=tuple(
            replace(door, rooms=(new[a], new[b]))
            for door in doors
            for a, b in [door.rooms]
            if a in new
        ),
        wall_m=style.wall_m,
        family=family,
    )
