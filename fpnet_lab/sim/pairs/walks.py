# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random walks of a robot in a world raster."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import grown
from fpnet_core.trajectory import lengths_along
from fpnet_lab.sim.config import ScanConfig
from fpnet_lab.sim.drives.routes import draw_nearby
from fpnet_lab.sim.pairs.perturb import WORLD_CELL_M, World
from fpnet_lab.sim.pairs.scan2d import EMPTY, walk_field, walk_to

ROBOT_RADIUS_M = 0.28  # chosen
WALK_STRIDE = 4
"""Numerical: world cells per cell of the path planning raster."""

REACH_M = 7.0
"""Additional path length over which a room's probability falls by a factor of e. Chosen."""

TINY_WALK_ROOMS = 4
SMALL_WALK_SHARE = (0.1, 0.5)
"""Maximum number of rooms of a tiny walk; range of the share of rooms of a small one. Chosen."""


def plan_walk(
    world: World,
    rng: np.random.Generator,
    config: ScanConfig,
    within: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """
    Return scan positions (S, 2) along a walk from a random start, frame ``building`` [m].

    The walk visits a random number of rooms, preferring nearby ones, and stays inside the convex
    polygon ``within (V, 2)`` if given. The result is empty if the robot fits nowhere.
    """
    is_free = cv2.distanceTransform((world.body == EMPTY).astype(np.uint8), cv2.DIST_L2, 3)
    inside = grown(world.room_of >= 0, 4)
    if within is not None:
        area = np.zeros_like(inside, dtype=np.uint8)
        cv2.fillConvexPoly(area, np.rint(world.to_cells(within)).astype(np.int32), 1)
        inside &= area > 0
    half = WALK_STRIDE // 2
    passable = ((is_free * WORLD_CELL_M > ROBOT_RADIUS_M) & inside)[
        half::WALK_STRIDE, half::WALK_STRIDE
    ]
    room_of = np.where(passable, world.room_of[half::WALK_STRIDE, half::WALK_STRIDE], -1)
    walks = _visit_rooms(passable, room_of, rng, config)
    if not walks:
        return np.zeros((0, 2))
    walk = np.concatenate(walks)
    xy = (walk[:, ::-1] * WALK_STRIDE + half + 0.5) * WORLD_CELL_M + world.origin
    along = lengths_along(xy)
    at = np.arange(0.0, along[-1] + 1e-9, rng.uniform(*config.pose_spacing_m))
    return np.stack([np.interp(at, along, xy[:, axis]) for axis in range(2)], axis=1)


def _visit_rooms(
    passable: NDArray[np.bool_],
    room_of: NDArray[np.int32],
    rng: np.random.Generator,
    config: ScanConfig,
) -> list[NDArray[np.int64]]:
    """Return the paths (S, 2) between rooms as rows and columns of the planning raster."""
    cells = np.flatnonzero(room_of.ravel() >= 0)
    if not len(cells):
        return []
    cells = cells[np.argsort(room_of.ravel()[cells], kind='stable')]
    rooms = room_of.ravel()[cells]
    ids, first = np.unique(rooms, return_index=True)
    target = _draw_room_count(len(ids), rng, config)
    cols = passable.shape[1]
    here = int(rng.choice(cells))
    visited = {int(room_of.ravel()[here])}
    walks = [np.array([[here // cols, here % cols]], dtype=np.int64)]
    while True:
        previous, length = walk_field(passable, here // cols, here % cols)
        nearest = np.full(int(ids[-1]) + 1, np.inf)
        nearest[ids] = np.minimum.reduceat(length[cells], first)
        if len(visited) == 1 and len(walks) == 1:
            reached = cells[(rooms == next(iter(visited))) & np.isfinite(length[cells])]
        else:
            nearest[list(visited)] = np.inf
            if len(visited) >= target or not np.isfinite(nearest).any():
                return walks
            room = draw_nearby(nearest * WALK_STRIDE * WORLD_CELL_M, REACH_M, rng)
            reached = cells[(rooms == room) & np.isfinite(length[cells])]
            visited.add(room)
        here = int(rng.choice(reached))
        walk = walk_to(previous, cols, here // cols, here % cols)
        visited |= {int(r) for r in room_of[walk[:, 0], walk[:, 1]] if r >= 0}
        walks.append(walk[1:])


def _draw_room_count(count: int, rng: np.random.Generator, config: ScanConfig) -> int:
    """Sample how many of ``count`` rooms a walk visits, from very few to most."""
    draw = rng.random()
    if draw < config.tiny_tours:
        return int(rng.integers(1, TINY_WALK_ROOMS + 1))
    least, most = SMALL_WALK_SHARE
    if draw > 1.0 - config.large_tours:
        least, most = most, 1.0
    return max(1, round(float(rng.uniform(least, most)) * count))
