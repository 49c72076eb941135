# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two odometries of one robot, and the one tree of TF in which its base has one parent."""

import numpy as np
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.geometry.pose_lookup import PoseLookup

S = 10**9


def T(x, y, yaw=0.0):
    return SE2.from_xy_yaw(x, y, yaw).as_matrix4()


T_BASE_LIDAR = T(0.3, -0.1, 0.7)


@pytest.fixture
def robot():
    """KISS-ICP's poses of the base, and the robot's own odom -> base_link beside them."""
    where = PoseLookup(odom_frame='odom', base_frame='base_link')
    where.tree.add_fixed('base_link', 'lidar', T_BASE_LIDAR)
    for k in range(5):
        where.add_pose('odom_lidar', 'base_link', T(0.1 * k, 0.0), k * S // 10)
        where.tree.add('odom', 'base_link', T(5.0, 0.1 * k, np.pi / 2), k * S // 10)
    return where


def test_poses_are_the_odometry_s_and_tf_ends_at_the_robot_s_own_frame(robot):
    sensor_pose = robot.sensor_pose('lidar', S // 4)
    assert (sensor_pose.odom_frame, sensor_pose.tf_frame) == ('odom_lidar', 'odom')
    np.testing.assert_allclose(sensor_pose.T_odom_sensor, T(0.25, 0.0) @ T_BASE_LIDAR, atol=1e-12)
    np.testing.assert_allclose(sensor_pose.T_odom_base, T(0.25, 0.0), atol=1e-12)
    in_tf = sensor_pose.T_tf_odom @ sensor_pose.T_odom_base
    np.testing.assert_allclose(in_tf, T(5.0, 0.25, np.pi / 2), atol=1e-12)


def test_equal_names_of_both_odometries_do_no_harm():
    where = PoseLookup(odom_frame='odom', base_frame='base_link')
    for k in range(3):
        where.tree.add('odom', 'base_link', T(7.0, 0.0), k * S // 10)
        where.add_pose('odom', 'base_link', T(0.1 * k, 0.0), k * S // 10)
    sensor_pose = where.sensor_pose('base_link', S // 10)
    np.testing.assert_allclose(sensor_pose.T_odom_base, T(0.1, 0.0), atol=1e-12)
    np.testing.assert_allclose(
        sensor_pose.T_tf_odom @ sensor_pose.T_odom_base, T(7.0, 0.0), atol=1e-12
    )


def test_without_a_frame_of_the_robot_s_tf_is_that_of_the_odometry():
    where = PoseLookup()
    where.add_pose('wheels', '/base_link', T(1.0, 2.0), S)
    where.tree.add_fixed('/base_link', 'lidar', T_BASE_LIDAR)
    sensor_pose = where.sensor_pose('lidar', S)
    assert (sensor_pose.odom_frame, sensor_pose.tf_frame) == ('wheels', 'wheels')
    np.testing.assert_array_equal(sensor_pose.T_tf_odom, np.eye(4))
    np.testing.assert_allclose(sensor_pose.T_odom_sensor, T(1.0, 2.0) @ T_BASE_LIDAR)
    assert where.base_frame == 'base_link'


def test_poses_in_tf_need_no_message():
    where = PoseLookup(from_tf=True, odom_frame='odom')
    where.tree.add_fixed('base_link', 'lidar', T_BASE_LIDAR)
    where.tree.add('odom', 'base_link', T(1.0, 0.0), S)
    sensor_pose = where.sensor_pose('lidar', S)
    np.testing.assert_allclose(sensor_pose.T_odom_sensor, T(1.0, 0.0) @ T_BASE_LIDAR)
    np.testing.assert_allclose(
        sensor_pose.T_odom_base, T(1.0, 0.0), err_msg='what the sensor is on'
    )
    where.tree.add('odom', 'drone', T(2.0, 0.0), S)
    alone = where.sensor_pose('drone', S)
    np.testing.assert_allclose(alone.T_odom_base, alone.T_odom_sensor)


def test_a_motion_is_that_between_two_times(robot):
    moved = robot.motion('lidar', S // 10, 3 * S // 10)
    expected = np.linalg.inv(T_BASE_LIDAR) @ T(0.2, 0.0) @ T_BASE_LIDAR
    np.testing.assert_allclose(moved, expected, atol=1e-12)
    assert robot.motion('lidar', -1, S // 10) is None


def test_what_is_missing_is_named():
    where = PoseLookup(odom_frame='odom', base_frame='base_link')
    assert 'no odometry received' in where.reason('lidar', S)
    where.add_pose('odom_lidar', 'base_link', T(0.0, 0.0), S)
    assert where.sensor_pose('lidar', S) is None
    assert "the pose of 'lidar' in 'base_link' is unknown" in where.reason('lidar', S)
    where.tree.add_fixed('base_link', 'lidar', T_BASE_LIDAR)
    assert 'the odometry has no pose before and after' in where.reason('lidar', 2 * S)
    assert where.sensor_pose('lidar', S) is None
    assert 'leave odom_frame empty' in where.reason('lidar', S)
    where.tree.add('odom', 'base_link', T(0.0, 0.0), S - 1)
    assert "'base_link' in 'odom' is unknown at" in where.reason('lidar', S)
    where.tree.add('odom', 'base_link', T(0.0, 0.0), S)
    assert where.sensor_pose('lidar', S) is not None


def test_a_sensor_without_a_place_is_named_where_odometry_is_in_tf():
    """The odometry is there; nobody has said where on the robot the lidar is."""
    where = PoseLookup(from_tf=True, odom_frame='odom')
    assert 'leave odom_frame empty' in where.reason('lidar', S)
    where.tree.add('odom', 'base_link', T(0.0, 0.0), S)
    assert where.sensor_pose('lidar', S) is None
    reason = where.reason('lidar', S)
    assert reason.startswith("the pose of 'lidar' in 'base_link' is unknown")
    assert '/tf_static' in reason


def test_after_a_restart_nothing_that_moved_is_known(robot):
    robot.clear()
    assert robot.sensor_pose('lidar', S // 4) is None
    assert 'no odometry' in robot.reason('lidar', S // 4)
