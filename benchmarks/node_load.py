# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Load test of the localizer node: lost scans, TF jitter, service latency and memory growth.

Run: python benchmarks/node_load.py [--minutes 10] [--points 25000] [--kiss] [--json OUT]

The node runs in its own process. This process publishes a simulated tour back and forth with exact
odometry, in real time at 10 Hz, and records the node's outputs. Then clouds of 300,000 points
follow for 30 s: if that is too much, the node must drop scans, report it, and stay up to date.
With --kiss, KISS-ICP runs as odometry in another process and receives the clouds, without the
overload phase. On two processors only: taskset -c 0,1 python benchmarks/node_load.py --kiss
Prints every figure and target; exits 1 if a target is missed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import os
from pathlib import Path
import sys
import tempfile
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
import numpy as np
from rcl_interfaces.srv import GetParameters
import rclpy
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

from fpnet_core.io.topic_names import KISS_FRAME, KISS_ODOMETRY, TF_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_lab.cli.reports import script_parser, write_report
from fpnet_lab.nodes.processes import (
    Child,
    ProcessGroup,
    free_domain_id,
    node_command,
    private_environment,
    ros_arguments,
)
from fpnet_lab.scores import Score, Table, Unit, Units
from fpnet_lab.sim.drives.recording import make_recording
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.diagnostics import LocalizerReport, report_from_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.stamps import stamp_from_msg, stamp_to_msg

PERIOD_S = 0.1
SCANS = 400
MADE_POINTS = 10_000_000  # total points of all clouds of a phase
OVERLOAD_POINTS, OVERLOAD_S = 300_000, 30.0
CALL_PERIOD_S, MEMORY_PERIOD_S = 0.2, 5.0
READY_S, DRAIN_S = 600.0, 5.0
PAGE_MIB = os.sysconf('SC_PAGE_SIZE') / 2**20
TF_PERIOD_MS, TF_AHEAD_NS = 40.0, 500_000_000  # default rate and post-dating

MOST_LOST_PERCENT = 0.1  # of the sent scans
MOST_JITTER_MS, MOST_CALL_MS = 50.0, 50.0
MOST_GROWTH_PERCENT = 5.0
MOST_BEHIND_S = 2.0  # age of the newest pose: a queue of ten scans, 0.2 s each


@dataclass
class Heard:
    """Outputs of the nodes recorded in one phase."""

    sent: int = 0
    late_ms: list[float] = field(default_factory=list)  # delay of this process behind its schedule
    tf_ns: list[int] = field(default_factory=list)  # broadcast times by the node's clock
    call_ms: list[float] = field(default_factory=list)
    memory_mib: list[float] = field(default_factory=list)
    reports: list[LocalizerReport] = field(default_factory=list)  # from /diagnostics
    odometry: list[dict[str, float]] = field(default_factory=list)  # from KISS-ICP's diagnostics
    updates: list[LocalizerReport] = field(default_factory=list)
    unlocalized_ns: list[int] = field(default_factory=list)
    behind_s: list[float] = field(default_factory=list)


