# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""KISS-ICP beside the robot's own odometry: who is believed, and what is said of either."""

import numpy as np
import pytest

from fpnet_core.config import OdometryConfig
from fpnet_core.geometry import SE2
from fpnet_core.io.scans import Scan
from fpnet_core.odometry import Consistency, GuidedOdometry

CONFIG = OdometryConfig(max_range=20.0, min_range=0.5, voxel_size=0.4)
S, PERIOD_NS = 10**9, 10**8
T_ROBOT_START = SE2.from_xy_yaw(40.0, -7.0, 2.0).as_matrix4()  # its frame is another one
BREAKS_AT = 20


def room(rng, count=2000):
    """Points on the walls, floor and ceiling of a room of 9 x 6 x 3 m, off centre."""
    size = np.array([9.0, 6.0, 3.0])
    points = rng.uniform(0.0, size, (count, 3))
    face, side = rng.integers(0, 3, count), rng.integers(0, 2, count)
    points[np.arange(count), face] = side * size[face]
    return points - [3.0, 2.0, 1.2]


def truth(k):
    """Pose after k sweeps: to and fro, and always turning a little."""
    return SE2.from_xy_yaw(1.2 * np.sin(0.09 * k), 0.02 * k, 0.03 * k).as_matrix4()


def drive(robot_at, sweeps=60, disturb=None):
    """Return the odometry at the end, its last pose, and what it said."""
    rng, said = np.random.default_rng(3), []
    odometry = GuidedOdometry(CONFIG, say=said.append)
    for k in range(sweeps):
        if disturb is not None:
            disturb(k, odometry)
        seen = (room(rng) - truth(k)[:3, 3]) @ truth(k)[:3, :3]
        T_robot = robot_at(k)
        scan = Scan(S + k * PERIOD_NS, seen.astype(np.float32), T_odom_sensor=T_robot)
        sweep = odometry.register_scan(scan)
    return odometry, sweep.T_odom_sensor, said


def wheels(k):
    """Odometry that drifts as wheels do: 3 % too long, 2 % too much of every turn."""
    x, y, yaw = truth(k)[0, 3], truth(k)[1, 3], 0.03 * k
    return T_ROBOT_START @ SE2.from_xy_yaw(1.03 * x, 1.03 * y, 1.02 * yaw).as_matrix4()


def is_right(T, k, tolerance_m=0.06):
    error = np.linalg.inv(truth(k)) @ T
    return np.linalg.norm(error[:3, 3]) < tolerance_m


def test_wheels_as_they_are_agree_and_nothing_is_said():
    odometry, T, said = drive(wheels)
    assert odometry.consistency is Consistency.AGREE
    assert said == []
    assert is_right(T, 59)


def test_an_odometry_that_freezes_is_found_out_within_a_second_and_left_out():
    def frozen(k):
        return wheels(min(k, BREAKS_AT))

    odometry, T, said = drive(frozen, BREAKS_AT + 10)
    assert odometry.consistency is Consistency.ROBOT_BROKEN
    assert len(said) == 1
    assert "do not fit the robot's odometry" in said[0]
    odometry, T, said = drive(frozen, 60)
    assert len(said) == 1
    assert is_right(T, 59)


def test_a_jump_of_the_robot_s_odometry_does_no_harm():
    """A wheel odometry that was reset, or a fusion that took a GPS fix."""

    def jumps(k):
        jump = SE2.from_xy_yaw(5.0, 3.0, 1.0).as_matrix4()
        return jump @ wheels(k) if k > BREAKS_AT else wheels(k)

    odometry, T, said = drive(jumps)
    assert is_right(T, 59)
    assert odometry.consistency is not Consistency.KISS_BROKEN
    assert "do not fit the robot's odometry" in said[0]


@pytest.mark.parametrize('scans_between', [1, 2, 5])
def test_an_odometry_that_flips_is_left_out_however_often_it_does(scans_between):
    def flips(k):
        about = np.pi * (k // scans_between % 2)
        return wheels(k) @ SE2.from_xy_yaw(0.0, 0.0, about).as_matrix4()

    odometry, T, said = drive(flips)
    assert odometry.consistency is Consistency.ROBOT_BROKEN
    assert is_right(T, 59)
    assert len(said) == 1


def test_kiss_icp_that_lost_its_place_begins_anew_where_the_robot_s_says():
    lost = SE2.from_xy_yaw(1.5, 1.0, 1.5).as_matrix4()

    def disturb(k, odometry):
        if k == BREAKS_AT:
            odometry._kiss._kiss.last_pose = odometry._kiss._kiss.last_pose @ lost

    odometry, T, said = drive(wheels, disturb=disturb)
    assert len(said) == 2
    assert "restarts at the pose of the robot's odometry" in said[0]
    assert said[1].endswith('both odometries agree again')
    assert odometry.consistency is Consistency.AGREE
    assert is_right(T, 59, 0.15)


def test_where_nothing_comes_from_the_robot_s_it_goes_on_alone():
    odometry, T, said = drive(lambda k: None if k > BREAKS_AT else wheels(k))
    assert odometry.consistency is Consistency.ALONE
    assert len(said) == 1
    assert 'continues alone' in said[0]
    assert is_right(T, 59)


def test_a_guess_bridges_what_scans_alone_do_not():
    """Eight seconds without a scan, in which the robot turned: the next one fits where it is."""
    rng = np.random.default_rng(5)

    def registered(with_guess):
        odometry = GuidedOdometry(CONFIG, say=lambda _: None)
        for k in [*range(15), *range(95, 100)]:
            seen = (room(rng) - truth(k)[:3, 3]) @ truth(k)[:3, :3]
            T_robot = wheels(k) if with_guess else None
            scan = Scan(S + k * PERIOD_NS, seen.astype(np.float32), T_odom_sensor=T_robot)
            sweep = odometry.register_scan(scan)
        return sweep.T_odom_sensor

    assert is_right(registered(with_guess=True), 99, 0.15)
    assert not is_right(registered(with_guess=False), 99, 0.15)
