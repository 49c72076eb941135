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

from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseWithCovarianceStamped
from lifecycle_msgs.msg import Transition
import numpy as np
from planted import plan_grid
from planted_drive import recorded
import pytest
from rclpy.action import ActionClient
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Empty, Trigger

from fpnet_core.geometry import SE2, angle_between
from fpnet_core.types import GridMap, Status
from fpnet_ros.runtime import LATCHED, STREAM
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_from_msg
from msg_adapters.poses import pose_from_msg, uncertain_pose_from_msg, uncertain_pose_to_msg
from msg_adapters.stamps import stamp_to_msg
from msg_adapters.transforms import transform_from_msg

pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

from driven_robot import (
    NAMESPACE,
    NODE,
    PATIENCE_S,
    STEP_NS,
    TOLERANCE_NS,
    Robot,
)

pytestmark = [pytest.mark.ros, pytest.mark.slow]


@pytest.fixture(scope='module')
def robot(shared_bench, tmp_path_factory):
    robot = Robot(shared_bench, tmp_path_factory.mktemp('state') / 'state.npz')
    assert shared_bench.wait_for(robot.is_heard, 300.0), robot.child.log_tail()
    robot.show(plan_grid(), 'drawing')
    assert robot.logs('received the floorplan'), robot.child.log_tail()
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


def test_before_it_has_a_pose_it_says_where_to_look_next(robot):
    reports = [report_from_msg(msg) for msg in robot.statuses]
    told = [report for report in reports if report.look]
    assert told
    assert all(report.status is not Status.LOCALIZED for report in told)
    assert all(report.look.startswith('drive ') for report in told)
    ways = [m for array in robot.markers for m in array.markers if m.ns == 'next_look']
    assert ways
    assert {way.header.frame_id for way in ways} == {'odom'}
    assert not any(marker.ns == 'next_look' for marker in robot.markers[-1].markers)
    goal, way = pose_from_msg(robot.goals[-1]), ways[-1]
    assert goal.frame_id == 'odom'
    end = way.points[-1]
    np.testing.assert_allclose(goal.T_frame_body.translation, (end.x, end.y), atol=1e-6)


def test_without_scans_it_sends_nobody_anywhere(robot):
    """The last look was made where the robot was when it still saw something."""
    robot.bench.call(Trigger, f'{NODE}/reset')
    robot.goals.clear()
    assert robot.step_until(lambda: robot.goals), robot.child.log_tail()
    for _ in range(30):
        robot.offset_ns += STEP_NS
        robot._clock.publish(Clock(clock=stamp_to_msg(robot.now_ns)))
        if robot.bench.wait_for(lambda: robot.status is Status.WAITING, 0.3):
            break
    assert robot.status is Status.WAITING
    robot.goals.clear()
    for _ in range(8):
        robot.offset_ns += STEP_NS
        robot._clock.publish(Clock(clock=stamp_to_msg(robot.now_ns)))
        robot.bench.wait_for(lambda: False, 0.3)
    assert not robot.goals
    assert not report_from_msg(robot.statuses[-1]).look


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
    assert robot.logs("initialpose was rejected: its frame is 'odom', expected 'map' or 'drawing'")
    assert robot.logs('received the initial pose')


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
    assert f'ros2 lifecycle set {NODE} deactivate' in refused.reason
    assert not robot.set('transform_tolerance', -1.0).successful
    assert robot.set('localizer.update_period_s', 0.5).successful
    misspelt = robot.set('localizer.accept_probabilty', 0.9)
    assert not misspelt.successful
    assert 'did you mean localizer.accept_probability?' in misspelt.reason


def test_thresholds_change_with_the_next_tick(robot):
    assert robot.set('localizer.min_explored_m2', 1e6).successful
    withheld = lambda: robot.status is Status.WAITING  # noqa: E731
    assert robot.step_until(withheld), robot.statuses[-1:]
    assert 'of 1000000 m² of floor observed so far' in robot.statuses[-1].message
    assert robot.set('localizer.min_explored_m2', 12.0).successful
    robot.localize()


def test_whoever_comes_late_hears_the_last_pose(robot):
    late = robot.bench.collect(
        PoseWithCovarianceStamped, f'{NAMESPACE}/floorplan_pose_with_covariance', LATCHED
    )
    is_last = lambda: bool(late) and late[-1].header == robot.twins[-1].header  # noqa: E731
    assert robot.bench.wait_for(is_last, PATIENCE_S)


