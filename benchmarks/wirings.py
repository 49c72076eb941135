#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Live test of robots with different sensors and wiring, with the nodes of the launch file.

Run: python benchmarks/wirings.py [--short] [--robot NAME ...] [--json OUT]

Every robot is simulated and recorded as a bag. The bag is localized offline, and then played in
simulated time to live nodes over DDS with the parameters of ``fpnet_ros.wiring``. For each robot
it prints the time of the first pose, errors relative to ground truth, whether every TF frame has
one parent and the chain from ``map`` to the base equals the published pose, and the number of lost
scans. Exits 1 if a robot misses a limit. ``--short`` uses three robots and shorter recordings.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
import os
from pathlib import Path
import sys
import tempfile
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from tf2_msgs.msg import TFMessage

from fpnet.api.run import Run, scans_of
from fpnet.bag_writer import BagWriter
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.geometry import SE2
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.geometry.motion import twist
from fpnet_core.io.bags import BagReader
from fpnet_core.io.maps import write_map
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_lab.cli.reports import print_scores, script_parser, write_report
from fpnet_lab.nodes.processes import (
    Child,
    ProcessGroup,
    free_domain_id,
    node_command,
    private_environment,
    ros_arguments,
)
from fpnet_lab.scores import Score, Unit, Units
from fpnet_lab.sim.drives.robots import BASE, PLANAR, Drive, Robot, Sensor, place
from fpnet_lab.sim.drives.scanning import EPOCH_NS
from fpnet_ros.runtime import STATUS, STREAM, TF, TF_STATIC
from fpnet_ros.wiring import wired
from msg_adapters.diagnostics import report_from_msg
from msg_adapters.poses import pose_from_msg, uncertain_pose_from_msg
from msg_adapters.stamps import stamp_from_msg
from msg_adapters.transforms import transform_from_msg, transform_to_msg

READY_S, STALLED_S, DRAIN_S, MOST_AHEAD = 600.0, 60.0, 4.0, 5
DRIVE_S, SHORT_DRIVE_S = 45.0, 20.0

# Limits of the first pose, of the median errors, and of TF relative to the published pose.
SHORT_NS = 10_000_000  # interval for the true velocity
MOST_FIRST_S, MOST_ERROR_M, MOST_ERROR_DEG, MOST_TF_M = 30.0, 0.3, 2.0, 0.15
MOST_SPEED_MPS, MOST_TURN_RADPS = 0.3, 0.15


@dataclass(frozen=True, eq=False)
class Wiring:
    """A robot, and the launch arguments of its nodes."""

    name: str
    robot: Robot
    arguments: dict[str, str]


_ON_MAST = place(0.1, 0.0, 0.9, 0.0, 0.0, 90.0)
_HANGING = place(0.1, 0.0, 0.9, 180.0, 12.0, 30.0)
_SCANNER = place(0.2, 0.0, 0.3, 0.0, 0.0, 0.0)
_FRONT = Sensor('/front/scan', 'front', place(0.3, 0.1, 0.3, 0.0, 0.0, 20.0), PLANAR)
_REAR = Sensor('/rear/scan', 'rear', place(-0.3, -0.1, 0.3, 180.0, 0.0, 170.0), PLANAR)


def _of_pair(number: int, seed: int) -> Wiring:
    name = f'robot_{number}'
    scanner = Sensor(f'/{name}/scan', 'laser', _SCANNER, PLANAR)
    arguments = {'scan': 'scan', 'base_frame': BASE, 'namespace': name}
    return Wiring(f'pair: {name}', Robot(seed, (scanner,), namespace=f'/{name}'), arguments)


SESSIONS: dict[str, tuple[Wiring, ...]] = {
    'own_odometry': (
        Wiring(
            '3D lidar, odometry TF of its own',
            Robot(
                5,
                (Sensor('/points', 'lidar', _ON_MAST, stamp=0.0, absolute_times=True),),
                wheels_in_tf=True,
            ),
            {'base_frame': BASE, 'odom_frame': 'odom', 'publish_odom_tf': 'false'},
        ),
    ),
    'lidar_alone': (
        Wiring(
            '3D lidar alone',
            Robot(2, (Sensor('/lidar/points', 'lidar', _ON_MAST),)),
            {'points': '/lidar/points'},
        ),
    ),
    'scanners_and_wheels': (
        Wiring(
            'two planar scanners and wheels',
            Robot(1, (_FRONT, _REAR), wheels_topic='/wheels/odometry', wheels_in_tf=True),
            {
                'base_frame': BASE,
                'scan': '/front/scan,/rear/scan',
                'odometry': 'robot',
                'odom_topic': '/wheels/odometry',
            },
        ),
    ),
    'hanging': (
        Wiring(
            'lidar tilted and upside down',
            Robot(5, (Sensor('/points', 'lidar', _HANGING, stamp=0.5),)),
            {'base_frame': BASE, 'odom_frame': 'odom'},
        ),
    ),
    'both_odometries': (
        Wiring(
            '3D lidar, KISS-ICP helped by TF',
            Robot(2, (Sensor('/points', 'lidar', _ON_MAST, stamp=0.0),), wheels_in_tf=True),
            {'base_frame': BASE, 'odometry': 'both'},
        ),
    ),
    'pair': (_of_pair(1, 1), _of_pair(2, 5)),
}
SHORT = ('own_odometry', 'scanners_and_wheels', 'pair')


