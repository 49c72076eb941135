# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What disks, signals and dead neighbours do to a localizer: told once, and nothing is lost.

The test plays odometry and floorplan server for nodes that share two processes.
"""

from collections.abc import Callable
import math
import os
from pathlib import Path
import signal
import subprocess
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from stopwatch import Stopwatch

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2
from fpnet_core.localizer.state import read_state
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import GridMap, Status
from fpnet_lab.nodes.processes import node_command
from fpnet_ros.runtime import LATCHED, STATUS, STREAM
from fpnet_ros.settings import LocalizerParameters
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.poses import uncertain_pose_to_msg

pytestmark = [pytest.mark.ros, pytest.mark.slow]

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 100_000_000
PATIENCE_S = 180.0  # for busy machines
SOON_S = 1.0
PENDING = 30
SCAN_TIMEOUT_S = LocalizerParameters().scan_timeout_s
RELIABLE = 'qos_overrides./kiss/{}.subscription.reliability'


def _two_rooms() -> GridMap:
    cells = np.full((100, 160), 100, dtype=np.int8)
    cells[4:96, 4:80] = 0
    cells[4:96, 84:156] = 0
    cells[40:50, 80:84] = 0
    return GridMap(cells, 0.1, SE2.from_xy_yaw(3.0, -2.0, math.radians(33.0)))


class Robot:
    """A robot in a room: its odometry, its floorplan, and what its localizer says."""

    def __init__(self, bench) -> None:
        self.bench = bench
        node = bench.node
        self._frames = node.create_publisher(PointCloud2, 'kiss/frame', STREAM)
        self._floorplans = node.create_publisher(OccupancyGrid, 'floorplan', LATCHED)
        self._odometry = None
        self.restart_odometry()
        self.words = node.create_publisher(PoseWithCovarianceStamped, 'initialpose', STREAM)
        self.statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
        self.diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
        rays = np.random.default_rng(4).normal(size=(4000, 3))
        walls = np.where(rays > 0.0, (3.5, 2.0, 1.8), (-2.5, -3.0, -0.9))
        self._points = rays * (walls / rays).min(axis=1)[:, None]
        self.index = 0
        self.child = None

    def start(self, log_name: str, parameters: dict, wrapper: list[str] | None = None) -> None:
        self.statuses.clear()
        self.diagnostics.clear()
        common = {
            'localizer.update_period_s': 0.2,
            'max_pending_scans': PENDING,
            RELIABLE.format('frame'): 'reliable',
            RELIABLE.format('odometry'): 'reliable',
        }
        command = [*(wrapper or []), *node_command('localizer')]
        self.child = self.bench.start(log_name, {**common, **parameters}, command=command)
        assert self.bench.wait_for(lambda: bool(self.statuses), PATIENCE_S), self.tail()
        assert self.bench.wait_for(self._is_heard), self.tail()
        if not self.diagnostics:
            self.show()
        assert self.bench.wait_for(lambda: self.says('received the floorplan')), self.tail()

    def restart_odometry(self) -> None:
        node = self.bench.node
        if self._odometry is not None:
            node.destroy_publisher(self._odometry)
        self._odometry = node.create_publisher(Odometry, 'kiss/odometry', STREAM)

    def _is_heard(self) -> bool:
        publishers = self._frames, self._odometry, self.words
        return all(publisher.get_subscription_count() for publisher in publishers)

    def show(self, frame_id: str = 'drawing') -> None:
        self._floorplans.publish(grid_to_msg(_two_rooms(), START_NS, frame_id))

    def take_the_floorplan_away(self) -> None:
        self.bench.node.destroy_publisher(self._floorplans)

    def send(self, frame_id: str = 'lidar', child: str = 'lidar') -> None:
        """One scan further; without a frame nothing comes of the lidar, or of odometry."""
        self.index += 1
        stamp_ns = START_NS + self.index * PERIOD_NS
        if child:
            self._odometry.publish(odometry_to_msg(np.eye(4), stamp_ns, 'odom', child))
        if frame_id:
            self._frames.publish(cloud_to_msg(self._points, stamp_ns, frame_id))

    def send_until(self, condition: Callable[[], bool], timeout_s: float = 60.0) -> bool:
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.send()
            self.bench.wait_for(condition, 0.1)
        return True

    @property
    def report(self):
        return report_from_msg(self.statuses[-1])

    def explored_m2(self) -> float:
        return self.report.values.get('explored_m2', 0.0)

    def says(self, text: str) -> int:
        """Count the lines of the log with a text."""
        return sum(text in line for line in self.child.log.read_text().splitlines())

    def tail(self) -> str:
        return self.child.log_tail()

    def end(self, *signals: int) -> int:
        for number in signals:
            os.kill(self.child.process.pid, number)
            time.sleep(0.05)
        return self.child.process.wait(timeout=60)


@pytest.fixture(scope='module')
def robot(shared_bench):
    return Robot(shared_bench)


@pytest.fixture(scope='module')
def state(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp('robot') / 'state.npz'


def test_a_second_and_third_signal_lose_no_state(robot, state):
    robot.start('first', {'state_file': str(state)})
    assert robot.send_until(lambda: robot.explored_m2() > 20.0), robot.tail()
    assert robot.end(signal.SIGINT, signal.SIGINT, signal.SIGTERM) == 0, robot.tail()
    assert not robot.says('Traceback'), robot.tail()
    assert read_state(state).stamp_ns > START_NS
    assert read_state(state).odometry.split()[1:], 'the run of the odometry'


def test_killed_while_it_saves_it_leaves_a_state_and_goes_on_with_that(robot, state):
    """Odometry has gone on: the submap is the old one. Saving all the time, it is killed."""
    robot.start('killed', {'state_file': str(state), 'autosave_period_s': 0.02})
    assert robot.says('restored the state') == 1
    state.unlink()
    assert robot.send_until(state.exists, 30.0), robot.tail()
    robot.send_until(lambda: False, 1.0)
    assert robot.end(signal.SIGKILL) == -signal.SIGKILL
    assert not robot.says('odometry was restarted'), robot.tail()
    assert not robot.says('it is unknown whether'), robot.tail()
    assert read_state(state).stamp_ns > START_NS


def test_a_restarted_odometry_and_the_saved_submap_never_mix(robot, state):
    before = read_state(state)
    robot.restart_odometry()
    robot.start('mixed', {'state_file': str(state)})
    assert robot.says('restored the state') == 1
    robot.send()
    assert robot.bench.wait_soon(lambda: robot.says('starting a new submap'), SOON_S), robot.tail()
    assert robot.says('odometry was restarted since the state was saved') == 1
    assert robot.send_until(
        lambda: robot.says('odometry was restarted; starting a new submap') == 1
    )
    assert robot.send_until(lambda: robot.explored_m2() > 20.0), robot.tail()
    assert robot.end(signal.SIGINT) == 0
    after = read_state(state)
    assert after.odometry != before.odometry
    assert not robot.says('Traceback')
    assert list(state.parent.iterdir()) == [state], 'what the killed one left is gone'


@pytest.fixture
def small_disks(tmp_path) -> list[str]:
    """Return a command that runs another with a full disk and a read-only one, and no home."""
    namespace = ['unshare', '--map-root-user', '--mount']
    if subprocess.run([*namespace, 'true'], check=False, capture_output=True).returncode:
        pytest.skip('no mount namespaces here')
    (tmp_path / 'full').mkdir()
    (tmp_path / 'fixed').mkdir()
    script = (
        f'mount -t tmpfs -o size=12k tmpfs {tmp_path}/full && '
        f'mount -t tmpfs -o ro tmpfs {tmp_path}/fixed && '
        f'export HOME={tmp_path}/fixed && unset ROS_LOG_DIR ROS_HOME && exec "$@"'
    )
    return [*namespace, 'sh', '-c', script, 'sh']


def test_full_and_read_only_disks_are_told_once_and_stop_nothing(robot, small_disks, tmp_path):
    parameters = {
        'state_file': str(tmp_path / 'full' / 'state.npz'),
        'run_dir': str(tmp_path / 'fixed' / 'run'),
        'autosave_period_s': 0.2,
    }
    robot.start('disks', parameters, small_disks)
    assert robot.send_until(lambda: robot.explored_m2() > 20.0), robot.tail()
    assert robot.bench.wait_for(lambda: robot.says('cannot write') >= 2), robot.tail()
    updates = len(robot.statuses)
    assert robot.send_until(lambda: len(robot.statuses) > updates + 5), 'it goes on'
    response = robot.bench.call(Trigger, 'localizer/save_state')
    assert not response.success
    assert 'No space left on device' in response.message
    assert robot.end(signal.SIGINT) == 0, robot.tail()
    assert robot.says('No space left on device') == 1, robot.tail()
    assert robot.says('parameter run_dir: cannot write') == 1, robot.tail()
    assert robot.says('Read-only file system') == 1
    assert robot.says('set ROS_LOG_DIR to keep them') == 1
    assert not robot.says('Traceback'), robot.tail()


def test_an_unwritable_place_is_told_and_the_rest_is_kept(robot, state):
    """Whoever cannot write the ticks saves the state all the same."""
    state.unlink()
    robot.start('unwritable', {'state_file': str(state), 'run_dir': '/proc/fpnet/run'})
    assert robot.send_until(lambda: robot.explored_m2() > 20.0), robot.tail()
    assert robot.end(signal.SIGTERM) == 0
    assert read_state(state).stamp_ns > START_NS
    assert robot.says('parameter run_dir: cannot write /proc/fpnet/run') == 1, robot.tail()
    assert not robot.says('Traceback'), robot.tail()


@pytest.fixture(scope='module')
def running(robot):
    """One localizer for all that follows."""
    robot.start('running', {})
    assert robot.send_until(lambda: robot.explored_m2() > 20.0), robot.tail()
    return robot


def test_bad_initial_poses_are_told_once_each_and_change_nothing(running):
    here, good = SE2.from_xy_yaw(6.0, 3.0, 0.0), 0.1 * np.eye(3)
    bad = {
        "its frame is 'odom'": uncertain_pose_to_msg(here, good, START_NS, 'odom'),
        'm outside the floorplan': uncertain_pose_to_msg(
            SE2.from_xy_yaw(500.0, 0.0, 0.0), good, START_NS, 'drawing'
        ),
        'covariance of a pose holds NaN': uncertain_pose_to_msg(here, good, START_NS, 'drawing'),
        'quaternion': uncertain_pose_to_msg(here, good, START_NS, 'drawing'),
    }
    bad['covariance of a pose holds NaN'].pose.covariance[0] = math.nan
    bad['quaternion'].pose.pose.orientation.w = 0.0
    bad['quaternion'].pose.pose.orientation.z = 0.0
    for msg in bad.values():
        running.words.publish(msg)
    for text in bad:
        assert running.bench.wait_soon(lambda t=text: running.says(t) == 1, SOON_S), running.tail()
    updates = len(running.statuses)
    assert running.send_until(lambda: len(running.statuses) > updates + 3)
    assert all(running.says(text) == 1 for text in bad)
    assert not running.says('received the initial pose')


LIDAR, ODOMETRY = 'no message on /kiss/frame', 'no message on /kiss/odometry'


@pytest.mark.parametrize(
    ('sent', 'reason'),
    [
        ({'frame_id': ''}, LIDAR),
        ({'child': ''}, ODOMETRY),
        ({'frame_id': '', 'child': ''}, 'no message on /kiss/'),
        ({'frame_id': 'camera'}, "the pose of 'camera' in"),
    ],
    ids=['lidar dead', 'odometry dead', 'both dead', 'wrong frame'],
)
def test_an_input_that_fails_is_waiting_at_once_and_told_once(running, sent, reason):
    """A claim would be as old as the last scan: it ends ``scan_timeout_s`` after that."""
    assert running.send_until(lambda: running.report.status is not Status.WAITING), running.tail()
    told, watch = running.says('no scan with a pose arrives any more'), Stopwatch()
    waiting = lambda: running.report.status is Status.WAITING  # noqa: E731
    while not waiting() and watch.elapsed_s < 10.0:
        running.send(**sent)
        running.bench.wait_for(waiting, PERIOD_NS / NS_PER_S)
    assert watch.elapsed_s < SCAN_TIMEOUT_S + SOON_S
    assert reason in running.report.reason
    assert running.report.warning
    for _ in range(PENDING + 5):  # what waits for a pose that never comes is dropped in the end
        running.send(**sent)
        running.bench.wait_for(lambda: False, 0.05)
    assert waiting()
    assert running.says('no scan with a pose arrives any more') == told + 1, running.tail()
    if sent.get('frame_id') == 'camera':
        assert running.says("the pose of 'camera' in 'lidar' is unknown") == 2, running.tail()
        assert running.says('connects them; the scan was dropped') == 1, running.tail()


def test_a_clock_that_goes_back_is_waiting_within_a_second(running):
    running.index -= 1000
    for _ in range(FpnetConfig().localizer.stale_scans_before_restart + 1):
        running.send()
    assert running.bench.wait_soon(lambda: running.says('the clock went back by') == 1, SOON_S)
    running.statuses.clear()
    assert running.bench.wait_soon(lambda: bool(running.statuses), SOON_S)
    assert running.report.status in (Status.WAITING, Status.SEARCHING, Status.AMBIGUOUS)
    assert running.send_until(lambda: running.explored_m2() > 20.0), running.tail()
    assert running.says('the clock went back by') == 1


def test_a_replaced_floorplan_is_taken_within_a_second(running):
    running.show('other')
    assert running.bench.wait_soon(lambda: running.says('in frame other') == 1, SOON_S)
    updates = len(running.statuses)
    assert running.send_until(lambda: len(running.statuses) > updates + 1)
    assert running.report.status is not Status.NO_PLAN


def test_without_its_server_the_floorplan_stays_and_diagnostics_say_so(running):
    running.take_the_floorplan_away()
    running.diagnostics.clear()

    def told() -> bool:
        statuses = [status for msg in running.diagnostics for status in msg.status]
        return any('/floorplan' in status.message for status in statuses)

    assert running.bench.wait_soon(told, 3.0), running.tail()
    assert running.says('topic missing (/floorplan)') == 1
    updates = len(running.statuses)
    assert running.send_until(lambda: len(running.statuses) > updates + 3)
    assert running.report.status is not Status.NO_PLAN
    assert running.says('topic missing (/floorplan)') == 1
