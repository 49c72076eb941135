# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rigid 3D transforms to and from quaternions."""

import numpy as np
import pytest

from fpnet_core.errors import OdometryError
from fpnet_core.geometry.rigid3d import (
    checked_rigid,
    is_rigid,
    quaternion_from_rigid,
    rigid_from_quaternion,
)

# Rotation by 0.7 rad about (1, 2, 3) / sqrt(14):
# from scipy.spatial.transform import Rotation
# Rotation.from_rotvec(0.7 * np.array([1, 2, 3]) / 14 ** 0.5).as_quat()
XYZW = [0.091643294, 0.183286588, 0.274929882, 0.939372713]


def test_quaternion_is_the_ros_order_and_turns_the_right_way():
    half = 0.5 * 0.3
    T = rigid_from_quaternion([1.0, 2.0, 3.0], [0.0, 0.0, np.sin(half), np.cos(half)])
    moved = T @ [1.0, 0.0, 0.0, 1.0]
    np.testing.assert_allclose(moved, [1.0 + np.cos(0.3), 2.0 + np.sin(0.3), 3.0, 1.0])


def test_round_trip_and_normalisation():
    T = rigid_from_quaternion([4.0, -5.0, 6.0], 3.0 * np.array(XYZW))
    assert is_rigid(T)
    np.testing.assert_allclose(quaternion_from_rigid(T), XYZW, atol=1e-8)
    np.testing.assert_array_equal(T[:3, 3], [4.0, -5.0, 6.0])


@pytest.mark.parametrize('xyzw', [[0, 0, 0, 0], [0, 0, np.nan, 1]])
def test_unset_orientation_is_refused(xyzw):
    with pytest.raises(ValueError, match=r'zero|NaN'):
        rigid_from_quaternion([0, 0, 0], xyzw)


@pytest.mark.parametrize(
    'matrix',
    [
        np.zeros((4, 4)),
        np.diag([1.0, 1.0, -1.0, 1.0]),
        1.01 * np.eye(4),
        np.eye(3),
        np.eye(4) * np.nan,
    ],
)
def test_what_is_no_rigid_transform(matrix):
    assert not is_rigid(matrix)
    with pytest.raises(ValueError, match='not a rigid'):
        quaternion_from_rigid(matrix)


@pytest.mark.parametrize(
    'bad',
    [
        np.eye(3),
        np.diag([2.0, 1.0, 1.0, 1.0]),
        np.diag([-1.0, 1.0, 1.0, 1.0]),
        np.diag([1.0, 1.0, 1.0, 2.0]),
        np.full((4, 4), np.nan),
    ],
)
def test_a_pose_that_is_not_rigid_is_refused(bad):
    with pytest.raises(OdometryError, match='sensor pose: expected a'):
        checked_rigid(bad)