@dataclass
class Result:
    """Results of one robot."""

    robot: str
    sweeps: int
    first_pose_s: float = np.inf
    poses: int = 0
    error_m: float = np.inf
    error_deg: float = np.inf
    offline_error_m: float = np.inf
    lost: dict[str, float] = field(default_factory=dict)
    parents: dict[str, list[str]] = field(default_factory=dict)
    tf_error_m: float = np.inf
    twist_error: tuple[float, float] | None = None

    @property
    def scores(self) -> tuple[Score, ...]:
        """Measured values with their limits."""
        is_ours = self.twist_error is not None
        speed_mps, turn_radps = self.twist_error or (None, None)
        return (
            Score('first pose', self.first_pose_s, Units.SECONDS, MOST_FIRST_S),
            Score('median error', self.error_m, Units.METRES, MOST_ERROR_M),
            Score('heading', self.error_deg, Units.DEGREES, MOST_ERROR_DEG),
            Score('offline', self.offline_error_m, Units.METRES, MOST_ERROR_M),
            Score('TF', self.tf_error_m, Units.METRES, MOST_TF_M),
            Score('velocity', speed_mps, Unit(' m/s', 2), MOST_SPEED_MPS if is_ours else None),
            Score('turning', turn_radps, Unit(' rad/s', 2), MOST_TURN_RADPS if is_ours else None),
        )

    @property
    def faults(self) -> list[str]:
        """Descriptions of the exceeded limits."""
        faults = [f'{score.name} {score}' for score in self.scores if not score.is_met]
        faults += [f'{name} {count:.0f}' for name, count in self.lost.items() if count]
        return faults + [
            f'{child} has parents {", ".join(parents)}'
            for child, parents in self.parents.items()
            if len(parents) > 1
        ]


