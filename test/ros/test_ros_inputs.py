# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where a scan was taken: a node and a recording of the same messages know, or not, the same."""

from types import SimpleNamespace

import numpy as np
import pytest

from fpnet_core.errors import OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.io.bag_writer import BagWriter
from fpnet_core.io.recordings import open_scans

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


def heard(child, is_mounted):
    """Return what the localizer's input makes of the same messages: poses, and what it says."""
    from rclpy.serialization import serialize_message
    import tf2_msgs.msg as tf2_msgs

    from fpnet_ros.inputs import InputParameters, ScanInput
    from msg_adapters.clouds import cloud_to_msg
    from msg_adapters.odometry import odometry_to_msg
    from msg_adapters.transforms import transform_to_msg

    take, located, said = {}, [], []
    node = SimpleNamespace(
        add_subscription=lambda kind, topic, callback, *_, **__: take.update({topic: callback}),
        resolve_topic_name=lambda topic: topic,
    )
    parameters = InputParameters(max_pending_scans=2)
    inputs = ScanInput(node, parameters, located.append, lambda: None, said.append)
    if is_mounted:
        mounted = transform_to_msg(T_BASE_LIDAR, START_NS, '/base', 'lidar')
        take['/tf_static'](tf2_msgs.TFMessage(transforms=[mounted]))
    for index in range(SCANS):
        stamp_ns = START_NS + index * PERIOD_NS
        take['kiss/odometry'](odometry_to_msg(T_odom_base(index), stamp_ns, 'odom', child), {})
        take['kiss/frame'](serialize_message(cloud_to_msg(POINTS, stamp_ns, 'lidar')), {})
    assert inputs.unlocated == SCANS - len(located) - len(inputs._waiting)
    assert bool(inputs.unlocated) == bool(said)
    return {scan.stamp_ns: scan.T_odom_sensor for scan in located}, said


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
    assert reason.startswith("the place of 'lidar'")
    assert reason in str(offline.value)
