# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Path planning in a building: sequences of doors, and collision-free paths between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import itertools

import networkx as nx
import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import Polygon

from fpnet_lab.sim.buildings.openings import opening_polygon
from fpnet_lab.sim.types import BuildingPlan

Array = NDArray[np.float64]

APPROACH_M = 0.45
"""Length of the straight approach to and departure from a door. Chosen."""

DOOR_COST_M = 0.5
"""Path cost of a door; breaks the tie between doors along one line. Chosen."""

CLEARANCES_M = (0.7, 0.45, 0.3, 0.2)
"""Distances to walls; the first that leaves a path through a room is used. Chosen."""

_SNAP_M = 0.6  # maximum distance of a path's end from the area with clearance; chosen
_DRAWN_POINTS = 64  # numerical
_TOLERANCE_M = 1e-6  # numerical
_START, _GOAL = 'start', 'goal'

NO_ROOM = -1
"""Given: room index of places in free space without rooms."""


@dataclass(frozen=True, eq=False)
class Place:
    """A point ``xy (2,)`` [m] in the room with index ``room``, or in :data:`NO_ROOM`."""

    room: int
    xy: Array


class Router:
    """Planner of short, collision-free polylines between places of one plan."""

    def __init__(self, plan: BuildingPlan) -> None:
        self._plan = plan
        self.outlines = plan.outlines
        self._gates = [self._approaches(index) for index in range(len(plan.doors))]
        self._doors_of: list[list[int]] = [[] for _ in plan.rooms]
        self._graph = nx.Graph()
        for index, door in enumerate(plan.doors):
            self._graph.add_node(index)
            for room in door.rooms:
                self._doors_of[room].append(index)
        for doors in self._doors_of:
            for a, b in itertools.combinations(doors, 2):
                way_m = _distance(self._centre(a), self._centre(b)) + DOOR_COST_M
                self._graph.add_edge(a, b, weight=way_m)

    def distances(self, start: Place) -> dict[int, float]:
        """Return the path length [m] to each reachable room by room index."""
        graph = self._graph.copy()
        self._attach(graph, _START, start)
        to_door = nx.single_source_dijkstra_path_length(graph, _START)
        lengths: dict[int, float] = {}
        for door, length in to_door.items():
            if door == _START:
                continue
            for room in self._plan.doors[door].rooms:
                lengths[room] = min(lengths.get(room, np.inf), length)
        return {**lengths, start.room: 0.0}

    def path(self, start: Place, goal: Place) -> Array | None:
        """
        Return a polyline ``(V, 2)`` [m] from ``start`` to ``goal`` through doors.

        Returns None if no doors connect the rooms, or if a room on the way is too narrow.
        """
        doors = self._doors_between(start, goal)
        if doors is None:
            return None
        room, waypoints = start.room, [start.xy]
        for door in doors:
            a, b = self._plan.doors[door].rooms
            onwards = b if room == a else a
            gates = self._gates[door]
            inside = self._inside(room, waypoints[-1], gates[room])
            if inside is None:
                return None
            waypoints += [*inside, gates[onwards]]
            room = onwards
        inside = self._inside(room, waypoints[-1], goal.xy)
        return None if inside is None else np.array([*waypoints, *inside])

    def inner_point(
        self,
        room: int,
        rng: np.random.Generator,
        reach_m: tuple[float, float],
        near: Array | None = None,
    ) -> Place:
        """
        Sample a place well inside a room.

        ``reach_m`` bounds its distance to ``near (2,)``, for example the entrance door; in small
        rooms, the farthest sampled point is used instead.
        """
        outline = self.outlines[room]
        core = outline
        for clearance in CLEARANCES_M:
            core = outline.buffer(-clearance)
            if not core.is_empty:
                break
        points = _points_inside(core, rng)
        if near is None:
            return Place(room, points[0])
        distance = np.linalg.norm(points - near, axis=1)
        is_good = (distance >= reach_m[0]) & (distance <= reach_m[1])
        index = int(np.argmax(is_good) if is_good.any() else np.argmax(distance))
        return Place(room, points[index])

    def entrance(self, start: Place, room: int) -> Array | None:
        """Return the point (2,) where the path from ``start`` enters ``room``, None if none."""
        doors = self._doors_between(start, Place(room, self._room_centre(room)))
        return self._gates[doors[-1]][room] if doors else None

    def _centre(self, door: int) -> Array:
        centre: Array = self._plan.doors[door].ends.mean(axis=0)
        return centre

    def _room_centre(self, room: int) -> Array:
        return np.array(self.outlines[room].representative_point().coords[0])

    def _approaches(self, index: int) -> dict[int, Array]:
        """Return the point (2,) in front of a door in each of its rooms, by room index."""
        door = self._plan.doors[index]
        opening = opening_polygon(self._plan, door)
        depth = opening.area / door.width_m / 2.0
        points = {}
        for room in door.rooms:
            # In a closet shallower than the approach, the point is closer to the door.
            for reach in np.linspace(APPROACH_M, 0.0, 6):
                offset = (depth + reach) * door.normal
                sides = [self._centre(index) + offset, self._centre(index) - offset]
                inside = [s for s in sides if self.outlines[room].contains(shapely.Point(s))]
                if inside:
                    break
            points[room] = inside[0] if inside else self._centre(index)
        return points

    def _attach(self, graph: nx.Graph, name: str, place: Place) -> None:
        graph.add_node(name)
        for door in self._doors_of[place.room]:
            graph.add_edge(name, door, weight=_distance(place.xy, self._centre(door)))

    def _doors_between(self, start: Place, goal: Place) -> list[int] | None:
        if start.room == goal.room:
            return []
        graph = self._graph.copy()
        self._attach(graph, _START, start)
        self._attach(graph, _GOAL, goal)
        try:
            nodes = nx.shortest_path(graph, _START, _GOAL, weight='weight')
        except nx.NetworkXNoPath:
            return None
        return list(nodes[1:-1])

    def _inside(self, room: int, start: Array, goal: Array) -> list[Array] | None:
        """Return the path inside a room, without ``start`` but with ``goal``, or None."""
        for clearance in CLEARANCES_M:
            safe = self.outlines[room].buffer(-clearance, join_style='mitre')
            parts = [part for part in shapely.get_parts(safe).tolist() if not part.is_empty]
            ends = shapely.points([start, goal])
            near = [p for p in parts if shapely.distance(p, ends).max() < _SNAP_M]
            if near:
                return [*_shortest_inside(near[0], start, goal), goal]
        return None