class RobotListener:
    """Subscriber to the outputs of one robot."""

    def __init__(self, node: Any, wiring: Wiring, drive: Drive) -> None:
        self.wiring, self._drive, robot = wiring, drive, drive.robot
        at = robot.namespace
        self.statuses: list[DiagnosticStatus] = []
        node.create_subscription(
            DiagnosticStatus, f'{at}/localizer/status', self.statuses.append, STATUS
        )
        self.poses: list[PoseStamped] = []
        self.twins: list[PoseWithCovarianceStamped] = []
        self.odometry: list[Odometry] = []
        self.values: dict[str, dict[str, float]] = {}
        self.tree = FrameTree(horizon_s=60.0, max_gap_s=2.0)
        self.parents: dict[str, set[str]] = defaultdict(set)
        self._names = {f'{at}/{name}': name for name in ('localizer', 'odometry')}
        node.create_subscription(PoseStamped, f'{at}/floorplan_pose', self.poses.append, STREAM)
        twin = f'{at}/floorplan_pose_with_covariance'
        node.create_subscription(PoseWithCovarianceStamped, twin, self.twins.append, STREAM)
        node.create_subscription(Odometry, f'{at}/kiss/odometry', self.odometry.append, STREAM)
        node.create_subscription(TFMessage, f'{at}/tf', self._on_tf, TF)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, STREAM)
        self._static = node.create_publisher(TFMessage, f'{at}/tf_static', TF_STATIC)
        places = [transform_to_msg(s.T_base_sensor, 0, BASE, s.frame) for s in robot.sensors]
        self._static.publish(TFMessage(transforms=places))
        for sensor in robot.sensors:
            self.parents[sensor.frame].add(BASE)
            self.tree.add_fixed(BASE, sensor.frame, sensor.T_base_sensor)

    @property
    def is_ready(self) -> bool:
        """Whether the localizer has its floorplan, compiled kernels and subscriptions."""
        reports = map(report_from_msg, self.statuses)
        return any(report.status is not Status.NO_PLAN for report in reports)

    def result(self, sweeps: int) -> Result:
        """Return the results of the robot."""
        result = Result(self.wiring.name, sweeps, poses=len(self.poses))
        result.parents = {child: sorted(parents) for child, parents in self.parents.items()}
        for name, values in self.values.items():
            result.lost[f'{name} missed'] = sweeps - values['scans']
            for kind in ('dropped', 'lost', 'earlier'):
                result.lost[f'{name} {kind}'] = values[f'{kind}_scans']
        if not self.poses or not self.twins:
            return result
        poses = [pose_from_msg(msg) for msg in self.poses]
        stamps = np.array([pose.stamp_ns for pose in poses])
        errors = self._drive.errors(stamps, [pose.T_frame_body for pose in poses], np.eye(4))
        result.first_pose_s = float(stamps[0] - EPOCH_NS) / NS_PER_S
        result.error_m = float(np.median(errors[:, 0]))
        result.error_deg = float(np.degrees(np.median(errors[:, 1])))
        result.tf_error_m = self._tf_error_m()
        result.twist_error = self._twist_error()
        return result

    def _tf_error_m(self) -> float:
        """Return the median distance between the TF chain and the published poses [m]."""
        gaps = []
        for msg in self.twins:
            pose = uncertain_pose_from_msg(msg).pose
            T_map_body = self.tree.lookup('map', BASE, pose.stamp_ns)
            if T_map_body is not None:
                gaps.append(np.hypot(*(T_map_body[:2, 3] - pose.T_frame_body.translation)))
        return float(np.median(gaps)) if gaps else np.inf

    def _twist_error(self) -> tuple[float, float] | None:
        """Return the RMS errors of our odometry's velocities [m/s], [rad/s], None if unknown."""
        known = [msg for msg in self.odometry if msg.twist.covariance[0] >= 0.0]
        if not known:
            return None
        rows = []
        for msg in known:
            stamp_ns = stamp_from_msg(msg.header.stamp)
            before, after = self._drive.base_at(np.array([stamp_ns - SHORT_NS, stamp_ns]))
            true = twist(np.linalg.inv(before) @ after, SHORT_NS / NS_PER_S)
            linear, angular = msg.twist.twist.linear, msg.twist.twist.angular
            rows.append((linear.x - true[0], linear.y - true[1], angular.z - true[5]))
        x, y, turn = np.sqrt((np.array(rows) ** 2).mean(axis=0)).tolist()
        return max(x, y), turn

    def _on_tf(self, msg: TFMessage) -> None:
        for t in map(transform_from_msg, msg.transforms):
            self.parents[t.child].add(t.parent)
            self.tree.add(t.parent, t.child, t.T_parent_child, t.stamp_ns)

    def _on_diagnostics(self, msg: DiagnosticArray) -> None:
        for status in msg.status:
            node, _, part = status.name.partition(': ')
            name = self._names.get(node)
            if name is not None and part != 'doctor':
                self.values[name] = {
                    entry.key: float(entry.value)
                    for entry in status.values
                    if entry.key.endswith('scans')
                }


