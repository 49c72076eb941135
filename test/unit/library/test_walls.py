# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Walls tell plans apart whose doors and corners are alike."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fpnet.library import PlanLibrary, plan_of
from fpnet.library.walls import SeenWalls, plan_walls, seen_walls
from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2, Placements
from fpnet_core.segmentation import STATED_SCALE, segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, GridMap, Segmentation

CELL_M = 0.05


def storey(yaw=0.0):
    """A corridor with three rooms on one side, doors between, walls of three cells."""
    cells = np.full((220, 360), OCCUPIED, np.int8)
    for x0, y0, x1, y1 in ((10, 10, 350, 60), (10, 64, 130, 210), (134, 64, 250, 150)):
        cells[y0:y1, x0:x1] = FREE
    cells[64:210, 254:350] = FREE
    for x in (60, 180, 300):
        cells[60:64, x : x + 18] = FREE
    return GridMap(cells, CELL_M, SE2.from_xy_yaw(3.0, -2.0, yaw))


@pytest.fixture(scope='module')
def plan() -> Segmentation:
    return segment_floorplan(storey(), FpnetConfig().segmentation)


def at(yaw=0.0, x=0.0, y=0.0, scale=1.0):
    return Placements([scale * SE2.from_xy_yaw(x, y, yaw).linear], [[x, y]])


def test_walls_fit_where_they_lie_on_walls_and_nowhere_else(plan):
    walls, seen = plan_walls(plan), SeenWalls.of(seen_walls(plan))
    own = seen.laid(walls, at())[0][0]
    assert own > 0.9
    assert seen.laid(walls, at(yaw=0.05, x=0.3, y=-0.2))[0][0] > 0.8 * own  # is moved onto them
    for other in (at(yaw=np.pi), at(x=3.0), at(y=4.0), at(x=100.0)):
        assert seen.laid(walls, other)[0][0] < 0.5 * own


def test_of_two_plans_with_the_same_doors_and_corners_the_walls_tell_the_right_one(plan):
    full = storey().cells.copy()
    for x in range(20, 340, 20):  # as if drawn with furniture, or hatched
        cv2.circle(full, (x, 120 if x % 40 else 90), 6, OCCUPIED, -1)
    other = replace(plan, grid=replace(plan.grid, cells=full), labels=plan.labels * (full == FREE))
    for first, second in ((plan, other), (other, plan)):
        plans = [plan_of('right', first, STATED_SCALE), plan_of('wrong', second, STATED_SCALE)]
        for order in (plans, plans[::-1]):
            assert PlanLibrary.of(order).find(first, STATED_SCALE)[0].path == 'right'
