# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Wheel odometry: right without errors, drifting as told with them."""

import numpy as np
import pytest

from fpnet_lab.sim.drives.drift import WheelErrors, wheel_odometry

EXACT = WheelErrors(length=0.0, turn=0.0, slip_rad_per_sqrt_m=0.0, slip_turn=0.0)


@pytest.fixture
def truth():
    """A drive of 40 m along an S, which starts somewhere and turned."""
    time = np.linspace(0.0, 40.0, 401)
    yaw = 0.7 + 1.2 * np.sin(time / 5.0)
    step = np.diff(time) * 1.0
    middle = (yaw[1:] + yaw[:-1]) / 2.0
    xy = np.cumsum(step[:, None] * np.stack([np.cos(middle), np.sin(middle)], 1), axis=0)
    poses = np.tile(np.eye(4), (401, 1, 1))
    poses[:, 0, 0], poses[:, 1, 1] = np.cos(yaw), np.cos(yaw)
    poses[:, 1, 0], poses[:, 0, 1] = np.sin(yaw), -np.sin(yaw)
    poses[:, :2, 3] = np.array([3.0, -8.0]) + np.concatenate([[[0.0, 0.0]], xy])
    poses[:, 2, 3] = 0.9
    return poses


def test_without_errors_it_is_the_truth_from_its_first_pose(truth):
    odometry = wheel_odometry(truth, np.random.default_rng(0), EXACT)
    expected = np.linalg.inv(truth[0]) @ truth
    assert np.allclose(odometry, expected, atol=1e-9)


def test_drift_is_that_of_wheels(truth):
    ends = [wheel_odometry(truth, np.random.default_rng(seed))[-1] for seed in range(40)]
    wanted = np.linalg.inv(truth[0]) @ truth[-1]
    away = [np.linalg.norm(end[:2, 3] - wanted[:2, 3]) for end in ends]
    assert 0.1 < np.median(away) < 4.0
    assert np.max(away) < 12.0
    again = wheel_odometry(truth, np.random.default_rng(5))
    assert np.array_equal(again[-1], ends[5])
