# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tours: which rooms of a plan a robot visits, in which order, and where it stands in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.driving import BODY_RADIUS_M, Leg, MotionLimits, Tour, drive_legs
from fpnet_lab.sim.openings import walkable_area
from fpnet_lab.sim.routes import Place, Router, draw_nearby
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
    """What a tour must contain: distinct rooms (the first one included) and time."""

    rooms: int = 5
    shortest_s: float = 60.0
    longest_s: float = 100.0


def plan_tour(
    plan: BuildingPlan,
    rng: np.random.Generator,
    limits: TourLimits | None = None,
    motion: MotionLimits | None = None,
) -> Tour:
    """
    Plan and drive a tour that starts in a random room and visits others near by.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
        Draws the start, the order of the rooms, where to stand in them and how to look around.
    limits : TourLimits
    motion : how the robot moves

    Raises
    ------
    ConfigError
        If no tour through that many rooms, in the time allowed and clear of walls, was found.
    """
    limits, motion = limits or TourLimits(), motion or MotionLimits()
    router, area = Router(plan), walkable_area(plan)
    candidates = [i for i, room in enumerate(plan.rooms) if room.kind == 'room']
    starts = rng.permutation(candidates)[:_MOST_STARTS].tolist()
    for start in starts if len(candidates) >= limits.rooms else []:
        rooms, legs = _choose_rooms(plan, router, start, rng, limits, motion)
        if len(rooms) >= limits.rooms:
            tour = drive_legs(legs, rooms, rng, motion)
            in_time = limits.shortest_s <= tour.duration_s <= limits.longest_s
            if in_time and _is_clear(tour, area):
                return tour
    raise ConfigError(
        f'{plan.family} plan with {len(candidates)} rooms has no tour through {limits.rooms} of '
        f'them in {limits.shortest_s:.0f} to {limits.longest_s:.0f} s; ask for fewer rooms or '
        'a longer tour, or take another seed'
    )


def _is_clear(tour: Tour, area: shapely.Geometry) -> bool:
    """Say whether the driven path keeps off the walls: the controller cuts corners a little."""
    return bool(shapely.covers(area.buffer(-BODY_RADIUS_M), tour.line()))


def _choose_rooms(
    plan: BuildingPlan,
    router: Router,
    start: int,
    rng: np.random.Generator,
    limits: TourLimits,
    motion: MotionLimits,
) -> tuple[list[int], list[Leg]]:
    """Add rooms until both number and time suffice; stop where the next would take too long."""
    here = router.inner_point(start, rng, VISIT_DEPTH_M)
    rooms, legs, clock_s = [start], [], 0.0
    closed = {i for i, room in enumerate(plan.rooms) if room.kind != 'room'}
    middle_s = 0.5 * (limits.shortest_s + limits.longest_s)
    while len(rooms) < limits.rooms or clock_s < middle_s:
        room = _next_room(router, here, closed.union(rooms), rng)
        if room is None:
            break
        place = router.inner_point(room, rng, VISIT_DEPTH_M, near=router.entrance(here, room))
        path = router.path(here, place)
        if path is None:
            closed.add(room)
            continue
        clock_s += leg_time_s(path, motion)
        if clock_s > limits.longest_s:
            break
        legs.append(draw_leg(path, rng))
        rooms.append(room)
        here = place
    return rooms, legs


def leg_time_s(path: Array, motion: MotionLimits) -> float:
    """Return about how long driving a path (V, 2) and looking around at its end take [s]."""
    length_m = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    return length_m / (_PACE * motion.speed_mps) + _LINGER_S


def draw_leg(path: Array, rng: np.random.Generator) -> Leg:
    """Draw how far the robot looks around at the end of a path (V, 2), and to which side."""
    return Leg(path, float(rng.choice([-1.0, 1.0]) * rng.uniform(*_LOOK_RAD)))


def _next_room(
    router: Router, here: Place, closed: set[int], rng: np.random.Generator
) -> int | None:
    """Draw a room that is not closed to the tour, near ones more often; None if there is none."""
    lengths = router.distances(here)
    fresh = sorted(set(lengths) - closed)
    if not fresh:
        return None
    return fresh[draw_nearby(np.array([lengths[room] for room in fresh]), _NEARNESS_M, rng)]
