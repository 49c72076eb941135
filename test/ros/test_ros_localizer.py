# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localizer alone, the test playing everyone else: what it makes of bad input."""

from array import array
import math

from diagnostic_msgs.msg import DiagnosticStatus
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

pytestmark = pytest.mark.ros

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 100_000_000


def _two_rooms() -> GridMap:
    cells = np.full((100, 160), 100, dtype=np.int8)
    cells[4:96, 4:80] = 0
    cells[4:96, 84:156] = 0
    cells[40:50, 80:84] = 0
    return GridMap(cells, 0.1, SE2.from_xy_yaw(3.0, -2.0, math.radians(33.0)))


def _room_sweep(rng: np.random.Generator) -> np.ndarray:
    """Return (4000, 3) returns from a room of 6 m x 5 m, the sensor 0.9 m above its floor."""
    rays = rng.normal(size=(4000, 3))
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

    def is_heard(self) -> bool:
        return bool(
            self._frames.get_subscription_count() and self._odometry.get_subscription_count()
        )

    def send(self, index: int, change_frame=None, change_odometry=None) -> None:
        stamp_ns = START_NS + index * PERIOD_NS
        frame = cloud_to_msg(_room_sweep(self._rng), stamp_ns, 'lidar')
        odometry = odometry_to_msg(np.eye(4), stamp_ns, 'odom_lidar', 'lidar')
        if change_frame:
            change_frame(frame)
        if change_odometry:
            change_odometry(odometry)
        self._frames.publish(frame)
        self._odometry.publish(odometry)


def test_bad_input_is_named_once_and_nothing_is_lost(bench, tmp_path):
    statuses = bench.collect(DiagnosticStatus, 'localizer/status', STATUS)
    poses = bench.collect(PoseStamped, 'floorplan_pose', STREAM)
    reliable = 'qos_overrides./kiss/{}.subscription.reliability'
    node = bench.start(
        'localizer',
        {
            'run_dir': str(tmp_path / 'run'),
            'localizer.tick_period_s': 0.2,
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


def test_bad_weights_and_parameters_end_the_node_with_one_line(bench, tmp_path):
    cases = {
        'weights': ({'matcher.weights': str(tmp_path / 'absent.safetensors')}, 'absent'),
        'range': ({'submap.resolution_m': 5.0}, 'submap.resolution_m'),
        'type': ({'localizer.tick_period_s': 'often'}, 'localizer.tick_period_s'),
    }
    started = {
        name: bench.start_as(name, 'localizer', parameters)
        for name, (parameters, _) in cases.items()
    }
    for name, (_, message) in cases.items():
        assert started[name].process.wait(timeout=90) == 1
        lines = started[name].log_tail().splitlines()
        assert len(lines) == 1, lines
        assert message in lines[0]
