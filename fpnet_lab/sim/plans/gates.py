# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Outside doors: entrances and gates in outer walls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_lab.sim.drawn.symbols import MAX_WINDOW_M, MIN_WINDOW_WALL_M, WINDOW_SHARE
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, ring_of

Array = NDArray[np.float64]

# Chosen, not measured:
_WIDTHS_M = (0.9, 1.0, 1.2, 1.6, 2.0)
_GATES_M = (2.4, 3.0, 4.0, 5.0)
_LONG_WALL_M = 12.0  # only longer walls get gates
_CORNER_M = 0.35
_BEYOND_M = (0.7, 1.6)  # these distances in front of the door must be outside of the building
_TRIES = 40  # numerical


def with_gates(rng: np.random.Generator, plan: BuildingPlan, count: int) -> BuildingPlan:
    """Return the plan with up to ``count`` outside doors that do not collide with windows."""
    walls = [
        (number, ring[i], ring[(i + 1) % len(ring)])
        for number, room in enumerate(plan.rooms)
        for ring in [ring_of(shapely.geometry.polygon.orient(shapely.Polygon(room.polygon)))]
        for i in range(len(ring))
    ]
    return _with_doors(rng, plan, count, walls)


def _with_doors(
    rng: np.random.Generator,
    plan: BuildingPlan,
    count: int,
    walls: list[tuple[int, Array, Array]],
) -> BuildingPlan:
    built = shapely.union_all(shapely.buffer(plan.outlines, 2.0 * plan.wall_m))
    shapely.prepare(built)
    lengths = np.array([float(np.linalg.norm(b - a)) for _, a, b in walls])
    doors: list[PlanDoor] = []
    for _ in range(_TRIES if lengths.max(initial=0.0) > 0.0 else 0):
        if len(doors) >= count:
            break
        number, a, b = walls[int(rng.choice(len(walls), p=lengths / lengths.sum()))]
        door = _door_in(rng, number, a, b, plan.wall_m)
        if door is not None and _is_free(door, built, doors):
            doors.append(door)
    return replace(plan, doors=(*plan.doors, *doors))


def _door_in(
    rng: np.random.Generator, number: int, a: Array, b: Array, wall_m: float
) -> PlanDoor | None:
    """Return a door in a room's wall from ``a`` to ``b`` (2,), or None if it does not fit."""
    length = float(np.linalg.norm(b - a))
    is_gate = length > _LONG_WALL_M and rng.random() < 0.5
    width = float(rng.choice(_GATES_M if is_gate else _WIDTHS_M))
    window = min(WINDOW_SHARE * length, MAX_WINDOW_M) * (length > MIN_WINDOW_WALL_M)
    free = (length - window) / 2.0 - 2.0 * _CORNER_M - width
    if free < 0.0:
        return None
    start = _CORNER_M + float(rng.uniform(0.0, free))
    if rng.random() < 0.5:
        start = length - start - width
    along = (b - a) / max(length, 1e-9)
    out = np.array([along[1], -along[0]])
    ends = np.stack([a + (start + width) * along, a + start * along]) + out * wall_m / 2.0
    return PlanDoor((number, number), ends, hinge=0 if rng.random() < 0.5 else 1, reach_m=wall_m)


def _is_free(door: PlanDoor, built: shapely.Geometry, others: list[PlanDoor]) -> bool:
    places = np.concatenate([door.ends + far * door.normal for far in _BEYOND_M])
    if shapely.contains_xy(built, *places.T).any():
        return False
    middle = door.ends.mean(axis=0)
    return all(
        float(np.linalg.norm(middle - other.ends.mean(axis=0)))
        > (door.width_m + other.width_m) / 2.0 + _CORNER_M
        for other in others
    )


def reaching(plan: BuildingPlan, outer_m: float) -> BuildingPlan:
    """Return the plan with outside doors that pass through outer walls of ``outer_m`` [m]."""
    if not any(door.is_outside for door in plan.doors):
        return plan
    return replace(
        plan,
        doors=tuple(
            replace(door, reach_m=outer_m - plan.wall_m / 2.0) if door.is_outside else door
            for door in plan.doors
        ),
    )
