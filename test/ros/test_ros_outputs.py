# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is published together is of one moment; without a middleware running."""

from collections import defaultdict
from types import SimpleNamespace

import numpy as np
from planted import plan_grid
import pytest

pytest.importorskip('rclpy')

from rclpy.clock import ROSClock

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.geometry.pose_lookup import SensorPose
from fpnet_core.localizer.localizer import Snapshot
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.pose_covariance import Growth, PoseCovariance, PoseFeatures
from fpnet_core.types import GridMap, LocalizerOutput, Status, Submap
from fpnet_ros import health as health_module
from fpnet_ros.health import LOST, ClockSilence, Health
from fpnet_ros.inputs import LocatedScan
from fpnet_ros.logs import NodeLog
from fpnet_ros.outputs import LocalizerOutputs, StampedOutput
from fpnet_ros.runtime import TFMessage
from msg_adapters.poses import pose_from_msg, uncertain_pose_from_msg
from msg_adapters.transforms import transform_from_msg

needs_tf = pytest.mark.skipif(TFMessage is None, reason='needs a C++ compiler at set-up')

STAMP_NS = 1_700_000_000_000_000_000
SECOND_NS = 10**9
GRID = plan_grid()
STRETCH = np.array([[1.1, 0.0], [0.0, 0.95]])
A_PLAN_ODOM = Affine2D(STRETCH @ SE2.from_xy_yaw(0.0, 0.0, 0.7).linear, np.array([12.0, -3.0]))
T_ODOM_BASE = SE2.from_xy_yaw(4.0, 9.0, -0.4)
T_TF_ODOM = SE2.from_xy_yaw(1.0, -2.0, 0.2)
FRAME = MapFrame(GRID, 'drawing', 'map').followed(A_PLAN_ODOM)


class Topics:
    """Stands for the node: keeps what each publisher was given."""

    is_active = True

    def __init__(self):
        self.sent = defaultdict(list)

    def get_fully_qualified_name(self):
        return '/localizer'

    def add_publisher(self, kind, topic, qos):
        publish = self.sent[topic].append
        return SimpleNamespace(publish=publish, get_subscription_count=lambda: 1)

    def poses(self):
        return [pose_from_msg(msg) for msg in self.sent['floorplan_pose']]

    def tfs(self):
        return [transform_from_msg(msg.transforms[0]) for msg in self.sent['/tf']]


@pytest.fixture
def topics():
    return Topics()


@pytest.fixture
def outputs(topics):
    return LocalizerOutputs(topics, 0.1)


def scan(stamp_ns=STAMP_NS):
    base, T_tf_odom = T_ODOM_BASE.as_matrix4(), T_TF_ODOM.as_matrix4()
    sensor_pose = SensorPose('odom', base, base, 'wheels', T_tf_odom)
    return LocatedScan(lambda: None, stamp_ns, sensor_pose)


def snapshot(status=Status.LOCALIZED, grid=GRID):
    submap = Submap(GridMap(np.zeros((2, 2), np.int8), 0.05), np.zeros((2, 2), bool), [[0.0, 0.0]])
    features = PoseFeatures(np.eye(3), np.zeros(1))
    growth = Growth(0.05, 0.01, 0.003, 0.002)
    cov = np.diag([0.1, 0.2, 0.01])
    covariance = PoseCovariance(cov, np.array([3.5, 9.0]), STAMP_NS - SECOND_NS, growth, features)
    claim = (A_PLAN_ODOM, covariance) if status is Status.LOCALIZED else ()
    output = LocalizerOutput(STAMP_NS, status, *claim, submap=submap)
    return Snapshot(output, SimpleNamespace(given=grid))


def test_pose_twin_and_tf_are_of_one_snapshot(topics, outputs):
    outputs.publish_pose(StampedOutput.of(snapshot(), FRAME, scan()))
    (pose,), (msg,) = topics.poses(), topics.sent['floorplan_pose_with_covariance']
    assert (pose.frame_id, pose.stamp_ns) == ('drawing', STAMP_NS)
    np.testing.assert_allclose(
        pose.T_frame_body.translation, A_PLAN_ODOM.apply(T_ODOM_BASE.translation), atol=1e-9
    )
    twin = uncertain_pose_from_msg(msg)
    assert twin.pose.frame_id == 'map'
    np.testing.assert_allclose(
        twin.pose.T_frame_body.translation,
        FRAME.A_map_plan.apply(pose.T_frame_body.translation),
        atol=1e-9,
    )
    located = FRAME.located(snapshot().output, T_ODOM_BASE.as_matrix4(), STAMP_NS)
    np.testing.assert_allclose(twin.cov, located.cov, atol=1e-12)
    T_map_odom = twin.pose.T_frame_body @ T_ODOM_BASE.inv()
    np.testing.assert_allclose(T_map_odom.matrix, located.T_map_odom.matrix, atol=1e-9)


