# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Tour planning: a sequence of places with enough places and duration.

A :class:`Ground` provides start places and paths to further places: the rooms of a plan here,
free space without rooms in ``mesh_tours``.
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
"""Distance that the robot drives into a room, measured from its door. Chosen."""

# Chosen, not measured:
_MOST_STARTS = 12
_NEARNESS_M = 5.0  # rooms much farther away than the nearest one plus this are rarely next
_LOOK_RAD = (0.4, 1.0)
_LINGER_S = 4.0  # typical time to stop, turn and turn back
_PACE = 0.75  # ratio of mean to maximum speed on a path


@dataclass(frozen=True)
class TourLimits:
    """Bounds of a tour: distinct rooms (including the first), duration, and motion limits."""

    rooms: int = 5
    shortest_s: float = 60.0
    longest_s: float = 100.0
    motion: MotionLimits = MOTION


class Ground(Protocol):
    """Drivable space of a robot."""

    @property
    def least_places(self) -> int:
        """Minimum number of places of a tour, including the first."""

    def starts(self, rng: np.random.Generator) -> Iterator[Place]:
        """Yield start places, one per attempt."""

    def ways(self, start: Place, rng: np.random.Generator) -> Iterator[tuple[Array, Place]]:
        """Yield paths (V, 2) [m] with their end places, each from the previous place."""

    def is_clear(self, tour: Tour) -> bool:
        """Return whether the driven path, which cuts corners slightly, is clear of walls."""


def plan_tour(
    plan: BuildingPlan,
    rng: np.random.Generator,
    limits: TourLimits | None = None,
) -> Tour:
    """
    Plan and drive a tour that starts in a random room and visits nearby rooms.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
        Samples the start, the order of the rooms, the places and the turns in them.
    limits : TourLimits

    Raises
    ------
    ConfigError
        If no tour with enough rooms, within the time limits and clear of walls, was found.
    """
    limits = limits or TourLimits()
    ground = _Rooms(plan, limits.rooms)
    tour = tour_on(ground, rng, limits)
    if tour is None:
        raise ConfigError(
            f'{plan.family} plan with {len(ground.candidates)} rooms has no tour through '
            f'{limits.rooms} of them in {limits.shortest_s:.0f} to {limits.longest_s:.0f} s; '
            'request fewer rooms or a longer tour, or use another seed'
        )
    return tour


def tour_on(ground: Ground, rng: np.random.Generator, limits: TourLimits) -> Tour | None:
    """Return the first tour with enough places, within the time and clear of walls, or None."""
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
    """Add places until number and duration suffice, or the next leg would exceed the limit."""
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
    """Return the approximate time to drive a path (V, 2) and turn at its end [s]."""
    return path_length(path) / (_PACE * motion.speed_mps) + _LINGER_S


def _draw_leg(path: Array, rng: np.random.Generator) -> Leg:
    """Return a leg along a path (V, 2) with a random rotation at its end."""
    return Leg(path, float(rng.choice([-1.0, 1.0]) * rng.uniform(*_LOOK_RAD)))


class _Rooms:
    """The rooms of a plan, each visited at most once, with a preference for nearby rooms."""

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
        """Sample a reachable room that is not in ``closed``, or None if there is none."""
        lengths = self._router.distances(here)
        fresh = sorted(set(lengths) - closed)
        if not fresh:
            return None
        ways_m = np.array([lengths[room] for room in fresh])
        return fresh[draw_nearby(ways_m, _NEARNESS_M, rng)]
