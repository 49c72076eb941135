# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tours through free space that nobody has cut into rooms: from place to place on a raster."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from skimage.graph import MCP_Geometric

from fpnet_core.errors import MapFormatError
from fpnet_core.raster.distance import clearance_of
from fpnet_core.raster.pieces import pieces_of
from fpnet_lab.sim.driving import (
    BODY_RADIUS_M,
    SENSOR_HEIGHT_M,
    Leg,
    MotionLimits,
    Tour,
    drive_legs,
)
from fpnet_lab.sim.mesh_worlds import CELL_M, MeshWorld
from fpnet_lab.sim.tours import TourLimits, draw_leg, leg_time_s

Array = NDArray[np.float64]

LEAST_DRIVABLE_M2 = 6.0
"""A mesh with less connected space for the robot's middle is refused. Chosen."""

_STRIDE = 2  # numerical: raster cells per cell of the path search
# Chosen, not measured:
_MARGIN_M = 0.08  # what paths keep beyond the robot's half width
_WALL_COST_M = 0.35  # nearer to walls than this, driving is made dear
_GOAL_M = (4.0, 14.0)  # length of the way to the next goal
_SPREAD_M = 3.0  # goals are farther apart than this where possible
_SMOOTH_M = 0.25
_ATTEMPTS = 12  # numerical


def plan_mesh_tour(
    world: MeshWorld,
    rng: np.random.Generator,
    limits: TourLimits | None = None,
    motion: MotionLimits | None = None,
) -> Tour:
    """
    Drive from a random place to others through the largest connected free space.

    Parameters
    ----------
    world : MeshWorld
    rng : numpy.random.Generator
        Draws the start, the goals and how to look around.
    limits : TourLimits
        Bounds of the time; rooms are not counted, as a mesh has none.
    motion : how the robot moves

    Raises
    ------
    MapFormatError
        If the free space is too small or too narrow for a robot, or no tour in time is found.
    """
    limits, motion = limits or TourLimits(), motion or MotionLimits()
    clearance = clearance_of(world.free) * CELL_M - CELL_M / 2.0
    coarse = clearance[::_STRIDE, ::_STRIDE]
    drivable = _largest_part(coarse > BODY_RADIUS_M + _MARGIN_M)
    area_m2 = np.count_nonzero(drivable) * (CELL_M * _STRIDE) ** 2
    if area_m2 < LEAST_DRIVABLE_M2:
        raise MapFormatError(
            f'the mesh leaves {area_m2:.1f} m2 of connected space for a robot {2 * BODY_RADIUS_M} '
            f'm wide; expected at least {LEAST_DRIVABLE_M2} m2'
        )
    cost = np.where(drivable, 1.0 + np.square(_WALL_COST_M / np.maximum(coarse, CELL_M)), -1.0)
    for _ in range(_ATTEMPTS):
        legs = _choose_legs(world, cost, drivable, rng, limits, motion)
        if not legs:
            continue
        tour = drive_legs(legs, (), rng, motion, SENSOR_HEIGHT_M)
        in_time = limits.shortest_s <= tour.duration_s <= limits.longest_s
        rc = np.floor((tour.xy - world.origin) / CELL_M).astype(int)[:, ::-1]
        if in_time and clearance[rc[:, 0], rc[:, 1]].min() > BODY_RADIUS_M - CELL_M:
            return tour
    raise MapFormatError(
        f'no tour of {limits.shortest_s:.0f} to {limits.longest_s:.0f} s through {area_m2:.0f} m2 '
        f'of free space in {_ATTEMPTS} attempts; take another seed or a shorter tour'
    )


def _largest_part(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    parts, stats = pieces_of(mask, connectivity=4)
    if len(stats) == 1:
        return mask
    return np.asarray(parts == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax()))


def _choose_legs(
    world: MeshWorld,
    cost: Array,
    drivable: NDArray[np.bool_],
    rng: np.random.Generator,
    limits: TourLimits,
    motion: MotionLimits,
) -> list[Leg]:
    """Add goals, each some way from the last and away from all before, until time is filled."""
    places = np.argwhere(drivable)
    visited = [places[rng.integers(len(places))]]
    legs: list[Leg] = []
    clock_s, cell_m = motion.standstill_s, CELL_M * _STRIDE
    target_s = 0.5 * (limits.shortest_s + limits.longest_s)
    while clock_s < target_s:
        router = MCP_Geometric(cost)
        reach, _ = router.find_costs([tuple(visited[-1])])
        straight = np.linalg.norm(places - visited[-1], axis=1) * cell_m
        apart = np.min([np.linalg.norm(places - v, axis=1) for v in visited], axis=0) * cell_m
        usable = (straight > _GOAL_M[0]) & (straight < _GOAL_M[1])
        usable &= np.isfinite(reach[places[:, 0], places[:, 1]])
        fresh = usable & (apart > _SPREAD_M)
        chosen = np.flatnonzero(fresh if fresh.any() else usable)
        if not len(chosen):
            break
        goal = places[rng.choice(chosen)]
        path = world.to_xy(np.array(router.traceback(tuple(goal))) * _STRIDE)
        path = _smoothed(path, cell_m)
        clock_s += leg_time_s(path, motion)
        if clock_s > limits.longest_s:
            break
        legs.append(draw_leg(path, rng))
        visited.append(goal)
    return legs


def _smoothed(path: Array, cell_m: float) -> Array:
    """Return a raster path (V, 2) without its steps; the ends stay."""
    smooth = gaussian_filter1d(path, _SMOOTH_M / cell_m, axis=0, mode='nearest')
    smooth[0], smooth[-1] = path[0], path[-1]
    return np.asarray(smooth)
