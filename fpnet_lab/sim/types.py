# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Types of the simulator's buildings: labelled rooms, doors and walls, in metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import networkx as nx
import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.geometry import Affine2D

DOUBLE_LEAF_M = 1.3
"""A single leaf covers openings up to this width. Chosen."""

_LEAST_WIDTH_M = 1e-9  # numerical: avoids division by zero for openings without width


@dataclass(frozen=True, eq=False)
class PlanRoom:
    """A room with its inner outline ``polygon (V, 2)`` [m], counter-clockwise, not closed."""

    polygon: NDArray[np.float64]
    kind: Literal['room', 'corridor', 'hall'] = 'room'


@dataclass(frozen=True, eq=False)
class PlanDoor:
    """
    An opening ``ends (2, 2)`` [m] in the middle of the wall between two rooms (indices).

    ``is_open`` marks a full-height passage without lintel, frame or leaf: the seam between
    two pieces of one corridor. Otherwise a leaf hangs at ``ends[hinge]`` and opens into
    ``rooms[swing]``; openings wider than :data:`DOUBLE_LEAF_M` have a leaf at both ends.

    A door to the outside has the same room twice; :attr:`normal` points outwards, and ``reach_m``
    is the extent of the outer wall along it [m]. Only sheets have such doors, never mirrored.
    """

    rooms: tuple[int, int]
    ends: NDArray[np.float64]
    is_open: bool = False
    hinge: Literal[0, 1] = 0
    swing: Literal[0, 1] = 0
    reach_m: float = 0.0

    @property
    def is_outside(self) -> bool:
        """Return whether the door leads out of the building: both its rooms are the same."""
        return self.rooms[0] == self.rooms[1]

    @property
    def leaves(self) -> int:
        """Number of leaves: 0, 1 or 2."""
        if self.is_open:
            return 0
        return 2 if self.width_m > DOUBLE_LEAF_M else 1

    @property
    def width_m(self) -> float:
        """Length of the opening [m]."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    @property
    def along(self) -> NDArray[np.float64]:
        """Unit vector (2,) from the first end to the second."""
        return np.asarray((self.ends[1] - self.ends[0]) / max(self.width_m, _LEAST_WIDTH_M))

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal (2,) of the opening's line, to the left of :attr:`along`."""
        x, y = self.along
        return np.array([-y, x])


@dataclass(frozen=True, eq=False)
class BuildingPlan:
    """
    The true layout of a building, frame ``building`` [m].

    Rooms do not overlap. A wall of about ``wall_m`` thickness separates neighbouring rooms, and
    the outer wall surrounds them all. ``family`` names the generator's layout family.
    """

    rooms: tuple[PlanRoom, ...]
    doors: tuple[PlanDoor, ...]
    wall_m: float
    family: str

    @property
    def extent(self) -> NDArray[np.float64]:
        """Lower and upper corner ``(2, 2)`` of the bounding box of all room outlines [m]."""
        points = np.concatenate([room.polygon for room in self.rooms])
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @cached_property
    def outlines(self) -> NDArray[np.object_]:
        """Room outlines as shapely polygons (R,) [m]."""
        return polygons_from_rings([room.polygon for room in self.rooms])

    @property
    def floor_area_m2(self) -> float:
        """Floor area of all rooms, without walls and doorways [m^2]."""
        return float(shapely.area(self.outlines).sum())

    def mapped(self, A: Affine2D, first_room: int = 0) -> BuildingPlan:
        """Return the plan transformed by ``A``, with rooms numbered from ``first_room``."""
        turn = -1 if A.is_mirrored else 1
        return replace(
            self,
            rooms=tuple(
                replace(room, polygon=A.apply(room.polygon)[::turn].copy()) for room in self.rooms
            ),
            doors=tuple(
                replace(
                    door,
                    rooms=(door.rooms[0] + first_room, door.rooms[1] + first_room),
                    ends=A.apply(door.ends),
                )
                for door in self.doors
            ),
        )

    def joined_rooms(self) -> list[list[int]]:
        """Return groups of room indices; all pieces of one corridor form one group."""
        seams = nx.Graph(door.rooms for door in self.doors if door.is_open)
        seams.add_nodes_from(range(len(self.rooms)))
        return [sorted(part) for part in nx.connected_components(seams)]

    def room_graph(self) -> nx.MultiGraph:
        """
        Return a graph of rooms (nodes) and doors (edges), numbered like ``rooms`` and ``doors``.

        Nodes carry ``kind`` and ``area_m2``; edges have the door's number as key and carry
        ``width_m`` and ``is_open``.
        """
        graph = nx.MultiGraph()
        areas = shapely.area(self.outlines)
        for i, room in enumerate(self.rooms):
            graph.add_node(i, kind=room.kind, area_m2=float(areas[i]))
        for k, door in enumerate(self.doors):
            graph.add_edge(*door.rooms, key=k, width_m=door.width_m, is_open=door.is_open)
        return graph


def ring_of(polygon: shapely.Polygon) -> NDArray[np.float64]:
    """Return a polygon's outline (V, 2), not closed."""
    return np.asarray(shapely.get_coordinates(polygon.exterior)[:-1])


def polygons_from_rings(rings: Sequence[NDArray[np.float64]]) -> NDArray[np.object_]:
    """Return an array of shapely polygons (R,) from open rings (V, 2)."""
    if not len(rings):
        return np.zeros(0, object)
    number = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    linear = shapely.linearrings(np.concatenate(rings), indices=number)
    return np.asarray(shapely.polygons(linear))
