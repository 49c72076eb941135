# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Tours: where a robot goes, in which order, until time and places suffice.

The ground says where it may begin and which ways lead on: the rooms of a plan here, free space
that nobody has cut into rooms in ``mesh_tours``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.errors import ConfigError
from fpnet_core.trajectory import path_length
from fpnet_lab.sim.buildings.openings import walkable_area
from fpnet_lab.sim.drives.driving import BODY_RADIUS_M, MOTION, Leg, MotionLimits, Tour, drive_legs
from fpnet_lab.sim.drives.routes import NO_ROOM, Place, Router, draw_nearby
from fpnet_lab.sim.types import BuildingPlan

Array = NDArray[np.float64]

VISIT_DEPTH_M = (1.2, 2.5)
"""How far into a room the robot drives, measured from its door. Chosen."""

# Chosen, not measured:
_MOST_STARTS = 12
_NEARNESS_M = 5.0  # rooms much farther than this from the nearest one are rarely next
_LOOK_RAD = (0.4, 1.0)
_LINGER_S = 4.0  # typical time to stop, look around and turn back
_PACE = 0.75  # mean speed on a path over the highest speed


@dataclass(frozen=True)
class TourLimits:
    """What a tour must contain, distinct rooms (the first one included) and time; its pace."""

    rooms: int = 5
    shortest_s: float = 60.0
    longest_s: float = 100.0
    motion: MotionLimits = MOTION


class Ground(Protocol):
    """Where a robot may drive."""

    @property
    def least_places(self) -> int:
        """How many places a tour has at least, the first one included."""

    def starts(self, rng: np.random.Generator) -> Iterator[Place]:
        """Yield places to begin at, one for each attempt."""

    def ways(self, start: Place, rng: np.random.Generator) -> Iterator[tuple[Array, Place]]:
        """Yield ways (V, 2) [m] and the places they end at, each from the place before."""

    def is_clear(self, tour: Tour) -> bool:
        """Say whether the driven path keeps off the walls: corners are cut a little."""


def plan_tour(
    plan: BuildingPlan,
    rng: np.random.Generator,
    limits: TourLimits | None = None,
) -> Tour:
    """
    Plan and drive a tour that starts in a random room and visits others near by.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
        Draws the start, the order of the rooms, where to stand in them and how to look around.
    limits : TourLimits

    Raises
    ------
    ConfigError
        If no tour through that many rooms, in the time allowed and clear of walls, was found.
    """
    limits = limits or TourLimits()
    ground = _Rooms(plan, limits.rooms)
    tour = tour_on(ground, rng, limits)
    if tour is None:
        raise ConfigError(
            f'{plan.family} plan with {len(ground.candidates)} rooms has no tour through '
            f'{limits.rooms} of them in {limits.shortest_s:.0f} to {limits.longest_s:.0f} s; ask '
            'for fewer rooms or a longer tour, or take another seed'
        )
    return tour


def tour_on(ground: Ground, rng: np.random.Generator, limits: TourLimits) -> Tour | None:
    """Return the first drive with enough places, within the time and clear of walls, or None."""
    for start in ground.starts(rng):
        places, legs = _choose_legs(ground, start, rng, limits)
        if legs and len(places) >= ground.least_places:
            rooms = [place.room for place in places if place.room != NO_ROOM]
            tour = drive_legs(legs, rooms, rng, limits.motion)
            in_time = limits.shortest_s <= tour.duration_s <= limits.longest_s
            if in_time and ground.is_clear(tour):
                return tour
    return None


def _choose_legs(
    ground: Ground,
    start: Place,
    rng: np.random.Generator,
    limits: TourLimits,
) -> tuple[list[Place], list[Leg]]:
    """Add places until both number and time suffice; stop where the next would take too long."""
    places, legs, clock_s = [start], [], 0.0
    middle_s = 0.5 * (limits.shortest_s + limits.longest_s)
    ways = ground.ways(start, rng)
    while len(places) < ground.least_places or clock_s < middle_s:
        path, place = next(ways, (None, start))
        if path is None:
            break
        clock_s += _leg_time_s(path, limits.motion)
        if clock_s > limits.longest_s:
            break
        legs.append(_draw_leg(path, rng))
        places.append(place)
    return places, legs


def _leg_time_s(path: Array, motion: MotionLimits) -> float:
    """Return about how long driving a path (V, 2) and looking around at its end take [s]."""
    return path_length(path) / (_PACE * motion.speed_mps) + _LINGER_S


def _draw_leg(path: Array, rng: np.random.Generator) -> Leg:
    """Draw how far the robot looks around at the end of a path (V, 2), and to which side."""
    return Leg(path, float(rng.choice([-1.0, 1.0]) * rng.uniform(*_LOOK_RAD)))


class _Rooms:
    """The rooms of a plan, each visited once, near ones more often."""

    def __init__(self, plan: BuildingPlan, least_places: int) -> None:
        self.least_places = least_places
        self.candidates = [i for i, room in enumerate(plan.rooms) if room.kind == 'room']
        self._router = Router(plan)
        self._area = walkable_area(plan).buffer(-BODY_RADIUS_M)
        self._corridors = {i for i, room in enumerate(plan.rooms) if room.kind != 'room'}

    def starts(self, rng: np.random.Generator) -> Iterator[Place]:
        rooms = rng.permutation(self.candidates)[:_MOST_STARTS].tolist()
        for room in rooms if len(self.candidates) >= self.least_places else []:
            yield self._router.inner_point(room, rng, VISIT_DEPTH_M)

    def ways(self, start: Place, rng: np.random.Generator) -> Iterator[tuple[Array, Place]]:
        here, closed = start, {*self._corridors, start.room}
        while (room := self._next_room(here, closed, rng)) is not None:
            closed.add(room)
            near = self._router.entrance(here, room)
            place = self._router.inner_point(room, rng, VISIT_DEPTH_M, near)
            path = self._router.path(here, place)
            if path is not None:
                yield path, place
                here = place

    def is_clear(self, tour: Tour) -> bool:
        return bool(shapely.covers(self._area, tour.line()))

    def _next_room(self, here: Place, closed: set[int], rng: np.random.Generator) -> int | None:
        """Draw a room that is not closed to the tour; None if there is none."""
        lengths = self._router.distances(here)
        fresh = sorted(set(lengths) - closed)
        if not fresh:
            return None
        ways_m = np.array([lengths[room] for room in fresh])
        return fresh[draw_nearby(ways_m, _NEARNESS_M, rng)]
