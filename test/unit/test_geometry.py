# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rigid transforms, motions, voxels, read-only arrays, clocks."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.linalg import expm

from fpnet_core.errors import OdometryError
from fpnet_core.frozen import frozen_array
from fpnet_core.geometry.motion import part_of, twist
from fpnet_core.geometry.rigid3d import (
    checked_rigid,
    is_rigid,
    quaternion_from_rigid,
    rigid_from_quaternion,
)
from fpnet_core.geometry.voxels import voxel_means
from fpnet_core.stamps import NS_PER_S, ClockGuard

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
        np.zeros((4, 4)), np.diag([1.0, 1.0, -1.0, 1.0]), 1.01 * np.eye(4), np.eye(3),
        np.eye(4) * np.nan,
    ],
)  # fmt: skip
def test_what_is_no_rigid_transform(matrix):
    assert not is_rigid(matrix)
    with pytest.raises(ValueError, match='not a rigid'):
        quaternion_from_rigid(matrix)


@pytest.mark.parametrize(
    'bad',
    [
        np.eye(3), np.diag([2.0, 1.0, 1.0, 1.0]), np.diag([-1.0, 1.0, 1.0, 1.0]),
        np.diag([1.0, 1.0, 1.0, 2.0]), np.full((4, 4), np.nan),
    ],
)  # fmt: skip
def test_a_pose_that_is_not_rigid_is_refused(bad):
    with pytest.raises(OdometryError, match='sensor pose: expected a'):
        checked_rigid(bad)


velocities = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)


def motion(velocity, seconds):
    x, y, z = velocity[3:]
    xi = np.zeros((4, 4))
    xi[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    xi[:3, 3] = velocity[:3]
    return expm(xi * seconds)


@given(velocity=velocities, seconds=st.floats(0.05, 1.0))
def test_an_even_velocity_comes_back_from_the_motion_that_it_makes(velocity, seconds):
    np.testing.assert_allclose(twist(motion(velocity, seconds), seconds), velocity, atol=1e-6)


@given(velocity=velocities, share=st.floats(-1.0, 1.0))
def test_a_part_of_a_motion_is_that_of_a_shorter_time(velocity, share):
    part = part_of(motion(velocity, 1.0), share)
    np.testing.assert_allclose(part, motion(velocity, share), atol=1e-6)


def _expected(points, size_m):
    """Return the means by a dictionary, in the order of the first points."""
    voxels = {}
    for point in points:
        voxels.setdefault(tuple(np.floor(point / size_m).astype(int)), []).append(point)
    return np.array([np.mean(inside, axis=0) for inside in voxels.values()])


def test_each_voxel_gives_the_mean_of_its_points():
    rng = np.random.default_rng(0)
    for size_m, spread_m in ((0.2, 1.0), (1.5, 20.0), (0.05, 90.0)):
        points = rng.normal(0.0, spread_m, (2000, 3))
        np.testing.assert_allclose(voxel_means(points, size_m), _expected(points, size_m))


def test_voxels_do_not_move_with_the_points():
    """Two parts of a wall seen from two places share means where they overlap."""
    wall = np.stack([np.linspace(0.0, 6.0, 601), np.full(601, 2.03), np.zeros(601)], axis=1)
    first, second = (voxel_means(wall[start : start + 400], 0.5) for start in (0, 200))
    shared = [mean for mean in second if (np.abs(first - mean).max(axis=1) < 1e-12).any()]
    assert len(shared) >= 3


def test_a_frozen_array_is_taken_as_it_is():
    first = frozen_array([[1.0, 2.0]], np.float64, (None, 2), 'x')
    assert frozen_array(first, np.float64, (None, 2), 'x') is first


def test_what_somebody_may_still_write_to_is_copied():
    own = np.ones((3, 2))
    view = own[:2]
    view.setflags(write=False)
    for value in (own, view):
        frozen = frozen_array(value, np.float64, (None, 2), 'x')
        own[0, 0] = 7.0
        assert frozen[0, 0] == 1.0
        own[0, 0] = 1.0


def test_a_clock_that_goes_on_is_no_news():
    guard = ClockGuard(3)
    assert [guard.back_s(now, now - 1) for now in (1, 5, 9)] == [None, None, None]


def test_a_few_old_scans_are_dropped_and_many_are_a_clock_that_went_back():
    guard = ClockGuard(3)
    for _ in range(2):
        with pytest.raises(OdometryError, match='not newer than the last one'):
            guard.back_s(NS_PER_S, 2 * NS_PER_S)
    assert guard.back_s(NS_PER_S, 2 * NS_PER_S) == pytest.approx(1.0)
    with pytest.raises(OdometryError):  # it counts anew
        guard.back_s(NS_PER_S, NS_PER_S)


def test_a_new_scan_in_between_ends_the_count():
    guard = ClockGuard(2)
    with pytest.raises(OdometryError):
        guard.back_s(1, 1)
    assert guard.back_s(2, 1) is None
    with pytest.raises(OdometryError):
        guard.back_s(2, 2)
