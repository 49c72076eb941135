# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The doctor inside a node, and which run of the odometry it hears; without a middleware."""

from types import SimpleNamespace

from geometry_msgs.msg import TransformStamped
from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from rclpy.qos import QoSDurabilityPolicy
from rclpy.serialization import serialize_message

from fpnet_core.doctor import Problem
from fpnet_core.io.message_types import POINT_CLOUD
from fpnet_ros import checkup
from fpnet_ros.checkup import Checkup, SweepCheckup, findings_to_msg
from fpnet_ros.robot_odometry import OdometryRun

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = pytest.mark.ros

NOW_NS = 1_700_000_000_000_000_000


class _Node:
    """As much of a node as the doctor asks."""

    durability = QoSDurabilityPolicy.TRANSIENT_LOCAL

    def __init__(self):
        self.lines, self.published = [], {'/points', '/floorplan'}
        self.callbacks = {}

    def get_logger(self):
        return SimpleNamespace(warning=self.lines.append)

    def get_clock(self):
        return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=NOW_NS))

    def resolve_topic_name(self, name):
        return f'/{name.lstrip("/")}'

    def get_fully_qualified_name(self):
        return '/localizer'

    def add_subscription(self, kind, topic, callback, qos, raw=False):
        self.callbacks[topic] = lambda msg: callback(serialize_message(msg))

    def get_subscriptions_info_by_topic(self, name):
        return []

    def get_publishers_info_by_topic(self, name):
        qos = SimpleNamespace(durability=self.durability, reliability=None)
        return [SimpleNamespace(node_name='driver', qos_profile=qos)] * (name in self.published)

    def get_topic_names_and_types(self):
        return [('/lidar', [POINT_CLOUD]), ('/points', [POINT_CLOUD])]

    def count_publishers(self, name):
        return int(name == '/lidar')

    def transform(self, parent, child):
        msg = TransformStamped(child_frame_id=child)
        msg.header.frame_id = parent
        msg.transform.rotation.w = 1.0
        self.callbacks['/tf'](tf2_msgs.TFMessage(transforms=[msg]))


@pytest.fixture
def node(monkeypatch):
    monkeypatch.setattr(checkup, '_DISCOVERY_S', 0.0)
    monkeypatch.setattr(checkup, '_TF_PERIOD_S', 0.0)
    return _Node()


def room(height_m: float) -> np.ndarray:
    rays = np.random.default_rng(4).normal(size=(4000, 3))
    walls = np.where(rays > 0.0, (3.5, 2.0, 2.7 - height_m), (-2.5, -3.0, -height_m))
    return (rays * (walls / rays).min(axis=1)[:, None]).astype(np.float32)


def scan(told_m: float):
    mount = np.eye(4)
    mount[2, 3] = told_m
    return SimpleNamespace(stamp_ns=NOW_NS, T_odom_base=np.eye(4), T_odom_sensor=mount)


def test_a_node_that_is_wired_well_is_told_nothing(node):
    doctor = Checkup(node, {'/points': POINT_CLOUD})
    for _ in range(6):
        doctor.hear(NOW_NS)
        doctor.look(scan(0.9), room(0.9))
    node.transform('odom', 'base_link')
    assert doctor.findings() == []
    assert node.lines == []


def test_static_transforms_that_are_not_latched_are_found(node):
    """Nothing of them arrives, as of a recording that is played without its QoS."""
    node.published.add('/tf_static')
    node.durability = QoSDurabilityPolicy.VOLATILE
    found = [
        f for f in Checkup(node, {'/points': POINT_CLOUD}).findings() if f.where == '/tf_static'
    ]
    assert [finding.problem for finding in found] == [Problem.QOS]
    assert 'volatile' in found[0].evidence
    node.durability = QoSDurabilityPolicy.TRANSIENT_LOCAL
    assert Checkup(node, {'/points': POINT_CLOUD}).findings() == []


def test_each_fault_is_logged_once_and_stands_while_it_lasts(node, monkeypatch):
    doctor = Checkup(node, {'/points': POINT_CLOUD})
    for _ in range(6):
        doctor.hear(NOW_NS - 10**10)
        doctor.look(scan(1.7), room(0.9))
    node.transform('odom', 'base_link')
    node.transform('odom_lidar', 'base_link')
    node.published.clear()
    for _ in range(3):
        found = doctor.findings()
    assert [finding.problem for finding in found] == [
        Problem.PARENTS,
        Problem.OTHER_CLOCK,
        Problem.HEIGHT,
        Problem.TOPIC,
        Problem.TOPIC,
    ]
    assert 'available: /lidar' in found[3].evidence
    assert len(node.lines) == 5
    assert all('; next: ' in line for line in node.lines)
    monkeypatch.setattr(checkup, '_TF_MEMORY_S', -1.0)
    node.published.update(('/points', '/floorplan'))
    assert [f.problem for f in doctor.findings()] == [Problem.OTHER_CLOCK, Problem.HEIGHT]


def test_a_lidar_that_returns_nothing_is_told_as_long_as_it_does(node, monkeypatch):
    doctor = Checkup(node, {'/points': POINT_CLOUD})
    nothing = np.zeros((0, 3), dtype=np.float32)
    for _ in range(2):
        doctor.look(scan(0.9), nothing)
    assert doctor.findings() == [], 'a scan without returns may happen'
    monkeypatch.setattr(checkup, 'STALE_INPUT_S', -1.0)
    doctor.look(scan(0.9), nothing)
    assert [finding.problem for finding in doctor.findings()] == [Problem.BLIND]
    monkeypatch.undo()
    doctor.look(scan(0.9), room(0.9))
    assert doctor.findings() == []
    (line,) = node.lines
    assert 'scans without returns (/points)' in line
    assert 'covered' in line


def test_clouds_without_times_stand_in_the_diagnostics():
    doctor = SweepCheckup('/points')
    assert findings_to_msg('/odometry', doctor.findings or ()).level == b'\x00'
    for _ in range(2):
        doctor.look(room(0.9), None)
    (finding,) = doctor.findings
    assert 'no time per point (/points): no usable time field' in finding.said
    msg = findings_to_msg('/odometry', doctor.findings)
    assert (msg.level, msg.name) == (b'\x01', '/odometry: doctor')
    assert msg.values[0].value == doctor.findings[0].next


runs = st.builds(
    OdometryRun,
    st.frozensets(st.sampled_from(['01ab', '02cd', '03ef']), max_size=2),
    st.integers(0, 2**40),
)


@given(runs, runs)
def test_a_run_goes_on_only_from_an_earlier_moment_of_itself(saved, now):
    assert OdometryRun.from_text(saved.as_text()) == saved
    goes_on = now.goes_on_from(saved)
    assert (goes_on is None) == (not saved.publishers or not now.publishers)
    if goes_on:
        assert now.number >= saved.number
        assert now.publishers & saved.publishers


def test_what_is_no_run_is_the_unknown_one():
    for text in ('', 'run 7', '-1 ab'):
        assert OdometryRun.from_text(text) == OdometryRun()
