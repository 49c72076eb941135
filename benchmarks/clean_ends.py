#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Test of clean node shutdown on two SIGINTs 0.2 ms apart, as sent by a launch file in a terminal.

Run: python benchmarks/clean_ends.py [--launches 50] [--seed 0] [--json OUT]

Each launch starts localizer, odometry and floorplan server. Half of the launches end while the
localizer processes scans and has a state to save, the others 0.2 to 3 s after the start. A
shutdown is clean if every node exits with 0, or by the signal before its own code runs, writes no
traceback, and leaves a readable state if there was one. Exits 1 if a shutdown is not clean.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import os
from pathlib import Path
import signal
import sys
import tempfile
import time

from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import PointCloud2

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.io.maps import write_map
from fpnet_core.io.topic_names import KISS_FRAME, KISS_ODOMETRY
from fpnet_core.localizer.state import read_state
from fpnet_core.types import GridMap
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.nodes.processes import (
    Child,
    ProcessGroup,
    free_domain_id,
    node_command,
    private_environment,
    ros_arguments,
)
from fpnet_ros.runtime import STATUS, STREAM
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.odometry import odometry_to_msg

NODES = ('localizer', 'odometry', 'floorplan_server')
APART_S = 0.0002
STARTING_S = 0.2, 3.0  # Python itself needs the first 0.2 s
SEEN_M2 = 20.0
READY_S, END_S, PERIOD_S = 120.0, 30.0, 0.1


@dataclass(frozen=True)
class End:
    """Shutdown of one launch: its time after the start [s], its duration [s], and faults."""

    is_running: bool
    after_s: float
    took_s: float
    faults: list[str]


class Room:
    """Publisher of scans of a robot standing in a room, and listener to its localizer."""

    def __init__(self) -> None:
        rclpy.init()
        self.node = rclpy.create_node('room')
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._frames = self.node.create_publisher(PointCloud2, KISS_FRAME, STREAM)
        self._odometry = self.node.create_publisher(Odometry, KISS_ODOMETRY, STREAM)
        self.node.create_subscription(DiagnosticStatus, 'localizer/status', self._note, STATUS)
        self.explored_m2 = 0.0
        rays = np.random.default_rng(4).normal(size=(4000, 3))
        walls = np.where(rays > 0.0, (3.5, 2.0, 1.8), (-2.5, -3.0, -0.9))
        self._points = rays * (walls / rays).min(axis=1)[:, None]

    def _note(self, message: DiagnosticStatus) -> None:
        self.explored_m2 = report_from_msg(message).values.get('explored_m2', 0.0)

    def show_until(self, is_done: Callable[[], bool], timeout_s: float) -> bool:
        """Publish scans until a condition holds or time is out; return the condition."""
        end_s, next_s = time.monotonic() + timeout_s, 0.0
        while not is_done() and time.monotonic() < end_s:
            if time.monotonic() >= next_s:
                next_s = time.monotonic() + PERIOD_S
                stamp_ns = time.time_ns()
                self._odometry.publish(odometry_to_msg(np.eye(4), stamp_ns, 'odom', 'lidar'))
                self._frames.publish(cloud_to_msg(self._points, stamp_ns, 'lidar'))
            self._executor.spin_once(timeout_sec=0.02)
        return is_done()


def two_rooms() -> GridMap:
    """Return a floorplan with two rooms and a door between them."""
    cells = np.full((100, 160), 100, dtype=np.int8)
    cells[4:96, 4:80] = 0
    cells[4:96, 84:156] = 0
    cells[40:50, 80:84] = 0
    return GridMap(cells, 0.1, SE2.from_xy_yaw(3.0, -2.0, 0.5))


def started(group: ProcessGroup, folder: Path) -> list[Child]:
    """Start the nodes of one robot."""
    parameters = {
        'localizer': {'state_file': str(folder / 'state.npz')},
        'odometry': {},
        'floorplan_server': {'floorplan': str(folder / 'plan.yaml')},
    }
    # This process publishes frame and odometry; the node's are remapped.
    aside = {'odometry': {KISS_FRAME: 'aside/frame', KISS_ODOMETRY: 'aside/odometry'}}
    return [
        group.start(
            name, [*node_command(name), *ros_arguments(parameters[name], aside.get(name, {}))]
        )
        for name in NODES
    ]


def faults_of(child: Child, folder: Path, is_running: bool) -> list[str]:
    """Return the faults of a node's shutdown."""
    found = []
    text = child.log.read_text(encoding='utf-8', errors='replace')
    is_own = 'Traceback' in text or is_running or child.process.poll() != -signal.SIGINT
    if child.process.poll() is None:
        found.append(f'{child.name} is still running')
        child.process.kill()
    elif child.process.poll() != 0 and is_own:
        found.append(f'{child.name} exits with {child.process.poll()}')
    if 'Traceback' in text:
        found.append(f'{child.name}: {text.strip().splitlines()[-1]}')
    if child.name == 'localizer' and is_running:
        try:
            read_state(folder / 'state.npz')
        except (FpnetError, OSError) as error:
            found.append(f'state: {error}')
    return found


def launch(room: Room, folder: Path, after_s: float | None) -> End:
    """Start the nodes and end them after ``after_s``, or None: once there is a state to save."""
    folder.mkdir()
    write_map(two_rooms(), folder / 'plan.yaml')
    room.explored_m2, began_s = 0.0, time.monotonic()
    with ProcessGroup(folder / 'logs', dict(os.environ)) as group:
        children = started(group, folder)
        if after_s is None:
            if not room.show_until(lambda: room.explored_m2 > SEEN_M2, READY_S):
                raise FpnetError(f'the localizer got no scans:\n{children[0].log_tail()}')
        else:
            time.sleep(after_s)
        sent_s = time.monotonic()
        for _ in range(2):
            for child in children:
                os.kill(child.process.pid, signal.SIGINT)
            time.sleep(APART_S)
        for child in children:
            end_s = sent_s + END_S
            while child.process.poll() is None and time.monotonic() < end_s:
                time.sleep(0.01)
        took_s = time.monotonic() - sent_s
        found = [f for child in children for f in faults_of(child, folder, after_s is None)]
    return End(after_s is None, sent_s - began_s, took_s, found)


def sums(ends: list[End]) -> dict[str, float | int | list[str]]:
    """Return the totals of launches of one kind."""
    return {
        'launches': len(ends),
        'clean': sum(not end.faults for end in ends),
        'took_s_median': float(np.median([end.took_s for end in ends])),
        'took_s_max': max(end.took_s for end in ends),
        'faults': sorted({fault for end in ends for fault in end.faults}),
    }


def main() -> None:
    """Run all launches; exit with 1 if a shutdown is not clean."""
    parser = script_parser(__doc__)
    parser.add_argument('--launches', type=int, default=50)
    parser.add_argument('--seed', type=int, default=0)
    arguments = parser.parse_args()
    os.environ.update(private_environment(free_domain_id()))
    rng, room, ends = np.random.default_rng(arguments.seed), Room(), []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(arguments.launches):
            after_s = None if number % 2 else float(rng.uniform(*STARTING_S))
            end = launch(room, Path(folder) / str(number), after_s)
            print(f'{number}: after {end.after_s:.2f} s, ended in {end.took_s:.2f} s', *end.faults)
            ends.append(end)
    when = {
        kind: sums([end for end in ends if end.is_running is is_running])
        for kind, is_running in (('running', True), ('starting', False))
    }
    finish('clean_ends', arguments.json, {'when': when})
    sys.exit(any(end.faults for end in ends))


if __name__ == '__main__':
    main()