class Goal:
    """A goal of ``~/localize``, as a behaviour tree sends it."""

    def __init__(self, robot, timeout_s=0, anew=False) -> None:
        action = pytest.importorskip('fpnet_msgs.action').Localize
        self.robot, self.feedback = robot, []
        self.codes = action.Result
        client = ActionClient(robot.bench.node, action, f'{NODE}/localize')
        assert robot.bench.wait_for(client.server_is_ready, PATIENCE_S)
        sent = client.send_goal_async(
            action.Goal(timeout=Duration(sec=timeout_s), anew=anew),
            lambda msg: self.feedback.append(msg.feedback),
        )
        assert robot.bench.wait_for(sent.done, PATIENCE_S)
        self.handle = sent.result()
        self._result = self.handle.get_result_async() if self.handle.accepted else None

    def is_done(self) -> bool:
        return self._result.done()

    @property
    def status(self) -> int:
        return self._result.result().status

    @property
    def result(self):
        return self._result.result().result


def test_the_action_ends_at_once_where_the_robot_is_known(robot):
    goal = Goal(robot)
    assert robot.bench.wait_for(goal.is_done, PATIENCE_S)
    assert (goal.status, goal.result.error_code) == (GoalStatus.STATUS_SUCCEEDED, goal.codes.NONE)
    found, twin = uncertain_pose_from_msg(goal.result.pose), robot.twins[-1]
    assert goal.result.pose.header == twin.header
    np.testing.assert_allclose(found.cov, uncertain_pose_from_msg(twin).cov)


def test_the_action_looks_anew_and_says_how_it_goes(robot):
    goal = Goal(robot, anew=True)
    assert robot.bench.wait_for(lambda: goal.feedback, PATIENCE_S)
    assert robot.step_until(goal.is_done), goal.feedback[-1:]
    assert goal.status == GoalStatus.STATUS_SUCCEEDED
    first = goal.feedback[0]
    assert (first.status, first.reason) == ('waiting', 'waiting for the first update')
    assert first.next
    assert len({msg.reason for msg in goal.feedback}) > 1
    pose = uncertain_pose_from_msg(goal.result.pose).pose
    truth = robot.truth(pose.stamp_ns)
    assert np.linalg.norm(pose.T_frame_body.translation - truth.translation) < 0.5


def test_the_action_can_be_cancelled_and_ends_in_time(robot):
    """The clock stands still meanwhile: nothing is found."""
    goals = [Goal(robot, anew=True), Goal(robot, timeout_s=1)]
    assert robot.bench.wait_for(goals[1].is_done, PATIENCE_S)
    assert goals[1].status == GoalStatus.STATUS_ABORTED
    assert goals[1].result.error_code == goals[1].codes.TIMEOUT
    assert 'not localized in time: waiting' in goals[1].result.error_msg
    assert not goals[0].is_done(), 'each has a time of its own'
    goals[0].handle.cancel_goal_async()
    assert robot.bench.wait_for(goals[0].is_done, PATIENCE_S)
    assert goals[0].status == GoalStatus.STATUS_CANCELED
    assert goals[0].result.error_code == goals[0].codes.CANCELED


@pytest.mark.parametrize('name', [f'{NODE}/set_initial_pose', f'{NAMESPACE}/set_initial_pose'])
def test_a_service_takes_an_initial_pose_as_amcl_s_does(robot, name):
    kind = pytest.importorskip('nav2_msgs.srv').SetInitialPose
    took = robot.child.log.read_text().count('received the initial pose')
    here = robot.truth(robot.now_ns)
    msg = uncertain_pose_to_msg(here, 0.1 * np.eye(3), robot.now_ns, 'drawing')
    assert robot.bench.call(kind, name, kind.Request(pose=msg)) is not None
    count = lambda: robot.child.log.read_text().count('received the initial pose')  # noqa: E731
    assert robot.bench.wait_for(lambda: count() == took + 1, PATIENCE_S)
    msg.header.frame_id = 'odom'
    robot.bench.call(kind, name, kind.Request(pose=msg))
    assert robot.logs("set_initial_pose was rejected: its frame is 'odom'")


