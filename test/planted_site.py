# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys beside the planted building: the same one, and one with other inner walls."""

from dataclasses import replace

import numpy as np
from planted import A_BUILDING_PLAN, plan_grid

from fpnet_core.geometry import SE2
from fpnet_core.matches import MatchResult
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

# x0, y0, x1, y1 of walls that only the other storey has [m]; doors are left open.
OTHER_WALLS = ((9.4, 8.0, 9.6, 13.0), (3.4, 1.2, 3.6, 5.0), (12.5, 2.4, 16.0, 2.6))
GONE_WALL = (10.8, 0.2, 11.2, 4.8)
MOVED = SE2.from_xy_yaw(7.0, -3.0, 0.9)


class EvenMatcher:
    """Holds every pair for equally likely, so that the walls alone have to decide."""

    def match(self, plan, sub, explored_area_m2):
        even = np.full((len(plan), len(sub)), 0.01)
        return MatchResult(np.zeros((0, 2)), np.zeros(0), even)


def building_xy(grid):
    rc = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing='ij'), axis=-1)
    return A_BUILDING_PLAN.apply(grid.rc_to_xy(rc))


def inside(xy, box):
    x0, y0, x1, y1 = box
    return (xy[..., 0] > x0) & (xy[..., 0] < x1) & (xy[..., 1] > y0) & (xy[..., 1] < y1)


def other_storey():
    """The planted building with three walls more and one less."""
    grid = plan_grid()
    xy, cells = building_xy(grid), grid.cells.copy()
    cells[inside(xy, GONE_WALL) & (cells == OCCUPIED)] = FREE
    for box in OTHER_WALLS:
        cells[inside(xy, box) & (cells != UNKNOWN)] = OCCUPIED
    return replace(grid, cells=cells)


def laid_elsewhere(grid):
    return replace(grid, T_frame_grid=MOVED @ grid.T_frame_grid)
