# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A small building drawn twice under a planted transform, for geometry tests."""

import numpy as np

from fpnet_core.geometry import SE2, Affine2D, Similarity2D
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

# x0, y0, x1, y1 of rooms [m]: no two alike, so that only the true placement fits.
ROOMS = (
    (0, 0, 7, 5), (7, 0, 11, 5), (11, 0, 20, 5), (0, 7, 5, 13), (5, 7, 14, 13), (14, 7, 20, 11),
)  # fmt: skip
CORRIDOR = (0, 5, 20, 7)
DOORS = ((3, 5), (9, 5), (17.3, 5), (2, 7), (8, 7), (15.5, 7))


def building_cells(xy: np.ndarray, wall_m: float = 0.2) -> np.ndarray:
    """Cell values of the building at points (..., 2), UNKNOWN outside its outer wall."""
    cells = np.full(xy.shape[:-1], UNKNOWN, dtype=np.int8)
    x, y = xy[..., 0], xy[..., 1]
    half = wall_m / 2
    for x0, y0, x1, y1 in (*ROOMS, CORRIDOR):
        around = (x > x0 - half) & (x < x1 + half) & (y > y0 - half) & (y < y1 + half)
        cells[around & (cells == UNKNOWN)] = OCCUPIED
    for x0, y0, x1, y1 in (*ROOMS, CORRIDOR):
        cells[(x > x0 + half) & (x < x1 - half) & (y > y0 + half) & (y < y1 - half)] = FREE
    for door_x, door_y in DOORS:
        cells[(np.abs(x - door_x) < 0.45) & (np.abs(y - door_y) <= half)] = FREE
    return cells


def draw_building(
    A_building_frame: Affine2D, resolution: float, frame: str, origin: SE2, shape: tuple[int, int]
) -> GridMap:
    """Raster of the building as seen in a frame that ``A_building_frame`` maps from."""
    blank = GridMap(np.zeros(shape, dtype=np.int8), resolution, origin, frame)
    rc = np.stack(np.meshgrid(*map(np.arange, shape), indexing='ij'), axis=-1)
    cells = building_cells(A_building_frame.apply(blank.rc_to_xy(rc)))
    return GridMap(cells, resolution, origin, frame)


A_BUILDING_PLAN = Similarity2D.from_scale_yaw(1.0, np.deg2rad(-20.0), [3.0, 9.0])
A_PLAN_SUBMAP = Affine2D(
    np.array([[1.02, 0.004], [0.004, 0.985]])
    @ Similarity2D.from_scale_yaw(1.0, np.deg2rad(67.0), [0, 0]).linear,
    np.array([4.0, -3.5]),
)


def plan_grid() -> GridMap:
    """The drawing, in a rotated frame with a rotated grid origin."""
    origin = SE2.from_xy_yaw(-10.0, -16.0, 0.3)
    return draw_building(A_BUILDING_PLAN, 0.05, 'plan', origin, (700, 800))


def submap_grid() -> GridMap:
    """The same building as the robot's map, by the planted transform."""
    origin = SE2.from_xy_yaw(-19.0, -24.0, -0.2)
    return draw_building(A_BUILDING_PLAN @ A_PLAN_SUBMAP, 0.05, 'submap', origin, (900, 900))