class Load:
    """Publisher of scans on schedule that calls a service and records outputs."""

    def __init__(self, child: Child, with_kiss: bool) -> None:
        self.node = rclpy.create_node('load')
        self._child = child
        create = self.node.create_publisher
        self._clouds = create(PointCloud2, 'points' if with_kiss else KISS_FRAME, STREAM)
        self._odometry = None if with_kiss else create(Odometry, KISS_ODOMETRY, STREAM)
        self._floorplans = self.node.create_publisher(OccupancyGrid, 'floorplan', LATCHED)
        self._client = self.node.create_client(GetParameters, 'localizer/get_parameters')
        self.node.create_subscription(TFMessage, TF_TOPIC, self._on_tf, TF)
        self.node.create_subscription(
            DiagnosticArray, '/diagnostics', self._on_diagnostics, STREAM
        )
        self.node.create_subscription(
            DiagnosticStatus, 'localizer/status', self._on_update, STATUS
        )
        self.node.create_subscription(PoseStamped, 'floorplan_pose', self._on_pose, STREAM)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._recording = make_recording(0)
        self._poses = self._recording.truth()[:SCANS]
        self._clouds_made: list[PointCloud2] = []
        self._begin = self._index = self._at = 0
        self.heard = Heard()

    def wait_until_ready(self) -> None:
        """Publish the floorplan; return when the localizer has it and all topics are connected."""
        self._floorplans.publish(grid_to_msg(self._recording.floorplan, 0, 'drawing'))
        deadline = time.monotonic() + READY_S
        while (
            'received the floorplan' not in self._child.log_tail()
            or not self._clouds.get_subscription_count()
            or not self.node.count_publishers(KISS_ODOMETRY)
        ):
            if time.monotonic() > deadline or self._child.process.poll() is not None:
                raise SystemExit(f'the localizer is not ready: {self._child.log_tail()}')
            self._executor.spin_once(timeout_sec=0.1)

    def load(self, points: int) -> None:
        """Create noisy clouds of ``points`` points along the tour, from the robot's position."""
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
        """Publish for ``seconds``, let the node catch up, and return the recorded outputs."""
        self.heard = Heard()
        self._spin(2.0)  # for a report before the first scan
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
        self._spin(DRAIN_S)
        return self.heard

    def _spin(self, seconds: float) -> None:
        deadline = time.monotonic() + seconds
        while (left_s := deadline - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left_s)

    def _send(self) -> None:
        # Back and forth, so that odometry never jumps.
        last = len(self._clouds_made) - 1
        position = last - abs(last - self._index % (2 * last))
        self._index += 1
        self._at = self._begin + position
        stamp_ns = time.time_ns()
        pose = self._poses[self._at]
        if self._odometry is not None:
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

    def _on_tf(self, msg: TFMessage) -> None:
        header = msg.transforms[0].header
        if header.frame_id == 'map':  # the others are from odometry
            self.heard.tf_ns.append(stamp_from_msg(header.stamp) - TF_AHEAD_NS)

    def _on_pose(self, msg: PoseStamped) -> None:
        self.heard.behind_s.append((time.time_ns() - stamp_from_msg(msg.header.stamp)) / NS_PER_S)

    def _on_update(self, msg: DiagnosticStatus) -> None:
        report = report_from_msg(msg)
        self.heard.updates.append(report)
        if report.status is not Status.LOCALIZED:
            self.heard.unlocalized_ns.append(time.time_ns())

    def _on_diagnostics(self, msg: DiagnosticArray) -> None:
        status = msg.status[0]
        if status.name == '/localizer: localization':
            self.heard.reports.append(report_from_msg(status))
        else:
            self.heard.odometry.append({each.key: float(each.value) for each in status.values})

    def _resident_mib(self) -> float:
        pages = Path(f'/proc/{self._child.process.pid}/statm').read_text().split()[1]
        return int(pages) * PAGE_MIB


def tf_jitter_ms(heard: Heard) -> np.ndarray:
    """Return the deviation of each TF period [ms] while the status is ``localized``."""
    stamps = np.array(heard.tf_ns)
    if len(stamps) < 2:
        return np.array([np.nan])
    claimed = np.ones(len(stamps) - 1, dtype=bool)
    after = np.searchsorted(stamps, heard.unlocalized_ns)
    claimed[np.clip(after - 1, 0, len(claimed) - 1)] = False
    return np.abs(np.diff(stamps)[claimed] / 1e6 - TF_PERIOD_MS)


