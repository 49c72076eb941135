# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Maps as clouds, and what registers clouds on the planted building, where it is installed."""

import numpy as np
from planted import A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.baselines.cloud_registration import (
    CLOUD_METHODS,
    MIN_INLIERS,
    _answer,
    installed,
    raised_walls,
)

NEAR_M, NEAR_RAD = 1.0, np.deg2rad(10.0)  # as the benchmark counts what is right


def test_walls_are_raised_where_they_stand():
    cells = np.full((20, 30), FREE, np.int8)
    cells[4, 10] = cells[12, 25] = OCCUPIED
    grid = GridMap(cells, 0.5, SE2.from_xy_yaw(3.0, -2.0, 0.4))
    cloud = raised_walls(grid)
    assert cloud.shape[1] == 3
    assert (cloud[:, 2].min(), cloud[:, 2].max()) == pytest.approx((0.0, 2.3))
    places = np.unique(cloud[:, :2], axis=0)
    expected = grid.rc_to_xy([[4, 10], [12, 25]])
    np.testing.assert_allclose(places, expected[np.argsort(expected[:, 0])], atol=0.051)


def test_a_map_without_walls_is_no_cloud():
    assert raised_walls(GridMap(np.zeros((9, 9), np.int8), 0.1)).shape == (0, 3)


@pytest.mark.parametrize('inliers', [MIN_INLIERS - 1, MIN_INLIERS])
def test_a_place_is_claimed_with_enough_inliers(inliers):
    yaw = 0.7
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0, 0, 1]])
    answer = _answer(turn, np.array([1.0, 2.0, 0.1]), inliers)
    assert answer.is_accepted is (inliers >= MIN_INLIERS)
    np.testing.assert_allclose(answer.A_plan_submap.translation, [1.0, 2.0])
    assert answer.A_plan_submap.heading == pytest.approx(yaw)


@pytest.mark.parametrize('name', CLOUD_METHODS)
def test_the_planted_building_is_found(name):
    if name not in installed():
        pytest.skip(f"{name} is not installed: pip install 'fpnet_ros[peers]'")
    sub = submap_grid()
    answer = CLOUD_METHODS[name](plan_grid())(sub)
    assert answer is not None
    walls = sub.rc_to_xy(np.argwhere(sub.cells == OCCUPIED))
    off = answer.A_plan_submap.apply(walls) - A_PLAN_SUBMAP.apply(walls)
    assert np.linalg.norm(off.mean(axis=0)) < NEAR_M
    assert abs(answer.A_plan_submap.heading - A_PLAN_SUBMAP.heading) < NEAR_RAD
    empty = GridMap(np.zeros((20, 20), np.int8), 0.1)
    assert CLOUD_METHODS[name](plan_grid())(empty) is None