@needs_tf
def test_the_tf_leads_to_the_frame_that_it_is_published_for(topics, outputs):
    outputs.publish_pose(StampedOutput.of(snapshot(), FRAME, scan()))
    outputs.broadcast(STAMP_NS)
    (tf,) = topics.tfs()
    assert (tf.parent, tf.child, tf.stamp_ns) == ('map', 'wheels', STAMP_NS)
    T_map_base = SE2.from_matrix4(tf.T_parent_child) @ T_TF_ODOM @ T_ODOM_BASE
    (msg,) = topics.sent['floorplan_pose_with_covariance']
    twin = uncertain_pose_from_msg(msg).pose.T_frame_body
    np.testing.assert_allclose(T_map_base.matrix, twin.matrix, atol=1e-9)


@needs_tf
def test_a_tf_is_repeated_for_new_stamps_until_nothing_is_claimed(topics, outputs):
    outputs.broadcast(STAMP_NS)
    assert topics.tfs() == []
    outputs.publish_pose(StampedOutput.of(snapshot(), FRAME, scan()))
    for stamp_ns in (STAMP_NS, STAMP_NS, STAMP_NS + 1):
        outputs.broadcast(stamp_ns)
    assert [tf.stamp_ns for tf in topics.tfs()] == [STAMP_NS, STAMP_NS + 1]
    outputs.publish_pose(
        StampedOutput.of(snapshot(Status.LOST), FRAME, scan(STAMP_NS + SECOND_NS))
    )
    outputs.broadcast(STAMP_NS + 2)
    assert len(topics.tfs()) == 2
    assert len(topics.poses()) == 1


def test_each_scan_has_one_pose(topics, outputs):
    for stamp_ns in (STAMP_NS, STAMP_NS, STAMP_NS + SECOND_NS):
        outputs.publish_pose(StampedOutput.of(snapshot(), FRAME, scan(stamp_ns)))
    assert [pose.stamp_ns for pose in topics.poses()] == [STAMP_NS, STAMP_NS + SECOND_NS]
    outputs.publish_tick(StampedOutput.of(snapshot(), FRAME, None))
    (path,) = topics.sent['floorplan_path']
    assert len(path.poses) == 1, 'the robot has not moved'


@pytest.mark.parametrize(
    ('told', 'frame', 'newest'),
    [
        (snapshot(grid=plan_grid()), FRAME, scan()),
        (Snapshot(LocalizerOutput(0, Status.NO_PLAN)), FRAME, scan()),
        (snapshot(), None, scan()),
        (snapshot(), FRAME, None),
        (snapshot(Status.SEARCHING), FRAME, scan()),
    ],
)
def test_what_does_not_belong_together_is_not_published(topics, outputs, told, frame, newest):
    """An output of one floorplan and the frames of another, above all."""
    moment = StampedOutput.of(told, frame, newest)
    assert moment.located is None
    outputs.publish_pose(moment)
    outputs.broadcast(STAMP_NS)
    assert topics.poses() == []
    assert topics.sent['/tf'] == []


def test_losses_are_news_once_and_silence_is_as_long_as_it_lasts():
    inputs = SimpleNamespace(ages_s={'cloud_age_s': 4.2, 'odometry_age_s': 0.1}, earlier=0, lost=0)
    inputs.unlocated = inputs.past = inputs.refused = 0
    scans, logged = SimpleNamespace(dropped=2, refused=0, done=7, work_ms=3.5), []
    health = Health(inputs, scans, ROSClock(), NodeLog(SimpleNamespace(warning=logged.append)))
    output, silence = LocalizerOutput(0, Status.NO_PLAN), 'no cloud for 4 s'
    inputs.unlocated = 1
    report = health.report(output, 3.0)
    assert (report.warning, report.values['dropped_scans']) == (silence, 3.0)
    slow = 'scans are dropped: they arrive faster than they can be added'
    unlocated = 'scans are dropped: their poses do not arrive, see the log'
    assert health.news(output, 3.0).warning == f'{slow}, {unlocated}, {silence}'
    assert health.news(output, 3.0).warning == silence
    assert health.news(output, 5.0).warning == ''
    inputs.lost, scans.refused, scans.dropped = 1, 4, 9
    news = health.news(output, 5.0)
    assert 'lost in transport' in news.warning
    assert 'scans are refused' in news.warning
    assert news.values['refused_scans'] == 4.0
    assert [line.partition(';')[0] for line in logged] == [slow, LOST], 'once, with a remedy'


