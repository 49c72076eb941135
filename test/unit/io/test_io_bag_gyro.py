# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans of a bag with an IMU bring the orientation that its gyroscope tells."""

from itertools import pairwise
import logging

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fpnet.bag_writer import BagWriter
from fpnet.recordings.opening import open_scans
from fpnet_core.stamps import NS_PER_S

START_NS = 1_750_000_000 * NS_PER_S
TURN_RADPS = 1.2
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0, 1.0])


def record(path, imu_frame='imu', is_mounted=True, rate=(0.0, 0.0, -TURN_RADPS)):
    """A lidar that turns to the left, and an IMU upside down on it."""
    points = np.random.default_rng(3).uniform(-4.0, 4.0, (300, 3))
    with BagWriter(path) as bag:
        if is_mounted:
            bag.write_transform('/tf_static', START_NS, 'lidar', 'imu', UPSIDE_DOWN)
        for k in range(1, 101):
            bag.write_imu('/imu/data', START_NS + k * 10_000_000, imu_frame, rate)
            if k % 10 == 0:
                bag.write_cloud('/points', START_NS + k * 10_000_000, 'lidar', points)
    return path


@pytest.mark.parametrize('topics', [(), ('/points',)])
def test_turns_are_those_of_the_lidar_wherever_the_imu_is(tmp_path, topics, caplog):
    caplog.set_level(logging.INFO)
    source = open_scans(record(tmp_path / 'bag'), topics=topics)
    for scans in (list(source), list(source)):
        told = [scan.R_gyro_sensor for scan in scans[-8:]]
        turns = [a.T @ b for a, b in pairwise(told)]
        expected = Rotation.from_rotvec([0.0, 0.0, 0.1 * TURN_RADPS]).as_matrix()
        np.testing.assert_allclose(turns, np.tile(expected, (len(turns), 1, 1)), atol=1e-9)
    assert 'rotations are taken from the gyroscope on /imu/data' in caplog.text


def test_of_planar_scanners_as_well(tmp_path):
    readings = type('Laser', (), {})()
    values = {'angle_min': -1.5, 'angle_increment': 0.01, 'angle_max': 1.5, 'scan_time': 0.05}
    values |= {'time_increment': 1e-4, 'range_min': 0.1, 'range_max': 20.0}
    for name, value in values.items():
        setattr(readings, name, value)
    readings.ranges, readings.intensities = np.full(300, 5.0, dtype=np.float32), []
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write_transform('/tf_static', START_NS, 'base_link', 'laser', np.eye(4))
        bag.write_transform('/tf_static', START_NS, 'base_link', 'imu', UPSIDE_DOWN)
        for k in range(1, 101):
            bag.write_imu('/imu', START_NS + k * 10_000_000, 'imu', (0.0, 0.0, -TURN_RADPS))
            if k % 10 == 0 and k < 100:
                bag.write_laser_scan('/scan', START_NS + k * 10_000_000, 'laser', readings)
    told = [scan.R_gyro_sensor for scan in open_scans(tmp_path / 'bag')]
    turned = Rotation.from_matrix(told[2].T @ told[5]).as_rotvec()
    np.testing.assert_allclose(turned, [0.0, 0.0, 0.3 * TURN_RADPS], atol=1e-6)


@pytest.mark.parametrize(
    ('how', 'why'),
    [
        ({'is_mounted': False}, 'no transform on /tf_static connects them'),
        ({'rate': (0.0, np.nan, 0.0)}, 'angular_velocity is not finite'),
    ],
)
def test_one_that_cannot_be_used_is_left_with_its_reason(tmp_path, how, why, caplog):
    scans = list(open_scans(record(tmp_path / 'bag', **how)))
    assert len(scans) == 10
    assert all(scan.R_gyro_sensor is None for scan in scans)
    (said,) = [each.message for each in caplog.records if 'gyroscope' in each.message]
    assert 'the gyroscope on /imu/data is not used' in said
    assert why in said