def draw_nearby(ways_m: Array, reach_m: float, rng: np.random.Generator) -> int:
    """
    Sample a goal index given path lengths ``ways_m (N,)`` [m] (infinite: unreachable).

    The probability falls by a factor of e per ``reach_m`` of additional path length.
    """
    weights = np.exp(-(ways_m - ways_m.min()) / reach_m)
    return int(rng.choice(len(weights), p=weights / weights.sum()))


def _distance(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b))


def _points_inside(area: shapely.Geometry, rng: np.random.Generator) -> Array:
    """Return random points (N, 2) in an area, at least one."""
    x0, y0, x1, y1 = area.bounds
    points = rng.uniform((x0, y0), (x1, y1), size=(4 * _DRAWN_POINTS, 2))
    shapely.prepare(area)
    inside: Array = points[shapely.contains_xy(area, points)][:_DRAWN_POINTS]
    if not len(inside):
        inside = shapely.get_coordinates(area.representative_point())
    return inside


def _shortest_inside(area: Polygon, start: Array, goal: Array) -> list[Array]:
    """Return the inner vertices of the shortest path in ``area``, by a visibility graph."""
    ends = [_into(area, start), _into(area, goal)]
    corners = np.concatenate([ends, shapely.get_coordinates(area)])
    grown = area.buffer(_TOLERANCE_M, join_style='mitre')
    shapely.prepare(grown)
    a, b = np.triu_indices(len(corners), 1)
    lines = shapely.linestrings(np.stack([corners[a], corners[b]], axis=1))
    sees = shapely.covers(grown, lines)
    graph = nx.Graph()
    graph.add_nodes_from(range(len(corners)))
    weights = shapely.length(lines)
    graph.add_weighted_edges_from(zip(a[sees], b[sees], weights[sees], strict=True))
    nodes: Sequence[int] = nx.shortest_path(graph, 0, 1, weight='weight')
    path = [corners[node] for node in nodes]
    return [p for p in path if min(_distance(p, start), _distance(p, goal)) > _TOLERANCE_M]


def _into(area: Polygon, xy: Array) -> Array:
    """Return the point of ``area`` nearest to ``xy``."""
    nearest: Array = shapely.get_coordinates(shapely.shortest_line(area, shapely.Point(xy)))[0]
    return nearest
