# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Point cloud registration baselines, on maps whose walls are extruded to clouds.

KISS-Matcher (Lim et al., ICRA 2025) matches features of points and prunes them as a graph;
MapClosures (Gupta et al., ICRA 2024) matches ORB features of density images. Both run as
published by their authors (the extra ``peers``); neither estimates a scale.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.baselines.answer import Answer

MIN_INLIERS = 5
"""Given: by both programs: a registration with fewer inliers fails."""

DENSITY_M = 0.1
"""
Chosen: pixel of MapClosures' density images. Its default of 0.5 m is for streets: on the planted
building of the tests MapClosures fails with 0.5 m and succeeds with this value.
"""

_HEIGHT_M, _STEP_M = 2.4, 0.1  # chosen: height of an extruded wall, spacing of its points
_FLOOR_STEP_M = 0.2  # chosen: spacing of floor points, by which MapClosures levels the cloud
_PLAN_ID, _SUBMAP_ID = 0, 100  # given: MapClosures skips pairs of maps with nearby numbers

Array = NDArray[np.float64]
Place = Callable[[GridMap], Answer | None]


def kiss_matcher(plan: GridMap) -> Place:
    """Return a function that places submaps by KISS-Matcher, default settings, yaw only."""
    import kiss_matcher as program

    target = list(raised_walls(plan).astype(np.float32))

    def place(sub: GridMap) -> Answer | None:
        walls = raised_walls(sub)
        if not (len(walls) and target):
            return None
        matcher = program.KISSMatcher(program.KISSMatcherConfig(use_quatro=True))
        found = matcher.estimate(list(walls.astype(np.float32)), target)
        inliers = int(matcher.get_num_final_inliers())
        turn, moved = np.asarray(found.rotation), np.ravel(found.translation)
        return _answer(turn, moved, inliers) if found.valid else None

    return place


def map_closures(plan: GridMap) -> Place:
    """Return a function that places submaps by MapClosures, as a loop closure with the plan."""
    from map_closures.config import MapClosuresConfig
    from map_closures.map_closures import MapClosures

    settings = MapClosuresConfig(density_map_resolution=DENSITY_M)
    target = _with_floor(plan)

    def place(sub: GridMap) -> Answer | None:
        walls = _with_floor(sub)
        if not (len(walls) and len(target)):
            return None
        program = MapClosures(settings)
        program.get_best_closure(_PLAN_ID, target)
        found = program.get_best_closure(_SUBMAP_ID, walls)
        if found.number_of_inliers == 0:
            return None
        T_plan_sub = np.linalg.inv(np.asarray(found.pose))
        return _answer(T_plan_sub[:3, :3], T_plan_sub[:3, 3], int(found.number_of_inliers))

    return place


CLOUD_METHODS: Mapping[str, Callable[[GridMap], Place]] = {
    'kiss_matcher': kiss_matcher,
    'map_closures': map_closures,
}
"""Registration methods by the name of the required package."""


def installed() -> tuple[str, ...]:
    """Return the names of the installed methods."""
    return tuple(name for name in CLOUD_METHODS if find_spec(name) is not None)


def raised_walls(grid: GridMap) -> Array:
    """Return the walls as a cloud ``(P, 3)`` in the map frame; ``P = 0`` without walls."""
    xy = _thinned(grid, OCCUPIED, _STEP_M)
    z = np.arange(0.0, _HEIGHT_M, _STEP_M)
    return np.column_stack([np.repeat(xy, len(z), axis=0), np.tile(z, len(xy))])


def _with_floor(grid: GridMap) -> Array:
    floor = _thinned(grid, FREE, _FLOOR_STEP_M)
    return np.concatenate([raised_walls(grid), np.column_stack([floor, np.zeros(len(floor))])])


def _thinned(grid: GridMap, value: int, step_m: float) -> Array:
    """Return positions ``(P, 2)`` of cells with ``value``, at most one per lattice square."""
    xy = grid.rc_to_xy(np.argwhere(grid.cells == value))
    cells = np.unique(np.floor(xy / step_m).astype(np.int64), axis=0)
    return np.asarray((cells + 0.5) * step_m, dtype=np.float64)


def _answer(turn: NDArray[np.float64], moved: NDArray[np.float64], inliers: int) -> Answer:
    yaw = float(np.arctan2(turn[1, 0], turn[0, 0]))
    T_plan_sub = SE2.from_xy_yaw(float(moved[0]), float(moved[1]), yaw)
    score = inliers / (inliers + MIN_INLIERS)
    return Answer(T_plan_sub, score, is_accepted=inliers >= MIN_INLIERS)
