# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Load the localizer node as a robot does, and more: is a scan lost, does TF falter, does it grow?

Run: python benchmarks/node_load.py [--minutes 10] [--points 25000] [--json OUT]

The node runs in a process of its own. This one drives a simulated tour to and fro with exact
odometry, in real time at 10 Hz, and notes what comes back. Then clouds of 300,000 points follow
for half a minute: more than fits, so that the node must drop, say so, and stay up to date.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
import json
import os
from pathlib import Path
import tempfile
import time

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
from rcl_interfaces.srv import GetParameters
import rclpy
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

from fpnet_core.sim.recording import make_recording
from fpnet_ros.processes import (
    Child,
    ProcessGroup,
    free_domain_id,
    node_command,
    private_environment,
    ros_arguments,
)
from fpnet_ros.runtime import LATCHED, STREAM, TF
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import LocalizerReport, report_from_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.stamps import stamp_to_msg

PERIOD_S = 0.1
SCANS = 400
MADE_POINTS = 10_000_000  # in all clouds of a phase
OVERLOAD_POINTS, OVERLOAD_S = 300_000, 30.0
CALL_PERIOD_S, MEMORY_PERIOD_S = 0.2, 5.0
READY_S = 600.0
PAGE_MIB = os.sysconf('SC_PAGE_SIZE') / 2**20


@dataclass
class Heard:
    """What came back in one phase."""

    sent: int = 0
    late_ms: list[float] = field(default_factory=list)  # of this process against its schedule
    tf_s: list[float] = field(default_factory=list)
    call_ms: list[float] = field(default_factory=list)
    memory_mib: list[float] = field(default_factory=list)
    reports: list[LocalizerReport] = field(default_factory=list)
    behind_s: list[float] = field(default_factory=list)