def test_what_keeps_scans_from_coming_is_named_at_any_speed_of_the_clock(monkeypatch):
    at_s, silence_s = 100.0, {'/scan': 0.02, '/tf': 0.01}
    monkeypatch.setattr(health_module.time, 'monotonic', lambda: at_s)
    inputs = SimpleNamespace(ages_s={}, silence_s=silence_s, waits_for='', earlier=0, lost=0)
    inputs.unlocated = inputs.past = inputs.refused = 0
    scans = SimpleNamespace(dropped=0, refused=0, done=7, work_ms=3.5)
    health = Health(inputs, scans, ROSClock(), NodeLog(None))
    health.saw_scan(SECOND_NS)
    at_s += 0.3  # four seconds of a recording that is played fast
    assert health.has_turned(5 * SECOND_NS, 1.0)
    output = LocalizerOutput(0, Status.SEARCHING)
    assert health.report(output, 3.0).reason.endswith('see the log')
    inputs.waits_for = "the pose of 'lidar' in 'base_link' is unknown"
    assert health.report(output, 3.0).reason.endswith(inputs.waits_for)
    silence_s['/scan'] = 0.29
    assert health.report(output, 3.0).reason.endswith('no message on /scan for 0.3 s')


def test_odometry_that_never_came_is_the_reason_for_waiting(monkeypatch):
    at_s = 100.0
    monkeypatch.setattr(health_module.time, 'monotonic', lambda: at_s)
    silence_s = {'/kiss/frame': 0.1, '/kiss/odometry': 2.0}
    inputs = SimpleNamespace(ages_s={}, silence_s=silence_s, waits_for='', earlier=0, lost=0)
    inputs.unlocated = inputs.past = inputs.refused = 0
    scans = SimpleNamespace(dropped=0, refused=0, done=0, work_ms=0.0)
    health = Health(inputs, scans, ROSClock(), NodeLog(None))
    output = LocalizerOutput(0, Status.WAITING, reason='no scan yet')
    assert health.report(output, 3.0).reason == 'no scan yet'
    for at_s in (101.0, 102.0, 103.0, 104.0):
        silence_s['/kiss/odometry'] = at_s - 100.0
        report = health.report(output, 3.0)
    why = 'no message on /kiss/odometry for 4.0 s'
    assert report.reason == f'no scan with a pose has arrived yet: {why}'
    assert (report.status, report.is_trouble) == (Status.WAITING, True)
    assert health.report(LocalizerOutput(0, Status.NO_PLAN), 3.0).status is Status.NO_PLAN


def test_while_the_simulated_clock_stands_still_nothing_else_is_missed(monkeypatch):
    at_s, now_ns = 100.0, 0  # nobody has published the clock yet
    monkeypatch.setattr(health_module.time, 'monotonic', lambda: at_s)
    now = lambda: SimpleNamespace(nanoseconds=now_ns)  # noqa: E731
    silence = ClockSilence(SimpleNamespace(now=now, ros_time_is_active=True))
    at_s = 104.0
    assert silence.age_s == 4.0
    assert silence.without({'cloud': 4.0}) == {'cloud': 0.0}
    for _ in range(5):  # it runs
        at_s, now_ns = at_s + 1.0, now_ns + SECOND_NS
        assert silence.age_s == 0.0
    assert silence.without({'cloud': 4.0}) == {'cloud': 4.0}, 'the cloud is missed'
    at_s += 30.0
    assert silence.age_s == 30.0
    assert silence.without({'cloud': 30.5}) == {'cloud': 0.5}
    at_s, now_ns = at_s + 1.0, now_ns + SECOND_NS
    assert silence.without({'cloud': 31.5}) == {'cloud': 0.0}, 'it runs on only now'
    at_s, now_ns = at_s + 1.0, now_ns + SECOND_NS
    assert silence.without({'cloud': 32.5}) == {'cloud': 1.0}