def summarize(heard: Heard) -> dict[str, float | str]:
    """Return the statistics of a phase; times in ms unless named otherwise."""
    jitter_ms = tf_jitter_ms(heard)
    memory = np.array(heard.memory_mib)
    tenth = max(1, len(memory) // 10)
    middle, end = memory[len(memory) // 2 :][:tenth].mean(), memory[-tenth:].mean()
    first, last = heard.reports[0].values, heard.reports[-1].values
    ticks_ms = [
        update.values['total_ms'] for update in heard.updates if 'total_ms' in update.values
    ]
    lost = heard.sent - (last['scans'] - first['scans'])
    dropped = last['dropped_scans'] - first['dropped_scans']
    warned = sum('dropped' in report.warning for report in heard.reports)
    register_ms = [values['register_ms'] for values in heard.odometry]
    kiss = heard.odometry[-1] if heard.odometry else {}
    return {
        **{f'kiss_{key}': kiss[key] for key in ('dropped_scans', 'lost_scans') if key in kiss},
        **({'kiss_register_p50': float(np.median(register_ms))} if register_ms else {}),
        'scans_sent': heard.sent,
        'scans_lost': lost,
        'scans_lost_percent': 100.0 * lost / heard.sent,
        'scans_dropped_by_node': dropped,
        'warnings_of_drops': warned,
        'drops_without_warning': float(dropped > 0 and not warned),
        'status_at_end': heard.updates[-1].status.value if heard.updates else 'unknown',
        'ticks_not_localized': len(heard.unlocalized_ns),
        'tf_messages': len(heard.tf_ns),
        'tf_jitter_p99': float(np.percentile(jitter_ms, 99)),
        'tf_jitter_max': float(jitter_ms.max()),
        'call_p50': float(np.median(heard.call_ms or [np.nan])),
        'call_p99': float(np.percentile(heard.call_ms or [np.nan], 99)),
        'tick_p50': float(np.median(ticks_ms or [np.nan])),
        'tick_p99': float(np.percentile(ticks_ms or [np.nan], 99)),
        'tick_max': float(np.max(ticks_ms or [np.nan])),
        'pose_behind_p50_s': float(np.median(heard.behind_s or [np.nan])),
        'pose_behind_max_s': float(np.max(heard.behind_s or [np.nan])),
        'memory_mib': float(end),
        'memory_growth_second_half_percent': 100.0 * float(end / middle - 1.0),
        'publisher_late_p99': float(np.percentile(heard.late_ms, 99)),
    }


def assess(
    steady: str, overload: str | None, phases: dict[str, dict[str, float | str]]
) -> list[tuple[str, Score]]:
    """Return each target's phase and measured value; an unknown value misses its target."""
    ms, seconds, percent = Units.MS.to(2), Units.SECONDS.to(2), Unit(' %', 2)
    limits: tuple[tuple[str | None, str, Unit, float], ...] = (
        (steady, 'scans_lost_percent', percent, MOST_LOST_PERCENT),
        (steady, 'tf_jitter_max', ms, MOST_JITTER_MS),
        (steady, 'call_p99', ms, MOST_CALL_MS),
        (steady, 'memory_growth_second_half_percent', percent, MOST_GROWTH_PERCENT),
        (overload, 'drops_without_warning', Units.COUNT, 0.0),
        (overload, 'pose_behind_max_s', seconds, MOST_BEHIND_S),
    )
    return [
        (phase, Score(figure, float(phases[phase][figure]), unit, most))
        for phase, figure, unit, most in limits
        if phase is not None
    ]


def measure(
    points: int, minutes: float, with_kiss: bool
) -> tuple[list[tuple[str, Score]], dict[str, Any]]:
    """Run the phases with a separate node process."""
    environment = private_environment(free_domain_id())
    os.environ.update(environment)
    runs = [(points, 60.0 * minutes)]
    runs += [] if with_kiss else [(OVERLOAD_POINTS, OVERLOAD_S)]
    names = [f'{count} points' for count, _ in runs]
    phases = {}
    with tempfile.TemporaryDirectory() as folder, ProcessGroup(Path(folder), environment) as group:
        child = group.start('localizer', [*node_command('localizer'), *ros_arguments()])
        if with_kiss:
            remapped = ros_arguments(remappings={'pointcloud_topic': 'points'})
            group.start('odometry', [*node_command('odometry'), *remapped])
        rclpy.init()
        load = Load(child, with_kiss)
        load.wait_until_ready()
        for name, (count, seconds) in zip(names, runs, strict=True):
            load.load(count)
            phases[name] = summarize(load.run(seconds))
        rclpy.shutdown()
    targets = assess(names[0], None if with_kiss else names[1], phases)
    results = {
        'minutes': minutes,
        'with_kiss': with_kiss,
        'processors': len(os.sched_getaffinity(0)),
        'targets': [
            {'phase': phase, 'figure': s.name, 'value': s.value, 'most': s.aim, 'is_met': s.is_met}
            for phase, s in targets
        ],
        'phases': phases,
    }
    return targets, results


def main() -> int:
    """Print the statistics of all phases and the targets; return the exit status."""
    parser = script_parser(__doc__)
    parser.add_argument('--minutes', type=float, default=10.0)
    parser.add_argument('--points', type=int, default=25_000)
    parser.add_argument('--kiss', action='store_true', help='run KISS-ICP as odometry')
    arguments = parser.parse_args()
    targets, results = measure(arguments.points, arguments.minutes, arguments.kiss)
    for name, figures in results['phases'].items():
        table = [(Score(name, key), Score('', figures[key], Units.NUMBER)) for key in figures]
        print(f'{Table.of_scores(table).markdown()}\n')
    table = [
        (
            Score('target', f'{phase}: {t.name}'),
            Score('measured', str(t)),
            Score('aim', t.said_aim),
        )
        for phase, t in targets
    ]
    print(Table.of_scores(table).markdown())
    write_report(arguments.json, results)
    return 0 if all(t.is_met for _, t in targets) else 1


if __name__ == '__main__':
    sys.exit(main())
