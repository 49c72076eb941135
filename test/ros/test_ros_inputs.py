# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where a scan was taken: a node and a recording of the same messages know, or not, the same."""

from types import SimpleNamespace

import numpy as np
import pytest

from fpnet.bag_writer import BagWriter
from fpnet.recordings.opening import open_scans
from fpnet_core.errors import OdometryError
from fpnet_core.geometry import SE2

pytestmark = pytest.mark.ros

START_NS, PERIOD_NS = 1_700_000_000_000_000_000, 100_000_000
POINTS = np.random.default_rng(6).normal(0.0, 5.0, (200, 3)).astype(np.float32)
T_BASE_LIDAR = SE2.from_xy_yaw(0.2, -0.1, np.radians(40.0)).as_matrix4(0.5)
SCANS = 6


def T_odom_base(index):
    return SE2.from_xy_yaw(0.3 * index, 0.1, 0.05 * index).as_matrix4()


def recorded(path, child, is_mounted):
    """Return what offline readers make of a bag: pose by stamp."""
    with BagWriter(path) as bag:
        if is_mounted:
            bag.write_transform('/tf_static', START_NS, '/base', 'lidar', T_BASE_LIDAR)
        for index in range(SCANS):
            stamp_ns = START_NS + index * PERIOD_NS
            bag.write_odometry('/odom', stamp_ns, 'odom', child, T_odom_base(index))
            bag.write_cloud('/points', stamp_ns, 'lidar', POINTS)
    return {scan.stamp_ns: scan.T_odom_sensor for scan in open_scans(path)}


class Input:
    """The localizer's input, what it hands on, and what it says."""

    def __init__(self) -> None:
        from fpnet_ros.inputs import ScanInput
        from fpnet_ros.logs import NodeLog
        from fpnet_ros.settings import InputParameters

        self._take, self.located, self.stamps, self.said = {}, [], [], []
        self.said_of_transport = []
        node = SimpleNamespace(
            add_subscription=lambda _, topic, take, *__, **___: self._take.update({topic: take}),
            resolve_topic_name=lambda topic: topic,
            get_logger=lambda: SimpleNamespace(info=self.said_of_transport.append),
        )
        self.input = ScanInput(
            node,
            InputParameters(max_pending_scans=2),
            self.located.append,
            lambda: None,
            NodeLog(SimpleNamespace(error=self.said.append)),
            on_stamp=self.stamps.append,
        )

    def mount(self) -> None:
        import tf2_msgs.msg as tf2_msgs

        from msg_adapters.transforms import transform_to_msg

        mounted = transform_to_msg(T_BASE_LIDAR, START_NS, '/base', 'lidar')
        self._take['/tf_static'](tf2_msgs.TFMessage(transforms=[mounted]))

    def odometry(self, index: int, child: str = 'lidar') -> None:
        from msg_adapters.odometry import odometry_to_msg

        stamp_ns = START_NS + index * PERIOD_NS
        msg = odometry_to_msg(T_odom_base(index), stamp_ns, '/odom', child)
        self._take['kiss/odometry'](msg, {})

    def cloud(self, stamp_ns: int, **columns) -> None:
        from rclpy.serialization import serialize_message

        from msg_adapters.clouds import cloud_to_msg

        msg = cloud_to_msg(POINTS, stamp_ns, 'lidar', **columns)
        if columns:
            msg.row_step = 1  # its times are read at once, and it contradicts itself
        self._take['kiss/frame'](serialize_message(msg), {})


def heard(child, is_mounted):
    """Return what the localizer's input makes of the same messages: poses, and what it says."""
    robot = Input()
    if is_mounted:
        robot.mount()
    for index in range(SCANS):
        robot.odometry(index, child)
        robot.cloud(START_NS + index * PERIOD_NS)
    inputs, located = robot.input, robot.located
    assert inputs.unlocated == SCANS - len(located) - len(inputs._waiting)
    assert bool(inputs.unlocated) == bool(robot.said)
    return {scan.stamp_ns: scan.T_odom_sensor for scan in located}, robot.said


def test_scans_whose_clock_goes_back_alone_are_left_out_and_counted():
    """Odometry goes on: it would put them where the robot was then."""
    robot = Input()
    for index in range(12):
        robot.odometry(index)
        robot.cloud(START_NS + (index if index < 8 else index - 5) * PERIOD_NS)
    assert [scan.stamp_ns for scan in robot.located] == [
        START_NS + index * PERIOD_NS for index in range(8)
    ]
    assert (robot.input.past, robot.input.unlocated) == (4, 0)


def test_a_clock_that_goes_back_for_all_is_the_localizers_to_judge():
    robot = Input()
    for index in (*range(15, 20), *range(4)):
        robot.odometry(index)
        robot.cloud(START_NS + index * PERIOD_NS)
    assert (len(robot.located), robot.input.past) == (9, 0)


def test_scans_without_a_stamp_are_heard_and_counted():
    robot = Input()
    for index in range(5):
        robot.odometry(index)
        robot.cloud(0)
    assert robot.stamps == [0] * 5, 'for the doctor'
    assert (robot.located, robot.input.past, robot.said) == ([], 4, [])


def test_a_cloud_that_contradicts_itself_is_counted():
    robot = Input()
    robot.odometry(0)
    robot.cloud(START_NS, time_s=np.linspace(0.0, 0.1, len(POINTS)))
    assert (robot.input.refused, len(robot.said)) == (1, 1)


def test_a_frame_of_the_odometry_has_no_slash_where_tf_has_none():
    robot = Input()
    robot.odometry(0)
    robot.cloud(START_NS)
    (scan,) = robot.located
    assert (scan.sensor_pose.odom_frame, scan.sensor_pose.tf_frame) == ('odom', 'odom')


@pytest.mark.parametrize(('child', 'is_mounted'), [('base', True), ('lidar', False)])
def test_a_bag_and_a_node_give_the_same_poses(tmp_path, child, is_mounted):
    offline = recorded(tmp_path / 'bag', child, is_mounted)
    online, said = heard(child, is_mounted)
    assert not said
    assert list(offline) == list(online)
    assert len(online) == SCANS
    for stamp_ns, T_odom_sensor in offline.items():
        np.testing.assert_allclose(online[stamp_ns], T_odom_sensor, atol=1e-12)
    place = T_BASE_LIDAR if is_mounted else np.eye(4)
    np.testing.assert_allclose(offline[START_NS + PERIOD_NS], T_odom_base(1) @ place, atol=1e-12)


@pytest.mark.parametrize('child', ['base', ''])
def test_a_missing_mount_is_never_guessed_and_has_one_reason(tmp_path, child):
    with pytest.raises(OdometryError) as offline:
        recorded(tmp_path / 'bag', child, is_mounted=False)
    online, said = heard(child, is_mounted=False)
    assert online == {}
    assert len(said) == 1, 'once, where one is dropped in the end: two may wait'
    reason = str(said[0]).partition(';')[0]
    assert reason.startswith("the pose of 'lidar'")
    assert reason in str(offline.value)
