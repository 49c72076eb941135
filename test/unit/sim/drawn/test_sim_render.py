# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.geometry import Affine2D
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom


def _box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


@pytest.fixture
def two_rooms():
    rooms = (PlanRoom(_box(0.1, 0.1, 4.9, 2.9)), PlanRoom(_box(5.1, 0.1, 7.9, 2.9)))
    door = PlanDoor((0, 1), np.array([[5.0, 1.0], [5.0, 1.9]]))
    return BuildingPlan(rooms, (door,), 0.2, 'test')


def _value(grid, xy):
    row, col = np.rint(grid.xy_to_rc(np.array(xy))).astype(int)
    return grid.cells[row, col]


TURN = Affine2D(
    np.diag([1.05, 0.96]) @ np.array([[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]]),
    np.array([-7.0, 3.5]),
)


@pytest.mark.parametrize('A', [Affine2D.identity(), TURN], ids=['as built', 'turned'])
def test_rooms_and_doors_are_free_walls_are_not(two_rooms, A):
    grid = render_plan(two_rooms, 0.05, T_plan_building=A)
    for xy in ((2.5, 1.5), (6.5, 2.0), (5.0, 1.45), (0.3, 0.3), (7.7, 2.7)):
        assert _value(grid, A.apply(xy)) == FREE
    for xy in ((5.0, 0.5), (5.0, 2.4), (0.0, 1.5), (6.5, 3.0)):
        assert _value(grid, A.apply(xy)) == OCCUPIED
    assert _value(grid, A.apply((2.5, 3.5))) == UNKNOWN
    assert grid.frame == 'plan'
