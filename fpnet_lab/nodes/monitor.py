# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node of the demo that shows the localizer's pose and records what it publishes."""

from __future__ import annotations

import json
import math
from pathlib import Path
import time
from typing import Self

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from fpnet.recordings.trajectories import write_tum
from fpnet_core.io.sessions import POSES_NAME, SESSION_NAME
from fpnet_core.io.topic_names import KISS_FRAME, KISS_ODOMETRY
from fpnet_core.types import Status
from fpnet_ros.runtime import STATUS, STREAM
from msg_adapters.diagnostics import LocalizerReport, report_from_msg
from msg_adapters.poses import StampedPose, pose_from_msg
from msg_adapters.stamps import stamp_from_msg

_STARTING = 'starting the nodes; the first start after an installation compiles'
_LINE_PERIOD_S = 5.0  # between two lines if the output is not a terminal; chosen


class Monitor(Node):
    """
    Collects poses, updates and odometry stamps; a context manager around rclpy.

    The caller handles signals, because rclpy's handlers would end the context at any point.

    Parameters
    ----------
    scans
        Number of scans in the recording, for the progress bar.
    """

    def __init__(self, scans: int) -> None:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        super().__init__('fpnet_demo')
        self.poses: list[StampedPose] = []
        self.updates: list[LocalizerReport] = []
        self.odometry_stamps_ns: list[int] = []
        self._scans = scans
        self._heard_s = time.monotonic()
        self._line_s = 0.0
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)
        self._console = Console()
        self._bar = Progress(
            TextColumn('localising'),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
            TextColumn('{task.description}'),
            console=self._console,
            transient=True,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task(_STARTING, total=scans)
        self.create_subscription(PoseStamped, 'floorplan_pose', self._on_pose, STREAM)
        self.create_subscription(DiagnosticStatus, 'localizer/status', self._on_status, STATUS)
        self.create_subscription(Odometry, KISS_ODOMETRY, self._on_odometry, STREAM)

    def __enter__(self) -> Self:
        """Show the progress bar."""
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Print the last status and shut ROS down."""
        self._bar.stop()
        self._print_line()
        self._executor.shutdown()
        self.destroy_node()
        rclpy.try_shutdown()

    def spin(self, seconds: float) -> None:
        """Handle messages for some seconds, then show the status."""
        deadline = time.monotonic() + seconds
        while (left_s := deadline - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left_s)
        self._show()

    def is_ready(self, cloud_topic: str) -> bool:
        """Return whether the localizer has its floorplan and discovery is complete."""
        return (
            any(update.status is not Status.NO_PLAN for update in self.updates)
            and self.count_subscribers(cloud_topic) > 0
            and self.count_subscribers(KISS_FRAME) > 0
            and self.count_publishers(KISS_ODOMETRY) > 0
        )

    def is_complete(self) -> bool:
        """Return whether odometry registered every scan and an update used the last one."""
        done = len(self.odometry_stamps_ns) >= self._scans
        return done and self.updates[-1].stamp_ns == self.odometry_stamps_ns[-1]

    def quiet_s(self) -> float:
        """Return the time since the last odometry message [s]."""
        return time.monotonic() - self._heard_s

    def write(self, folder: Path) -> None:
        """Write ``poses.tum`` and ``session.json``."""
        poses = [pose.T_frame_body for pose in self.poses]
        write_tum(
            folder / POSES_NAME,
            [pose.stamp_ns for pose in self.poses],
            np.array([pose.translation for pose in poses]),
            [pose.yaw for pose in poses],
        )
        session = {
            'scans': self._scans,
            'registered_scans': len(self.odometry_stamps_ns),
            'ticks': [
                {
                    'stamp_ns': update.stamp_ns,
                    'status': update.status.value,
                    'probability': update.probability,
                    'reason': update.reason,
                    'causes': [cause.as_json() for cause in update.causes],
                    **update.values,
                }
                for update in self.updates
            ],
        }
        (folder / SESSION_NAME).write_text(json.dumps(session, indent=1), encoding='utf-8')

    def _on_pose(self, msg: PoseStamped) -> None:
        self.poses.append(pose_from_msg(msg))

    def _on_status(self, msg: DiagnosticStatus) -> None:
        self.updates.append(report_from_msg(msg))

    def _on_odometry(self, msg: Odometry) -> None:
        self.odometry_stamps_ns.append(stamp_from_msg(msg.header.stamp))
        self._heard_s = time.monotonic()

    def _show(self) -> None:
        done = len(self.odometry_stamps_ns)
        self._bar.update(self._task, completed=done, description=self._describe())
        if self._bar.disable and time.monotonic() - self._line_s > _LINE_PERIOD_S:
            self._line_s = time.monotonic()
            self._print_line()

    def _print_line(self) -> None:
        done = len(self.odometry_stamps_ns)
        why = f': {self.updates[-1].reason}' if self.updates else ''
        said = f'scan {done}/{self._scans}  {self._describe()}{why}'
        self._console.print(said, highlight=False)

    def _describe(self) -> str:
        if not self.updates:
            return _STARTING
        update = self.updates[-1]
        text = f'{update.status.value} (p {update.probability:.2f})'
        if update.status is not Status.LOCALIZED or not self.poses:
            return text
        pose = self.poses[-1].T_frame_body
        return f'{text}  x {pose.x:.2f} m  y {pose.y:.2f} m  {math.degrees(pose.yaw):.0f} deg'
