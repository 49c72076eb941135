# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses over time: trees of frames, tracks of poses and of a gyroscope."""

import numpy as np
import pytest

from fpnet_core.errors import OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.geometry.pose_track import MAX_GAP_NS, PoseTrack

S = 10**9


def T(x, y=0.0, yaw=0.0):
    return SE2.from_xy_yaw(x, y, yaw).as_matrix4()


def test_a_track_interpolates_within_and_not_beyond():
    track = PoseTrack.of([(100, T(1.0, 2.0, 0.2)), (200_000_100, T(2.0, 4.0, 0.6))], 'base')
    np.testing.assert_allclose(track.at(50_000_100), T(1.25, 2.5, 0.3), atol=1e-9)
    np.testing.assert_array_equal(track.at(100), T(1.0, 2.0, 0.2))
    assert track.at(99) is None
    assert track.at(200_000_101) is None
    assert (track.child_frame, len(track)) == ('base', 2)
    assert PoseTrack().at(0) is None


@pytest.mark.parametrize(('gap_ns', 'is_known'), [(MAX_GAP_NS, True), (MAX_GAP_NS + 2, False)])
def test_a_robot_may_have_turned_in_a_gap(gap_ns, is_known):
    track = PoseTrack.of([(0, T(0.0)), (gap_ns, T(1.0))])
    assert (track.at(gap_ns // 2) is not None) == is_known


@pytest.mark.parametrize(('turned', 'is_known'), [(1.5, True), (np.pi, False)])
def test_nothing_is_known_between_two_messages_that_no_robot_turns_between(turned, is_known):
    track = PoseTrack.of([(0, T(0.0)), (S // 50, T(0.1, 0.0, turned))])
    assert (track.at(S // 100) is not None) == is_known
    assert ('turns by 180 degrees' in track.reason(S // 100)) != is_known
    np.testing.assert_array_equal(track.at(0), T(0.0))


def test_a_drive_forgets_and_starts_anew_where_the_clock_goes_back():
    track = PoseTrack(horizon_ns=2 * S)
    for k in range(50):
        track.add(k * S // 10, T(float(k)))
    assert len(track) == 21
    track.add(48 * S // 10 - S // 20, T(9.0))  # late, no clock that went back
    assert len(track) == 22
    track.add(0, T(-1.0))
    assert len(track) == 1
    np.testing.assert_array_equal(track.at(0), T(-1.0))


@pytest.fixture
def robot():
    """odom -> base moves, base -> lidar does not."""
    tree = FrameTree(horizon_s=10.0, max_gap_s=0.5)
    tree.add_fixed('base', 'lidar', T(0.3, 0.0, np.pi / 2))
    tree.add('odom', 'base', T(0.0, 0.0), 0)
    tree.add('odom', 'base', T(1.0, 0.0, 0.4), S // 5)
    return tree


def test_poses_are_chained_and_interpolated_in_both_directions(robot):
    at = robot.lookup('odom', 'lidar', S // 10)
    np.testing.assert_allclose(at, T(0.5, 0.0, 0.2) @ T(0.3, 0.0, np.pi / 2), atol=1e-12)
    np.testing.assert_allclose(robot.lookup('lidar', 'odom', S // 10) @ at, np.eye(4), atol=1e-12)
    np.testing.assert_array_equal(robot.lookup('odom', 'base', 0), T(0.0, 0.0))
    np.testing.assert_array_equal(robot.lookup('lidar', 'lidar', 7 * S), np.eye(4))


def test_what_is_not_known_is_none(robot):
    assert robot.lookup('odom', 'camera', 0) is None
    assert robot.lookup('odom', 'lidar', S // 5 + 1) is None
    assert robot.lookup('odom', 'lidar', -1) is None
    robot.add('odom', 'base', T(9.0, 0.0), 2 * S)
    assert robot.lookup('odom', 'lidar', S) is None  # the gap is too long


def test_late_samples_are_put_in_order_and_old_ones_dropped(robot):
    robot.add('odom', 'base', T(5.0, 0.0), S // 10)
    np.testing.assert_array_equal(robot.lookup('odom', 'base', S // 10), T(5.0, 0.0))
    robot.add('odom', 'base', T(0.0, 1.0), 11 * S)
    assert robot.lookup('odom', 'base', 0) is None


def test_a_clock_that_went_back_starts_anew(robot):
    robot.add('odom', 'base', T(0.0, 0.0), 100 * S)
    robot.add('odom', 'base', T(3.0, 0.0), 10 * S)
    assert robot.lookup('odom', 'base', 100 * S) is None
    np.testing.assert_array_equal(robot.lookup('odom', 'base', 10 * S), T(3.0, 0.0))
    robot.clear()
    assert robot.lookup('odom', 'base', 10 * S) is None
    assert robot.lookup('base', 'lidar', 0) is not None


def test_a_loop_of_frames_ends(robot):
    robot.add_fixed('lidar', 'odom', np.eye(4))
    assert robot.lookup('odom', 'elsewhere', 0) is None


def test_a_mount_is_fixed_or_said_to_be_missing(robot):
    np.testing.assert_array_equal(robot.mount('base', '/lidar'), T(0.3, 0.0, np.pi / 2))
    with pytest.raises(OdometryError, match=r"pose of 'camera' in 'base' is unknown: no transf"):
        robot.mount('base', 'camera')
    with pytest.raises(OdometryError, match='has no child_frame_id'):
        robot.mount('', 'lidar')
    # What moves is no mount, even where it is known at some time.
    with pytest.raises(OdometryError, match=r'unknown at 0 ns: no pose before and after'):
        late_arm().mount('base', 'arm')


def late_arm():
    tree = FrameTree()
    tree.add('base', 'arm', T(0.0, 1.0), 5 * S)
    return tree


def test_the_reason_tells_a_missing_mount_from_a_missing_pose(robot):
    assert 'no transform' in robot.reason('odom', 'camera', 0)
    assert 'no pose before and after' in robot.reason('odom', 'lidar', 5 * S)
    assert robot.root('lidar') == 'odom'
    assert robot.root('camera') == 'camera'