class Session:
    """Robots of one session with their nodes and the player, in a separate ROS domain."""

    def __init__(self, wirings: tuple[Wiring, ...], folder: Path, seconds: float) -> None:
        self._wirings, self._folder = wirings, folder
        self._drives = [Drive.of(wiring.robot, seconds) for wiring in wirings]
        with BagWriter(folder / 'bag') as bag:
            self._sweeps = [drive.write(bag) for drive in self._drives]
        for number, drive in enumerate(self._drives):
            write_map(drive.recording.floorplan, folder / f'plan_{number}.yaml')

    def play(self) -> list[Result]:
        """Start all nodes, play the bag to them, and return the results of each robot."""
        environment = private_environment(free_domain_id())
        os.environ.update(environment)
        with ProcessGroup(self._folder / 'log', environment) as group:
            children = [self._start(group, number) for number in range(len(self._wirings))]
            rclpy.init()
            node = rclpy.create_node('wirings')
            pairs = zip(self._wirings, self._drives, strict=True)
            listeners = [RobotListener(node, wiring, drive) for wiring, drive in pairs]
            try:
                self._follow(node, listeners, children, group)
            finally:
                node.destroy_node()
                rclpy.shutdown()
        pairs_of_results = zip(listeners, self._sweeps, strict=True)
        return [listener.result(sweeps) for listener, sweeps in pairs_of_results]

    def _start(self, group: ProcessGroup, number: int) -> list[Child]:
        wiring = self._wirings[number]
        plan = str(self._folder / f'plan_{number}.yaml')
        specs = wired({**wiring.arguments, 'floorplan': plan, 'use_sim_time': 'true'})
        children = []
        for spec in specs:
            remappings = dict(spec.remappings)
            if wiring.robot.namespace:
                remappings['__ns'] = wiring.robot.namespace
            words = ros_arguments(spec.parameters, remappings)
            name = f'{number}_{spec.executable}'
            children.append(group.start(name, [*node_command(spec.executable), *words]))
        return children

    def _follow(
        self,
        node: Any,
        listeners: list[RobotListener],
        children: list[list[Child]],
        group: ProcessGroup,
    ) -> None:
        executor = SingleThreadedExecutor()
        executor.add_node(node)

        def spin_until(condition: Callable[[], bool], timeout_s: float) -> bool:
            deadline = time.monotonic() + timeout_s
            while not condition():
                if time.monotonic() > deadline:
                    return False
                executor.spin_once(timeout_sec=0.1)
                group.check(may_end=ended)
            return True

        ended: list[Child] = []
        if not spin_until(lambda: all(listener.is_ready for listener in listeners), READY_S):
            tails = [child.log_tail() for started in children for child in started]
            raise SystemExit('not ready: ' + '\n'.join(tails))
        replay = group.start('replay', self._replay())
        ended.append(replay)
        spin_until(lambda: replay.process.poll() is not None, STALLED_S + 1e3)
        spin_until(lambda: False, DRAIN_S)

    def _replay(self) -> list[str]:
        last = self._wirings[-1].robot
        with BagReader(self._folder / 'bag') as bag:
            topics = [topic for topic in bag.topics if not topic.endswith('tf_static')]
        is_ours = len(self._wirings) == 1 and self._wirings[0].arguments.get('odometry') != 'robot'
        parameters = {
            # Play slower on a machine too slow for KISS-ICP; planar scans are cheap.
            'max_ahead': MOST_AHEAD if is_ours else 0,
            'bag': str(self._folder / 'bag'),
            'topics': topics,
            'clock': True,
            'wait_for_localizer': True,
            'wait_for_subscriber_s': STALLED_S,
        }
        remappings = {'localizer/status': f'{last.namespace}/localizer/status'}
        return [*node_command('replay'), *ros_arguments(parameters, remappings)]

    def offline_error_m(self, number: int) -> float:
        """Localize the bag offline; return the median error [m], infinite without a pose."""
        wiring, drive = self._wirings[number], self._drives[number]
        config, options = FpnetConfig(), ReadOptions()
        plan = read_plan(self._folder / f'plan_{number}.yaml', options)
        topics = [sensor.topic for sensor in wiring.robot.sensors]
        choice: Any = wiring.arguments.get('odometry', 'kiss')
        source = scans_of(self._folder / 'bag', odometry=choice, topics=topics)
        poses = Run(plan, source, config, odometry=choice).poses
        if not len(poses):
            return np.inf
        is_planar = wiring.robot.sensors[0].model.beams == 1  # then the base is the sensor
        T_base_body = np.eye(4) if is_planar else wiring.robot.sensors[0].T_base_sensor
        in_plan = [SE2.from_xy_yaw(*xy, yaw) for xy, yaw in zip(poses.xy, poses.yaw, strict=True)]
        return float(np.median(drive.errors(poses.stamps_ns, in_plan, T_base_body)[:, 0]))


def run(names: list[str], seconds: float) -> Iterator[Result]:
    """Yield the results of each robot, one session after another."""
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            session = Session(SESSIONS[name], Path(folder), seconds)
            for number, result in enumerate(session.play()):
                result.offline_error_m = session.offline_error_m(number)
                yield result


def row(result: Result) -> tuple[Score, ...]:
    """Return the scores of a robot, and its exceeded limits."""
    lost = f'{sum(result.lost.values()):.0f} of {result.sweeps}'
    verdict = Score('', '; '.join(result.faults) or 'passes')
    return Score('robot', result.robot), *result.scores, Score('scans lost', lost), verdict


def main() -> int:
    """Print a Markdown table with one row per robot; return the exit status."""
    parser = script_parser(__doc__)
    parser.add_argument('--short', action='store_true')
    parser.add_argument('--robot', action='append', choices=sorted(SESSIONS))
    arguments = parser.parse_args()
    names = arguments.robot or list(SHORT if arguments.short else SESSIONS)
    seconds = SHORT_DRIVE_S if arguments.short else DRIVE_S
    results = print_scores(run(names, seconds), row)
    write_report(arguments.json, {'robots': [asdict(result) for result in results]})
    return 0 if all(not result.faults for result in results) else 1


if __name__ == '__main__':
    sys.exit(main())
