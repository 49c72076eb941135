# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localizer alone, the test playing everyone else: what it makes of bad input."""

from array import array
import math

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2

from fpnet_core.geometry import SE2
from fpnet_core.io.runs import read_output
from fpnet_core.types import GridMap, Status
from fpnet_ros.runtime import LATCHED, STATUS, STREAM
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.stamps import stamp_to_msg

pytestmark = pytest.mark.ros

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 100_000_000
SWEEP_POINTS, LARGE_POINTS = 4000, 300_000


def _two_rooms() -> GridMap:
    cells = np.full((100, 160), 100, dtype=np.int8)
    cells[4:96, 4:80] = 0
    cells[4:96, 84:156] = 0
    cells[40:50, 80:84] = 0
    return GridMap(cells, 0.1, SE2.from_xy_yaw(3.0, -2.0, math.radians(33.0)))


def _room_sweep(rng: np.random.Generator) -> np.ndarray:
    """Return (P, 3) returns from a room of 6 m x 5 m, the sensor 0.9 m above its floor."""
    rays = rng.normal(size=(SWEEP_POINTS, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    walls = np.where(rays > 0.0, (3.5, 2.0, 1.8), (-2.5, -3.0, -0.9))
    return rays * (walls / rays).min(axis=1)[:, None]


class _Robot:
    """Publishes what odometry would."""

    def __init__(self, bench) -> None:
        self._bench = bench
        self._frames = bench.node.create_publisher(PointCloud2, 'kiss/frame', STREAM)
        self._odometry = bench.node.create_publisher(Odometry, 'kiss/odometry', STREAM)
        self._rng = np.random.default_rng(4)
        self._large: PointCloud2 | None = None

    def is_heard(self) -> bool:
        return bool(
            self._frames.get_subscription_count() and self._odometry.get_subscription_count()
        )

    def send(self, index: int, change_frame=None, change_odometry=None) -> None:
        self.send_frame(index, change_frame)
        self.send_odometry(index, change_odometry)

    def send_frame(self, index: int, change=None) -> None:
        frame = cloud_to_msg(_room_sweep(self._rng), START_NS + index * PERIOD_NS, 'lidar')
        if change:
            change(frame)
        self._frames.publish(frame)

    def send_odometry(self, index: int, change=None) -> None:
        stamp_ns = START_NS + index * PERIOD_NS
        odometry = odometry_to_msg(np.eye(4), stamp_ns, 'odom_lidar', 'lidar')
        if change:
            change(odometry)
        self._odometry.publish(odometry)

    def send_large(self, index: int) -> None:
        """A cloud of 300,000 points; packed once, as a driver has it ready."""
        if self._large is None:
            points = np.tile(_room_sweep(self._rng), (LARGE_POINTS // SWEEP_POINTS, 1))
            points += self._rng.normal(scale=0.02, size=points.shape)
            self._large = cloud_to_msg(points.astype(np.float32), 0, 'lidar')
        self._large.header.stamp = stamp_to_msg(START_NS + index * PERIOD_NS)
        self._frames.publish(self._large)
        self.send_odometry(index)


def test_bad_input_is_named_once_and_nothing_is_lost(bench, tmp_path):
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
    reliable = 'qos_overrides./kiss/{}.subscription.reliability'
    node = bench.start(
        'localizer',
        {
            'run_dir': str(tmp_path / 'run'),
            'localizer.update_period_s': 0.2,
            'max_pending_scans': 30,
            reliable.format('frame'): 'reliable',
            reliable.format('odometry'): 'reliable',
        },
    )
    floorplans = bench.node.create_publisher(OccupancyGrid, 'floorplan', LATCHED)
    robot = _Robot(bench)

    def last():
        return report_from_msg(statuses[-1]) if statuses else None

    def logs(text: str) -> bool:
        return text in node.log.read_text()

    assert bench.wait_for(lambda: last() is not None, 180.0), node.log_tail()
    assert last().status is Status.NO_PLAN

    short = grid_to_msg(_two_rooms(), START_NS, 'drawing')
    short.data = array('b', short.data[:-1])
    floorplans.publish(short)
    assert bench.wait_for(lambda: logs('grid data has 15999 cells')), node.log_tail()
    assert last().status is Status.NO_PLAN

    floorplans.publish(grid_to_msg(_two_rooms(), START_NS, 'drawing'))
    assert bench.wait_for(lambda: last().status is Status.WAITING), node.log_tail()

    assert bench.wait_for(robot.is_heard), node.log_tail()
    for index in range(10):
        robot.send(index)
    assert bench.wait_for(lambda: last().values.get('explored_m2', 0.0) > 20.0), last()
    explored_m2 = last().values['explored_m2']

    robot.send(10, change_frame=lambda m: setattr(m, 'point_step', 8))
    robot.send(12, change_odometry=lambda m: setattr(m.pose.pose.orientation, 'w', math.nan))
    robot.send(2)
    unknown = GridMap(np.full((20, 20), -1, dtype=np.int8), 0.1)
    floorplans.publish(grid_to_msg(unknown, START_NS, 'drawing'))
    assert bench.wait_for(lambda: logs('point_step')), node.log_tail()
    assert bench.wait_for(lambda: logs('no room')), node.log_tail()

    seen = len(statuses)
    robot.send(13)
    assert bench.wait_for(lambda: len(statuses) > seen + 3), node.log_tail()
    assert node.process.poll() is None
    assert last().status not in (Status.NO_PLAN, Status.WAITING, Status.LOST)
    assert last().values['explored_m2'] >= 0.9 * explored_m2
    assert all(msg.header.frame_id == 'drawing' for msg in poses)
    assert 'Traceback' not in node.log.read_text()

    bench.group.stop()
    assert node.process.returncode == 0
    submap = read_output(tmp_path / 'run' / 'last_tick.npz').submap
    assert submap is not None
    assert submap.stamp_ns == START_NS + 13 * PERIOD_NS


def test_scans_without_odometry_are_dropped_and_named_and_late_odometry_is_welcome(bench):
    diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
    reliable = 'qos_overrides./kiss/{}.subscription.reliability'
    node = bench.start(
        'localizer',
        {
            'localizer.update_period_s': 0.2,
            'max_pending_scans': 5,
            'stale_input_s': 1.0,
            reliable.format('frame'): 'reliable',
            reliable.format('odometry'): 'reliable',
        },
    )
    robot = _Robot(bench)

    def reports():
        return [report_from_msg(msg.status[0]) for msg in diagnostics]

    def last(name: str) -> float:
        return reports()[-1].values[name] if diagnostics else math.nan

    assert bench.wait_for(lambda: bool(diagnostics) and robot.is_heard(), 180.0), node.log_tail()
    for index in range(12):
        robot.send_frame(index)
        bench.wait_for(lambda: False, 0.02)
    assert bench.wait_for(lambda: last('dropped_scans') == 7), node.log_tail()
    assert 'no odometry received for scans' in node.log.read_text()
    assert bench.wait_for(lambda: 'no odometry for' in reports()[-1].warning), reports()[-1]
    assert any('scans are dropped' in report.warning for report in reports())
    assert last('scans') == 0
    # The five that wait are used as soon as odometry tells where they were.
    for index in range(7, 12):
        robot.send_odometry(index)
    assert bench.wait_for(lambda: last('scans') == 5), node.log_tail()
    assert last('dropped_scans') == 7
    assert last('lost_scans') == 0


def test_more_than_fits_is_dropped_with_a_diagnostic_and_the_newest_is_served(bench):
    diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    limit, burst = 1, 60
    node = bench.start('localizer', {'localizer.update_period_s': 0.2, 'max_pending_scans': limit})
    floorplans = bench.node.create_publisher(OccupancyGrid, 'floorplan', LATCHED)
    floorplans.publish(grid_to_msg(_two_rooms(), START_NS, 'drawing'))
    robot = _Robot(bench)
    took = lambda: 'received the floorplan' in node.log.read_text()  # noqa: E731
    ready = lambda: took() and robot.is_heard() and bool(statuses)  # noqa: E731
    assert bench.wait_for(ready, 180.0), node.log_tail()

    def reports():
        return [report_from_msg(msg.status[0]) for msg in diagnostics]

    for index in range(burst):  # as fast as they can be sent: no machine keeps up
        robot.send_large(index)
    newest_ns = START_NS + burst * PERIOD_NS
    served = lambda: report_from_msg(statuses[-1]).stamp_ns >= newest_ns  # noqa: E731
    # What waits in the node and before it, and a tick: not everything that was sent. The robot
    # goes on sending, since clouds come by best effort and any one may be lost on the way.
    for sent in range(burst, burst + 30):
        robot.send(sent)
        if bench.wait_for(served, 2.0):
            break
    assert served(), (report_from_msg(statuses[-1]), node.log_tail())
    counted = lambda: reports() and reports()[-1].values['scans'] > 0  # noqa: E731
    assert bench.wait_for(counted)
    last = reports()[-1].values
    assert 0 < last['scans'] < sent
    unused = last['dropped_scans'] + last['lost_scans']
    assert unused > 0
    assert last['scans'] + unused <= sent + 1  # what was lost before the first, nobody can count
    warned = [report.warning for report in reports() if report.warning.startswith('scans are')]
    assert warned, 'a drop goes with a warning'
    assert node.process.poll() is None


def test_a_simulated_clock_that_nobody_publishes_is_named(bench):
    """No timer of the node's own clock ever fires: what it says comes all the same."""
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    diagnostics = bench.collect(DiagnosticArray, '/diagnostics', STREAM)
    node = bench.start('localizer', {'use_sim_time': True})
    said = lambda: any('no /clock for' in msg.message for msg in statuses)  # noqa: E731
    assert bench.wait_for(said, 180.0), node.log_tail()
    assert 'no cloud' not in statuses[-1].message, 'nothing is expected of the others meanwhile'
    doctor = lambda: [s.message for msg in diagnostics for s in msg.status][-1:]  # noqa: E731
    found = lambda: 'use_sim_time is true' in ''.join(doctor())  # noqa: E731
    assert bench.wait_for(found, 60.0), node.log_tail()
    log = node.log.read_text()
    assert 'next: set use_sim_time: false on a robot' in log
    assert 'no message on /clock for' in log


def test_bad_weights_and_parameters_end_the_node_with_one_line(bench, tmp_path):
    cases = {
        'weights': ({'matcher.weights': str(tmp_path / 'absent.safetensors')}, 'absent'),
        'range': ({'submap.resolution_m': 5.0}, 'submap.resolution_m'),
        'type': ({'localizer.update_period_s': 'often'}, 'localizer.update_period_s'),
    }
    started = {
        name: bench.start_as(name, 'localizer', parameters)
        for name, (parameters, _) in cases.items()
    }
    for name, (_, message) in cases.items():
        assert started[name].process.wait(timeout=180) == 1
        lines = started[name].log_tail().splitlines()
        assert len(lines) == 1, lines
        assert message in lines[0]
