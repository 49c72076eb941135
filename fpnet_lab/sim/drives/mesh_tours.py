# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tours through free space without rooms: from place to place on a raster."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.distance import cdist
from skimage.graph import MCP_Geometric

from fpnet_core.errors import MapFormatError
from fpnet_core.raster.distance import clearance_of
from fpnet_core.raster.pieces import pieces_of
from fpnet_lab.sim.drives.driving import BODY_RADIUS_M, Tour
from fpnet_lab.sim.drives.mesh_worlds import CELL_M, MeshWorld
from fpnet_lab.sim.drives.routes import NO_ROOM, Place
from fpnet_lab.sim.drives.tours import TourLimits, tour_on

Array = NDArray[np.float64]

LEAST_DRIVABLE_M2 = 6.0
"""Minimum connected area for the robot's centre; smaller meshes are rejected. Chosen."""

_STRIDE = 2  # numerical: raster cells per cell of the path search
# Chosen, not measured:
_MARGIN_M = 0.08  # clearance of paths beyond the robot radius
_WALL_COST_M = 0.35  # path cost rises below this distance to walls
_GOAL_M = (4.0, 14.0)  # straight-line distance to the next goal
_SPREAD_M = 3.0  # preferred minimum distance between goals
_SMOOTH_M = 0.25
_ATTEMPTS = 12  # numerical


def plan_mesh_tour(
    world: MeshWorld,
    rng: np.random.Generator,
    limits: TourLimits | None = None,
) -> Tour:
    """
    Plan and drive a tour between random places in the largest connected free space.

    Parameters
    ----------
    world : MeshWorld
    rng : numpy.random.Generator
        Samples the start, the goals and the turns at the goals.
    limits : TourLimits
        Bounds of the duration; the room count is ignored, as a mesh has no rooms.

    Raises
    ------
    MapFormatError
        If the free space is too small or narrow for a robot, or no tour fits the duration.
    """
    limits = limits or TourLimits()
    ground = _FreeSpace(world)
    if ground.area_m2 < LEAST_DRIVABLE_M2:
        raise MapFormatError(
            f'the mesh leaves {ground.area_m2:.1f} m² of connected space for a robot '
            f'{2 * BODY_RADIUS_M} m wide; expected at least {LEAST_DRIVABLE_M2} m²'
        )
    tour = tour_on(ground, rng, limits)
    if tour is None:
        raise MapFormatError(
            f'no tour of {limits.shortest_s:.0f} to {limits.longest_s:.0f} s through '
            f'{ground.area_m2:.0f} m² of free space in {_ATTEMPTS} attempts; use another seed or '
            'a shorter tour'
        )
    return tour


class _FreeSpace:
    """
    The largest connected free space of a mesh, with spread-out goals.

    Paths avoid walls where space permits. The robot's centre can be anywhere in ``area_m2``.
    """

    least_places = 2

    def __init__(self, world: MeshWorld) -> None:
        self._world = world
        self._clearance = clearance_of(world.free) * CELL_M - CELL_M / 2.0
        coarse = self._clearance[::_STRIDE, ::_STRIDE]
        drivable = _largest_part(coarse > BODY_RADIUS_M + _MARGIN_M)
        dear = np.square(_WALL_COST_M / np.maximum(coarse, CELL_M))
        self._cost = np.where(drivable, 1.0 + dear, -1.0)
        self._cells = np.argwhere(drivable)
        self.area_m2 = len(self._cells) * (CELL_M * _STRIDE) ** 2

    def starts(self, rng: np.random.Generator) -> Iterator[Place]:
        for _ in range(_ATTEMPTS):
            yield self._place(self._cells[rng.integers(len(self._cells))])

    def ways(self, start: Place, rng: np.random.Generator) -> Iterator[tuple[Array, Place]]:
        cell_m = CELL_M * _STRIDE
        visited = [self._cell(start)]
        while True:
            search = MCP_Geometric(self._cost)
            reach, _ = search.find_costs([tuple(visited[-1])])
            straight = np.linalg.norm(self._cells - visited[-1], axis=1) * cell_m
            apart = cdist(self._cells, visited).min(axis=1) * cell_m
            usable = (straight > _GOAL_M[0]) & (straight < _GOAL_M[1])
            usable &= np.isfinite(reach[tuple(self._cells.T)])
            fresh = usable & (apart > _SPREAD_M)
            chosen = np.flatnonzero(fresh if fresh.any() else usable)
            if not len(chosen):
                return
            goal = self._cells[rng.choice(chosen)]
            path = self._world.to_xy(np.array(search.traceback(tuple(goal))) * _STRIDE)
            yield _smoothed(path, cell_m), self._place(goal)
            visited.append(goal)

    def is_clear(self, tour: Tour) -> bool:
        rc = np.floor((tour.xy - self._world.origin) / CELL_M).astype(int)[:, ::-1]
        return bool(self._clearance[rc[:, 0], rc[:, 1]].min() > BODY_RADIUS_M - CELL_M)

    def _place(self, cell: NDArray[np.int64]) -> Place:
        return Place(NO_ROOM, self._world.to_xy(cell[None] * _STRIDE)[0])

    def _cell(self, place: Place) -> NDArray[np.int64]:
        at = (place.xy - self._world.origin) / (CELL_M * _STRIDE)
        return np.floor(at[::-1]).astype(np.int64)


def _largest_part(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    parts, stats = pieces_of(mask, connectivity=4)
    if len(stats) == 1:
        return mask
    return np.asarray(parts == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax()))


def _smoothed(path: Array, cell_m: float) -> Array:
    """Return a raster path (V, 2) smoothed, with its ends unchanged."""
    smooth = gaussian_filter1d(path, _SMOOTH_M / cell_m, axis=0, mode='nearest')
    smooth[0], smooth[-1] = path[0], path[-1]
    return np.asarray(smooth)
