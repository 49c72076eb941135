# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sweeps without times: of one instant or bent by the motion, in any order, the odometry sees."""

import logging

import numpy as np
import pytest

from fpnet_core.config import OdometryConfig
from fpnet_core.io.scans import Scan
from fpnet_core.odometry import KissOdometry
from fpnet_core.odometry.deskew_detection import turn_shares

BEAMS, COLUMNS, SWEEPS = 16, 600, 70
SIZE = np.array([11.0, 7.0, 2.7])  # of a bare room [m]


def place(time_s):
    """Where the sensor is, x, y and yaw: it drives to and fro, and turns more than it drives."""
    turn = 0.9 * np.sin(0.9 * time_s) + 0.3 * time_s
    return 3.0 + 0.5 * time_s, 3.0 + 0.5 * np.sin(0.6 * time_s), turn


def pose(time_s):
    x, y, yaw = place(time_s)
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:3, 3] = x, y, 0.6
    return T


def cloud(middle_s, rng, spin, by_rows):
    """A sweep; ``spin`` 1 or -1: counter-clockwise or clockwise in 0.1 s, 0: at once."""
    order = np.arange(COLUMNS) / COLUMNS
    azimuth = (order * 2.0 * np.pi - np.pi) * (spin or 1)
    x, y, yaw = place(middle_s + 0.1 * (order - 0.5) * abs(spin))
    elevation = np.deg2rad(np.linspace(-15.0, 15.0, BEAMS))
    level, up = np.cos(elevation), np.broadcast_to(np.sin(elevation), (COLUMNS, BEAMS))
    angle = (azimuth + yaw)[:, None]
    ray = np.stack([np.cos(angle) * level, np.sin(angle) * level, up], axis=-1)
    ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
    sensor = np.stack([x, y, np.full_like(x, 0.6)], axis=-1)[:, None]
    reach = (np.where(ray > 0.0, SIZE, 0.0) - sensor) / ray
    reach = reach.min(axis=-1) + rng.normal(0.0, 0.015, (COLUMNS, BEAMS))
    azimuth = azimuth[:, None]
    points = np.stack([np.cos(azimuth) * level, np.sin(azimuth) * level, up], axis=-1)
    points = points * reach[:, :, None]
    points = points.transpose(1, 0, 2) if by_rows else points
    return points.reshape(-1, 3)[rng.random(BEAMS * COLUMNS) > 0.02]


def driven(spin, by_rows, shown=lambda points: points):
    """Return the error of the last pose [m], [deg] of a robot that is shown no times."""
    rng, odometry = np.random.default_rng(4), KissOdometry(OdometryConfig())
    for k in range(SWEEPS):
        points = shown(cloud(0.1 * k, rng, spin, by_rows))
        found = odometry.register_scan(Scan(k * 100_000_000, points)).T_odom_sensor
    off = np.linalg.inv(np.linalg.inv(pose(0.0)) @ pose(0.1 * (SWEEPS - 1))) @ found
    return np.hypot(*off[:2, 3]), abs(np.degrees(np.arctan2(off[1, 0], off[0, 0])))


@pytest.mark.parametrize('by_rows', [False, True])
@pytest.mark.parametrize(('spin', 'said'), [(0, 'instantaneous'), (1, 'order'), (-1, 'order')])
def test_a_robot_finds_out_and_comes_out_right(spin, said, by_rows, caplog):
    with caplog.at_level(logging.INFO, logger='fpnet_core'):
        off_m, off_deg = driven(spin, by_rows)
    assert off_m < 0.1
    assert off_deg < 1.0
    words = [each.getMessage() for each in caplog.records if 'without times' in each.getMessage()]
    assert len(words) == 1
    assert said in words[0]


def test_an_order_that_tells_nothing_is_no_order():
    rng = np.random.default_rng(5)
    points = cloud(0.0, rng, 1, False)
    assert turn_shares(rng.permutation(points)) is None
    assert turn_shares(points[np.lexsort(np.floor(points / 0.1).T)]) is None  # a voxel grid's
    ahead = points[np.abs(np.arctan2(points[:, 1], points[:, 0])) < 0.6]
    assert turn_shares(ahead) is None
