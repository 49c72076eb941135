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
from msg_adapters.pairing import StampPairing
from msg_adapters.poses import pose_from_msg, pose_to_msg
from msg_adapters.stamps import stamp_from_msg, stamp_to_msg
from msg_adapters.transforms import matrix_from_pose_msg, matrix_to_pose_msg

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


def test_rotation_is_the_textbook_one():
    # 60 deg about z: (0, 0, sin 30 deg, cos 30 deg); x forward turns to (cos 60, sin 60).
    msg = Pose()
    msg.orientation.z, msg.orientation.w = 0.5, math.sqrt(0.75)
    np.testing.assert_allclose(
        matrix_from_pose_msg(msg)[:3, 0], (0.5, math.sqrt(0.75), 0.0), atol=1e-12
    )


def test_pose_stamped_survives_the_round_trip(received):
    pose = SE2.from_xy_yaw(12.5, -3.75, math.radians(-157.0))
    back = pose_from_msg(received(pose_to_msg(pose, STAMP_NS, 'floorplan')))
    assert (back.stamp_ns, back.frame_id) == (STAMP_NS, 'floorplan')
    np.testing.assert_allclose(back.T_frame_body.matrix, pose.matrix, atol=1e-12)


def test_odometry_survives_the_round_trip(received):
    msg = received(odometry_to_msg(_rigid(), STAMP_NS, 'odom_lidar', 'lidar'))
    back = odometry_from_msg(msg)
    assert (back.stamp_ns, back.frame_id, back.child_frame_id) == (STAMP_NS, 'odom_lidar', 'lidar')
    np.testing.assert_allclose(back.T_odom_child, _rigid(), atol=1e-12)


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


class TestStampPairing:
    def test_partners_meet_in_either_order_and_out_of_sequence(self):
        pairing = StampPairing[str, str](depth=4)
        assert pairing.add_first(10, 'a10') is None
        assert pairing.add_first(20, 'a20') is None
        assert pairing.add_second(20, 'b20') == ('a20', 'b20')
        assert pairing.add_second(30, 'b30') is None
        assert pairing.add_first(30, 'a30') == ('a30', 'b30')
        assert pairing.add_second(10, 'b10') == ('a10', 'b10')
        assert pairing.dropped == 0

    def test_messages_without_a_partner_are_dropped_and_counted(self):
        pairing = StampPairing[int, int](depth=2)
        for stamp in (1, 2, 3):
            assert pairing.add_first(stamp, stamp) is None
        assert pairing.dropped == 1
        assert pairing.add_second(1, 1) is None
        assert pairing.add_second(2, 2) == (2, 2)

    def test_a_repeated_stamp_replaces_the_waiting_message(self):
        pairing = StampPairing[str, str](depth=2)
        pairing.add_first(1, 'old')
        pairing.add_first(1, 'new')
        assert pairing.add_second(1, 'b') == ('new', 'b')

    def test_depth_must_be_positive(self):
        with pytest.raises(ValueError, match='depth'):
            StampPairing[int, int](depth=0)
