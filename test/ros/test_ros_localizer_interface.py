# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Everything a robot may ask of the localizer, of one that has found itself.

It runs in a namespace, under another name, with remapped input and simulated time: the test
drives through the planted building, and is the clock.
"""

import os
import signal
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nav_msgs.msg import OccupancyGrid, Odometry, Path
import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import drive, recorded
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Empty, Trigger
from visualization_msgs.msg import MarkerArray

from fpnet_core.geometry import SE2, angle_between
from fpnet_core.types import GridMap, Status
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_from_msg, grid_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.poses import pose_from_msg, uncertain_pose_from_msg, uncertain_pose_to_msg
from msg_adapters.stamps import stamp_to_msg
from msg_adapters.transforms import transform_from_msg

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = [pytest.mark.ros, pytest.mark.slow]

NAMESPACE = '/robot_1'
NODE = f'{NAMESPACE}/finder'
TOLERANCE_S = 0.3
TOLERANCE_NS = 300_000_000  # stamps are too long for floats
START_NS = 1_700_000_000_000_000_000
STEP_NS = 200_000_000
PATIENCE_S = 240.0  # for busy machines; a quiet one needs seconds


class Robot:
    """Publishes clock, scans and odometry of the drive, to and fro."""

    def __init__(self, bench, state_file) -> None:
        self.bench = bench
        self.state_file = state_file
        node = bench.node
        self._clock = node.create_publisher(Clock, '/clock', 10)
        self._clouds = node.create_publisher(PointCloud2, f'{NAMESPACE}/registered', STREAM)
        self._floorplans = node.create_publisher(OccupancyGrid, f'{NAMESPACE}/floorplan', LATCHED)
        self.initial_pose = node.create_publisher(
            PoseWithCovarianceStamped, f'{NAMESPACE}/initialpose', STREAM
        )
        self.restart_odometry()
        topics = {
            'statuses': (DiagnosticStatus, f'{NODE}/status', STATUS),
            'diagnostics': (DiagnosticArray, '/diagnostics', STREAM),
            'poses': (PoseStamped, f'{NAMESPACE}/floorplan_pose', STREAM),
            'twins': (
                PoseWithCovarianceStamped,
                f'{NAMESPACE}/floorplan_pose_with_covariance',
                STREAM,
            ),
            'paths': (Path, f'{NAMESPACE}/floorplan_path', LATCHED),
            'markers': (MarkerArray, f'{NODE}/markers', LATCHED),
            'submaps': (OccupancyGrid, f'{NODE}/submap', LATCHED),
            'scaled': (OccupancyGrid, f'{NODE}/floorplan_scaled', LATCHED),
            'tfs': (tf2_msgs.TFMessage, '/tf', TF),
        }
        for name, topic in topics.items():
            setattr(self, name, bench.collect(*topic))
        self.tf_heard_s: list[float] = []
        node.create_subscription(
            tf2_msgs.TFMessage, '/tf', lambda _: self.tf_heard_s.append(time.monotonic()), TF
        )
        self.index = 0
        self.offset_ns = START_NS
        self.child = None
        self.start()

    def start(self) -> None:
        reliable = f'qos_overrides.{NAMESPACE}/{{}}.subscription.reliability'
        self.child = self.bench.start(
            'localizer',
            {
                'use_sim_time': True,
                'transform_tolerance': TOLERANCE_S,
                'max_pending_scans': 50,
                'state_file': str(self.state_file),
                'autosave_period_s': 1.0,
                'scan_timeout_s': 5.0,  # longer than a test lets the clock run without a scan
                'localizer.tick_period_s': 0.4,
                reliable.format('registered'): 'reliable',
                reliable.format('kiss/odometry'): 'reliable',
            },
            {
                '__ns': NAMESPACE,
                '__node': 'finder',
                'kiss/frame': 'registered',
            },
        )

    def restart_odometry(self) -> None:
        node = self.bench.node
        if hasattr(self, '_odometry'):
            node.destroy_publisher(self._odometry)
        self._odometry = node.create_publisher(Odometry, f'{NAMESPACE}/kiss/odometry', STREAM)
        self.T_new_old = np.eye(4)

    def is_heard(self) -> bool:
        publishers = (self._clouds, self._odometry, self._clock, self._floorplans)
        return all(publisher.get_subscription_count() for publisher in publishers)

    def show(self, grid: GridMap, frame_id: str) -> None:
        self._floorplans.publish(grid_to_msg(grid, self.now_ns, frame_id))

    @property
    def now_ns(self) -> int:
        return self.offset_ns + self.index * STEP_NS

    def position(self, stamp_ns: int) -> int:
        """Index into the drive at a time: to and fro, so that odometry never jumps."""
        last = len(drive()) - 1
        return last - abs(last - (stamp_ns - self.offset_ns) // STEP_NS % (2 * last))

    def truth(self, stamp_ns: int) -> SE2:
        """Pose on the drawing at a time."""
        x, y, yaw = drive()[self.position(stamp_ns)]
        T_plan_building = A_BUILDING_PLAN.inv()
        at = T_plan_building.apply((x, y))
        return SE2.from_xy_yaw(*at, T_plan_building.apply_yaw(yaw))

    def step(self) -> None:
        """One scan further, and one tick of the clock."""
        self.index += 1
        points, T_odom_sensor, _ = recorded()[self.position(self.now_ns)]
        T_odom_sensor = self.T_new_old @ T_odom_sensor
        self._clock.publish(Clock(clock=stamp_to_msg(self.now_ns)))
        self._odometry.publish(odometry_to_msg(T_odom_sensor, self.now_ns, 'odom', 'lidar'))
        self._clouds.publish(cloud_to_msg(points, self.now_ns, 'lidar'))

    def step_until(self, condition, timeout_s=PATIENCE_S) -> bool:
        """Go on, at a pace that a busy machine keeps up with, until the condition holds."""
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.step()
            self.bench.wait_for(condition, 0.15)
        return True

    @property
    def status(self) -> Status | None:
        return report_from_msg(self.statuses[-1]).status if self.statuses else None

    def is_localized(self) -> bool:
        return self.status is Status.LOCALIZED

    def localize(self) -> None:
        assert self.step_until(self.is_localized), (self.statuses[-1:], self.child.log_tail())
        for messages in (self.poses, self.twins, self.tfs, self.diagnostics):
            messages.clear()
        assert self.step_until(lambda: self.poses and self.twins and self.tfs)

    def logs(self, text: str) -> bool:
        return self.bench.wait_for(lambda: text in self.child.log.read_text(), PATIENCE_S)

    def change_state(self, transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return self.bench.call(ChangeState, f'{NODE}/change_state', request).success

    def state(self) -> str:
        return self.bench.call(GetState, f'{NODE}/get_state').current_state.label

    def set(self, name: str, value):
        request = SetParameters.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg()]
        )
        (result,) = self.bench.call(SetParameters, f'{NODE}/set_parameters', request).results
        return result


@pytest.fixture(scope='module')
def robot(shared_bench, tmp_path_factory):
    robot = Robot(shared_bench, tmp_path_factory.mktemp('state') / 'state.npz')
    assert shared_bench.wait_for(robot.is_heard, 300.0), robot.child.log_tail()
    robot.show(plan_grid(), 'drawing')
    assert robot.logs('took the floorplan'), robot.child.log_tail()
    return robot


@pytest.fixture(autouse=True)
def _localized(robot):
    robot.localize()
    return robot


def test_the_pose_is_right_on_the_drawing(robot):
    pose = pose_from_msg(robot.poses[-1])
    assert pose.frame_id == 'drawing'
    truth = robot.truth(pose.stamp_ns)
    assert np.linalg.norm(pose.T_frame_body.translation - truth.translation) < 0.5
    assert angle_between(pose.T_frame_body.yaw, truth.yaw) < np.deg2rad(4.0)


def test_tf_and_the_twin_with_covariance_agree_in_the_map_frame(robot):
    twin = uncertain_pose_from_msg(robot.twins[-1])
    assert twin.pose.frame_id == 'map'
    assert (np.linalg.eigvalsh(twin.cov) >= 0.0).all()
    assert 0.0 < twin.cov[0, 0] < 1.0
    (msg,) = robot.tfs[-1].transforms
    tf = transform_from_msg(msg)
    assert (tf.parent, tf.child) == ('map', 'odom')
    _, T_odom_lidar, _ = recorded()[robot.position(twin.pose.stamp_ns)]
    T_map_lidar = SE2.from_matrix4(tf.T_parent_child) @ SE2.from_matrix4(T_odom_lidar)
    np.testing.assert_allclose(T_map_lidar.matrix, twin.pose.T_frame_body.matrix, atol=0.1)
    assert tf.stamp_ns - robot.now_ns <= TOLERANCE_NS


def test_tf_is_repeated_quickly_for_a_time_to_come(robot):
    """The clock runs finely; the transform follows at its own pace, never twice for one time."""
    robot.tfs.clear()
    robot.tf_heard_s.clear()
    began_ns, ran_ns = robot.now_ns, 0
    started_s = time.monotonic()
    while time.monotonic() - started_s < 3.0:
        ran_ns = round((time.monotonic() - started_s) * 1e9)
        robot._clock.publish(Clock(clock=stamp_to_msg(began_ns + ran_ns)))
        robot.bench.wait_for(lambda: False, 0.01)
    robot.offset_ns += ran_ns
    stamps = [transform_from_msg(msg.transforms[0]).stamp_ns for msg in robot.tfs]
    assert len(stamps) > 3.0 * 10, 'half of the rate, for busy machines'
    assert (np.diff(stamps) > 0).all()
    assert stamps[0] >= began_ns + TOLERANCE_NS
    assert stamps[-1] <= began_ns + ran_ns + TOLERANCE_NS


def test_what_it_has_seen_and_thinks_is_drawn(robot):
    done = lambda: robot.markers and robot.submaps and robot.paths and robot.scaled  # noqa: E731
    assert robot.step_until(done)
    frames = {marker.ns: marker.header.frame_id for marker in robot.markers[-1].markers[1:]}
    assert frames['plan_rooms'] == frames['plan_doors'] == frames['hypotheses'] == 'map'
    assert frames['submap_rooms'] == 'odom'
    assert robot.paths[-1].header.frame_id == 'drawing'
    assert len(robot.paths[-1].poses) >= 1
    assert robot.submaps[-1].header.frame_id == 'odom'
    assert grid_from_msg(robot.submaps[-1]).cells.size > 1000
    assert robot.scaled[-1].header.frame_id == 'map'
    # The robot stands in free space, both on the drawing and on the one at its true scale.
    at = uncertain_pose_from_msg(robot.twins[-1]).pose.T_frame_body.translation
    grid = grid_from_msg(robot.scaled[-1])
    assert grid.cells[tuple(np.rint(grid.xy_to_rc(at)).astype(int))] == 0


def test_diagnostics_say_how_it_fares(robot):
    def reports():
        statuses = [s for msg in robot.diagnostics for s in msg.status]
        return [s for s in statuses if s.name == f'{NODE}: localization']

    assert robot.step_until(lambda: len(reports()) > 1)
    report = report_from_msg(reports()[-1])
    assert report.status is Status.LOCALIZED
    assert report.probability > 0.5
    assert report.values['scale'] == pytest.approx(1.0, abs=0.05)
    assert report.values['cloud_age_s'] < 30.0
    for key in ('odometry_age_s', 'total_ms', 'scan_ms', 'dropped_scans', 'explored_m2'):
        assert report.values[key] >= 0.0


def test_an_initial_pose_in_an_unknown_frame_is_rejected(robot):
    for frame_id in ('odom', 'drawing'):
        here = robot.truth(robot.now_ns)
        msg = uncertain_pose_to_msg(here, 0.1 * np.eye(3), robot.now_ns, frame_id)
        robot.initial_pose.publish(msg)
    assert robot.logs(
        "initialpose was rejected: it is in frame 'odom', expected 'map' or 'drawing'"
    )
    assert robot.logs('took the initial pose')


@pytest.mark.parametrize(
    ('kind', 'name'),
    [
        (Trigger, f'{NODE}/relocalize'),
        (Empty, f'{NAMESPACE}/reinitialize_global_localization'),
        (Trigger, f'{NODE}/reset'),
    ],
)
def test_it_can_be_told_to_look_again(robot, kind, name):
    response = robot.bench.call(kind, name)
    assert response is not None
    if kind is Trigger:
        assert response.success
    seen = len(robot.statuses)
    assert robot.step_until(lambda: len(robot.statuses) > seen + 1)
    told = [report_from_msg(msg).status for msg in robot.statuses[seen:]]
    assert any(status is not Status.LOCALIZED for status in told)


def test_a_tick_comes_on_request(robot):
    seen = len(robot.statuses)
    assert robot.bench.call(Empty, f'{NAMESPACE}/request_nomotion_update') is not None
    # The clock stands still, so that no timer has asked for it.
    assert robot.bench.wait_for(lambda: len(robot.statuses) > seen, PATIENCE_S)


def test_parameters_change_where_that_is_safe_and_are_refused_with_a_reason(robot):
    assert robot.set('tf_broadcast', False).successful
    robot.bench.wait_for(lambda: False, 0.5)
    robot.tfs.clear()
    for _ in range(5):
        robot.step()
        robot.bench.wait_for(lambda: False, 0.1)
    assert robot.tfs == []
    assert robot.set('tf_broadcast', True).successful
    assert robot.step_until(lambda: bool(robot.tfs))
    refused = robot.set('submap.resolution_m', 0.1)
    assert not refused.successful
    assert 'submap.resolution_m is read when the node is configured' in refused.reason
    assert not robot.set('transform_tolerance', -1.0).successful
    assert robot.set('localizer.tick_period_s', 0.5).successful


def test_a_restarted_odometry_costs_the_submap_but_not_the_place(robot):
    robot.restart_odometry()
    robot.T_new_old = SE2.from_xy_yaw(3.0, -40.0, 1.0).as_matrix4()
    assert robot.bench.wait_for(robot.is_heard, PATIENCE_S)
    robot.step()
    assert robot.logs('another process publishes the odometry now')
    robot.localize()
    pose = pose_from_msg(robot.poses[-1])
    truth = robot.truth(pose.stamp_ns)
    assert np.linalg.norm(pose.T_frame_body.translation - truth.translation) < 0.6


def test_a_clock_that_goes_back_starts_anew(robot):
    robot.offset_ns -= 3600 * 10**9
    assert robot.step_until(lambda: 'the clock went back' in robot.child.log.read_text())
    robot.localize()


def test_a_floorplan_is_replaced_at_run_time(robot):
    moved = SE2.from_xy_yaw(100.0, 0.0, 0.0)
    grid = plan_grid()
    robot.show(GridMap(grid.cells, grid.resolution, moved @ grid.T_frame_grid), 'moved')
    assert robot.logs('took the floorplan in frame moved')
    robot.localize()
    assert robot.step_until(lambda: robot.poses[-1].header.frame_id == 'moved')
    robot.show(grid, 'drawing')
    assert robot.step_until(
        lambda: robot.child.log.read_text().count('took the floorplan in frame drawing') > 1
    )


def test_the_lifecycle_is_that_of_a_managed_node(robot):
    assert robot.state() == 'active'
    assert robot.change_state(Transition.TRANSITION_DEACTIVATE)
    for messages in (robot.poses, robot.tfs):
        messages.clear()
    for _ in range(10):
        robot.step()
        robot.bench.wait_for(lambda: False, 0.05)
    assert robot.poses == []
    assert robot.tfs == []
    assert robot.change_state(Transition.TRANSITION_CLEANUP)
    assert robot.state() == 'unconfigured'
    refused = robot.bench.call(Trigger, f'{NODE}/save_state')
    assert 'not configured' in refused.message
    assert robot.set('matcher.weights', '/absent/matcher.safetensors').successful
    assert not robot.change_state(Transition.TRANSITION_CONFIGURE)
    assert robot.state() == 'unconfigured'
    assert '/absent/matcher' in robot.child.log.read_text()
    assert robot.set('matcher.weights', '').successful
    assert robot.change_state(Transition.TRANSITION_CONFIGURE)
    assert robot.change_state(Transition.TRANSITION_ACTIVATE)
    assert robot.state() == 'active'


def test_the_state_is_saved_on_request_beside_everything_else(robot):
    robot.state_file.unlink(missing_ok=True)
    client = robot.bench.node.create_client(Trigger, f'{NODE}/save_state')
    assert robot.bench.wait_for(client.service_is_ready, PATIENCE_S)
    robot.bench.call(Empty, f'{NAMESPACE}/request_nomotion_update')  # a tick, to wait behind
    saved = client.call_async(Trigger.Request())
    assert robot.state() == 'active', 'other services answer meanwhile'
    assert robot.bench.wait_for(saved.done, PATIENCE_S)
    assert saved.result().success, saved.result().message
    assert robot.state_file.exists()


def test_killed_and_started_again_it_goes_on_where_it_was(robot):
    robot.state_file.unlink(missing_ok=True)
    assert robot.step_until(robot.state_file.exists), 'it saves by itself'
    os.kill(robot.child.process.pid, signal.SIGKILL)
    robot.child.process.wait(timeout=30)
    robot.statuses.clear()
    robot.start()
    assert robot.logs('restored the state'), robot.child.log_tail()
    assert robot.bench.wait_for(lambda: bool(robot.statuses), PATIENCE_S)
    explored = []
    assert robot.step_until(
        lambda: (
            bool(explored)
            or explored.extend(
                r.values['explored_m2']
                for r in map(report_from_msg, robot.statuses)
                if 'explored_m2' in r.values
            )
        )
    )
    assert explored[0] > 30.0
    robot.localize()
    assert 'Traceback' not in robot.child.log.read_text()
