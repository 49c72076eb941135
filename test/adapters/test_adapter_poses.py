# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import math

from geometry_msgs.msg import Pose
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fpnet_core.errors import OdometryError
from fpnet_core.geometry import SE2
from msg_adapters.odometry import odometry_from_msg, odometry_to_msg
from msg_adapters.poses import (
    pose_from_msg,
    pose_to_msg,
    uncertain_pose_from_msg,
    uncertain_pose_to_msg,
)
from msg_adapters.stamps import stamp_from_msg, stamp_to_msg
from msg_adapters.transforms import (
    matrix_from_pose_msg,
    matrix_to_pose_msg,
    transform_from_msg,
    transform_to_msg,
)

STAMP_NS = 1_700_000_000_000_000_007


def _rigid() -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler('ZYX', (131.0, -12.0, 7.0), degrees=True).as_matrix()
    matrix[:3, 3] = (3.5, -8.25, 0.75)
    return matrix


@pytest.mark.parametrize('stamp_ns', [0, 7, 999_999_999, 1_000_000_000, STAMP_NS])
def test_stamps_are_exact(stamp_ns):
    assert stamp_from_msg(stamp_to_msg(stamp_ns)) == stamp_ns


def test_pose_survives_the_round_trip(received):
    back = matrix_from_pose_msg(received(matrix_to_pose_msg(_rigid())))
    np.testing.assert_allclose(back, _rigid(), atol=1e-12)


def test_pose_stamped_survives_the_round_trip(received):
    pose = SE2.from_xy_yaw(12.5, -3.75, math.radians(-157.0))
    back = pose_from_msg(received(pose_to_msg(pose, STAMP_NS, 'floorplan')))
    assert (back.stamp_ns, back.frame_id) == (STAMP_NS, 'floorplan')
    np.testing.assert_allclose(back.T_frame_body.matrix, pose.matrix, atol=1e-12)


def test_a_pose_with_covariance_survives_the_round_trip(received):
    pose = SE2.from_xy_yaw(12.5, -3.75, math.radians(-157.0))
    cov = np.array([[0.04, 0.01, 0.002], [0.01, 0.09, -0.003], [0.002, -0.003, 0.001]])
    back = uncertain_pose_from_msg(received(uncertain_pose_to_msg(pose, cov, STAMP_NS, 'map')))
    assert (back.pose.stamp_ns, back.pose.frame_id) == (STAMP_NS, 'map')
    np.testing.assert_allclose(back.pose.T_frame_body.matrix, pose.matrix, atol=1e-12)
    np.testing.assert_array_equal(back.cov, cov)


def test_a_covariance_that_is_none_is_refused():
    msg = uncertain_pose_to_msg(SE2.identity(), np.eye(3), 0, 'map')
    msg.pose.covariance[7] = math.nan
    with pytest.raises(OdometryError, match='covariance'):
        uncertain_pose_from_msg(msg)


def test_a_transform_survives_the_round_trip(received):
    back = transform_from_msg(received(transform_to_msg(_rigid(), STAMP_NS, '/odom', 'base')))
    assert (back.stamp_ns, back.parent, back.child) == (STAMP_NS, 'odom', 'base')
    np.testing.assert_allclose(back.T_parent_child, _rigid(), atol=1e-12)


def test_a_transform_without_orientation_is_refused():
    msg = transform_to_msg(np.eye(4), 0, 'odom', 'base')
    msg.transform.rotation.w = 0.0
    with pytest.raises(OdometryError, match='odom -> base'):
        transform_from_msg(msg)


def test_odometry_carries_its_variances(received):
    msg = received(odometry_to_msg(_rigid(), STAMP_NS, 'odom', 'lidar', (1, 2, 3, 4, 5, 6)))
    np.testing.assert_array_equal(
        np.diag(np.reshape(msg.pose.covariance, (6, 6))), (1, 2, 3, 4, 5, 6)
    )


def test_odometry_survives_the_round_trip(received):
    msg = received(odometry_to_msg(_rigid(), STAMP_NS, 'odom_lidar', 'lidar'))
    back = odometry_from_msg(msg)
    assert (back.stamp_ns, back.parent, back.child) == (STAMP_NS, 'odom_lidar', 'lidar')
    np.testing.assert_allclose(back.T_parent_child, _rigid(), atol=1e-12)


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        (lambda p: setattr(p.orientation, 'w', 0.0), 'quaternion'),
        (lambda p: setattr(p.orientation, 'z', math.nan), 'NaN'),
        (lambda p: setattr(p.position, 'y', math.inf), 'infinity'),
    ],
)
def test_unusable_poses_are_refused(received, change, message):
    msg = Pose()
    change(msg)
    with pytest.raises(OdometryError, match=message):
        matrix_from_pose_msg(received(msg))


def test_a_scaled_matrix_is_not_published():
    with pytest.raises(OdometryError, match='rigid'):
        matrix_to_pose_msg(np.diag([2.0, 2.0, 2.0, 1.0]))


def test_rotation_is_the_textbook_one():
    # 60 deg about z: (0, 0, sin 30 deg, cos 30 deg); x forward turns to (cos 60, sin 60).
    msg = Pose()
    msg.orientation.z, msg.orientation.w = 0.5, math.sqrt(0.75)
    np.testing.assert_allclose(
        matrix_from_pose_msg(msg)[:3, 0], (0.5, math.sqrt(0.75), 0.0), atol=1e-12
    )