class Load:
    """Publishes scans on schedule, calls a service, and listens."""

    def __init__(self, child: Child) -> None:
        self.node = rclpy.create_node('load')
        self._child = child
        self._clouds = self.node.create_publisher(PointCloud2, 'kiss/frame', STREAM)
        self._odometry = self.node.create_publisher(Odometry, 'kiss/odometry', STREAM)
        self._floorplans = self.node.create_publisher(OccupancyGrid, 'floorplan', LATCHED)
        self._client = self.node.create_client(GetParameters, 'localizer/get_parameters')
        self.node.create_subscription(TFMessage, '/tf', self._on_tf, TF)
        self.node.create_subscription(
            DiagnosticArray, '/diagnostics', self._on_diagnostics, STREAM
        )
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._recording = make_recording(0)
        self._poses = self._recording.truth()[:SCANS]
        self._clouds_made: list[PointCloud2] = []
        self._begin = self._index = self._at = 0
        self.heard = Heard()

    def wait_until_ready(self) -> None:
        """Publish the floorplan; return when the localizer has taken it."""
        self._floorplans.publish(grid_to_msg(self._recording.floorplan, 0, 'drawing'))
        deadline = time.monotonic() + READY_S
        while 'took the floorplan' not in self._child.log_tail():
            if time.monotonic() > deadline or self._child.process.poll() is not None:
                raise SystemExit(f'the localizer is not ready: {self._child.log_tail()}')
            self._executor.spin_once(timeout_sec=0.1)

    def load(self, points: int) -> None:
        """Make clouds of the tour from where the robot is, with noise and of the wanted size."""
        rng = np.random.default_rng(0)
        self._clouds_made, self._index = [], 0
        count = min(SCANS, MADE_POINTS // points)
        self._begin = max(0, min(self._at, SCANS - count))
        self._index = self._at - self._begin
        for index in range(self._begin, self._begin + count):
            cloud = self._recording.scan(index).points
            chosen = cloud[rng.integers(len(cloud), size=points)]
            noisy = chosen + rng.normal(scale=0.01, size=chosen.shape)
            self._clouds_made.append(cloud_to_msg(noisy.astype(np.float32), 0, 'lidar'))

    def run(self, seconds: float) -> Heard:
        """Publish for a while; returns what was heard."""
        self.heard = Heard()
        started_s = time.monotonic()
        call_s = memory_s = started_s
        for count in range(round(seconds / PERIOD_S)):
            due_s = started_s + count * PERIOD_S
            while (left_s := due_s - time.monotonic()) > 0.0:
                self._executor.spin_once(timeout_sec=min(left_s, 0.01))
                if time.monotonic() >= call_s:
                    call_s += CALL_PERIOD_S
                    self._call()
            if time.monotonic() >= memory_s:
                memory_s += MEMORY_PERIOD_S
                self.heard.memory_mib.append(self._resident_mib())
            self.heard.late_ms.append(1e3 * (time.monotonic() - due_s))
            self._send()
        return self.heard

    def _send(self) -> None:
        # To and fro: the odometry never jumps.
        last = len(self._clouds_made) - 1
        position = last - abs(last - self._index % (2 * last))
        self._index += 1
        self._at = self._begin + position
        stamp_ns = time.time_ns()
        pose = self._poses[self._at]
        self._odometry.publish(odometry_to_msg(pose, stamp_ns, 'odom', 'lidar'))
        cloud = self._clouds_made[position]
        cloud.header.stamp = stamp_to_msg(stamp_ns)
        self._clouds.publish(cloud)
        self.heard.sent += 1

    def _call(self) -> None:
        began_s = time.monotonic()
        heard = self.heard
        future = self._client.call_async(GetParameters.Request(names=['map_frame']))
        future.add_done_callback(
            lambda _: heard.call_ms.append(1e3 * (time.monotonic() - began_s))
        )

    def _on_tf(self, _: TFMessage) -> None:
        self.heard.tf_s.append(time.monotonic())

    def _on_diagnostics(self, msg: DiagnosticArray) -> None:
        for status in msg.status:
            report = report_from_msg(status)
            self.heard.reports.append(report)
            self.heard.behind_s.append((time.time_ns() - report.stamp_ns) / 1e9)

    def _resident_mib(self) -> float:
        pages = Path(f'/proc/{self._child.process.pid}/statm').read_text().split()[1]
        return int(pages) * PAGE_MIB


def summarize(heard: Heard) -> dict[str, float | str]:
    """Return the figures of a phase; times in ms unless named otherwise."""
    gaps_ms = 1e3 * np.diff(heard.tf_s) if len(heard.tf_s) > 1 else np.array([np.nan])
    memory = np.array(heard.memory_mib)
    half = len(memory) // 2
    first, last = heard.reports[0].values, heard.reports[-1].values
    ticks_ms = [r.values['total_ms'] for r in heard.reports if 'total_ms' in r.values]
    calls_ms = heard.call_ms or [np.nan]
    return {
        'scans_sent': heard.sent,
        'scans_dropped': last['dropped_scans'] - first['dropped_scans'],
        'warned': sum('dropped' in r.warning for r in heard.reports),
        'status': heard.reports[-1].status.value,
        'tf_messages': len(heard.tf_s),
        'tf_gap_p99': float(np.percentile(gaps_ms, 99)),
        'tf_gap_max': float(gaps_ms.max()),
        'call_p50': float(np.percentile(calls_ms, 50)),
        'call_p99': float(np.percentile(calls_ms, 99)),
        'tick_p50': float(np.median(ticks_ms)) if ticks_ms else float('nan'),
        'tick_max': float(np.max(ticks_ms)) if ticks_ms else float('nan'),
        'behind_max_s': float(np.max(heard.behind_s[len(heard.behind_s) // 4 :])),
        'memory_mib': float(memory[-1]),
        'memory_growth_second_half_percent': 100.0 * float(memory[-1] / memory[half] - 1.0),
        'publisher_late_p99': float(np.percentile(heard.late_ms, 99)),
    }


def main() -> None:
    """Print the figures of both phases."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=10.0)
    parser.add_argument('--points', type=int, default=25_000)
    parser.add_argument('--json', type=Path)
    arguments = parser.parse_args()
    environment = private_environment(free_domain_id())
    os.environ.update(environment)
    with tempfile.TemporaryDirectory() as folder, ProcessGroup(Path(folder), environment) as group:
        child = group.start('localizer', [*node_command('localizer'), *ros_arguments()])
        rclpy.init()
        load = Load(child)
        load.wait_until_ready()
        phases = {}
        for points, seconds in (
            (arguments.points, 60.0 * arguments.minutes),
            (OVERLOAD_POINTS, OVERLOAD_S),
        ):
            load.load(points)
            phases[f'{points} points'] = summarize(load.run(seconds))
        rclpy.shutdown()
    for name, figures in phases.items():
        print(name)
        for key, value in figures.items():
            print(f'  {key:36s}{value if isinstance(value, str) else f"{value:.1f}"}')
    if arguments.json:
        arguments.json.write_text(json.dumps(phases, indent=1), encoding='utf-8')


if __name__ == '__main__':
    main()