def test_a_floorplan_is_replaced_at_run_time(robot):
    moved = SE2.from_xy_yaw(100.0, 0.0, 0.0)
    grid = plan_grid()
    robot.show(GridMap(grid.cells, grid.resolution, moved @ grid.T_frame_grid), 'moved')
    assert robot.logs('received the floorplan in frame moved')
    robot.localize()
    assert robot.step_until(lambda: robot.poses[-1].header.frame_id == 'moved')
    robot.show(grid, 'drawing')
    assert robot.step_until(
        lambda: robot.child.log.read_text().count('received the floorplan in frame drawing') > 1
    )


def test_the_lifecycle_is_that_of_a_managed_node(robot):
    assert robot.state() == 'active'
    robot.bench.call(Trigger, f'{NODE}/relocalize')
    goal = Goal(robot)
    assert robot.change_state(Transition.TRANSITION_DEACTIVATE)
    assert robot.bench.wait_for(goal.is_done, PATIENCE_S)
    assert goal.status == GoalStatus.STATUS_ABORTED
    assert goal.result.error_code == goal.codes.INACTIVE
    assert not Goal(robot).handle.accepted
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


def _end(robot) -> None:
    robot.child.process.terminate()
    robot.child.process.wait(timeout=60)
    gone = lambda: not robot.bench.node.count_services(f'{NODE}/get_state')  # noqa: E731
    assert robot.bench.wait_for(gone, 60.0)
    robot.statuses.clear()


def test_a_lifecycle_manager_starts_it_and_amcl_goes_on_from_where_it_is_found(robot):
    """As Nav2's manager does: transitions, then a bond; AMCL has its names to itself."""
    beats = robot.bench.collect(
        pytest.importorskip('bond.msg').Status, f'{NAMESPACE}/bond', STREAM
    )
    told = robot.bench.collect(PoseWithCovarianceStamped, f'{NAMESPACE}/initialpose', STREAM)
    _end(robot)
    here = robot.truth(robot.now_ns)
    robot.start(
        {
            'autostart': False,
            'state_file': '',
            'map_frame': 'drawing',
            'hand_over': True,
            'set_initial_pose': True,
            'initial_pose.x': here.x,
            'initial_pose.y': here.y,
            'initial_pose.yaw': here.yaw,
        }
    )
    # What answers is the new one: the bond is of nodes that somebody else starts.
    heard = lambda: robot.bench.node.count_publishers(f'{NAMESPACE}/bond') > 0  # noqa: E731
    assert robot.bench.wait_for(heard, PATIENCE_S), robot.child.log_tail()
    assert robot.state() == 'unconfigured'
    assert beats == []
    assert robot.change_state(Transition.TRANSITION_CONFIGURE)
    assert robot.change_state(Transition.TRANSITION_ACTIVATE)
    assert robot.bench.wait_soon(lambda: len(beats) > 4, 2.0), 'half of bond_timeout'
    assert {(msg.id, msg.active) for msg in beats} == {('finder', True)}
    assert len({msg.instance_id for msg in beats}) == 1
    robot.tfs.clear()
    seeder = robot.bench.start(
        'seeder',
        {'use_sim_time': True, 'map_frame': 'drawing'},
        {'__ns': NAMESPACE, 'localizer/status': f'{NODE}/status'},
    )
    assert robot.step_until(lambda: bool(told)), seeder.log_tail()
    assert robot.child.log.read_text().count('received the initial pose') == 1
    robot.step_until(lambda: len(robot.twins) > 20)
    assert len(told) == 1, 'one that kept coming would scatter the particles'
    assert robot.step_until(robot.is_localized)
    assert robot.bench.call(Trigger, f'{NAMESPACE}/seeder/seed').success
    assert robot.bench.wait_for(lambda: len(told) > 1), seeder.log_tail()
    pose = uncertain_pose_from_msg(told[1]).pose
    assert pose.frame_id == 'drawing'
    truth = robot.truth(pose.stamp_ns)
    assert np.linalg.norm(pose.T_frame_body.translation - truth.translation) < 0.5
    assert robot.tfs == []
    servers = robot.bench.node.count_services
    assert servers(f'{NODE}/relocalize') > 0
    amcl = ('reinitialize_global_localization', 'request_nomotion_update', 'set_initial_pose')
    assert not any(servers(f'{NAMESPACE}/{name}') for name in amcl)
    assert robot.change_state(Transition.TRANSITION_DEACTIVATE)
    assert robot.bench.wait_for(lambda: not beats[-1].active)
    count = len(beats)
    robot.bench.wait_for(lambda: False, 1.0)
    assert len(beats) == count
    assert 'Traceback' not in robot.child.log.read_text()
    _end(robot)
    robot.start()


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
