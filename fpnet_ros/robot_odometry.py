# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The robot's own odometry, as a first guess for scan matching: from a topic or from TF."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from statistics import median
from threading import Condition
import time
from typing import Any, Literal

from nav_msgs.msg import Odometry
from pydantic import Field
from rclpy.node import Node

from fpnet_core.errors import ConfigError, FpnetError, OdometryError
from fpnet_core.geometry.pose_lookup import PoseLookup
from fpnet_core.geometry.pose_track import Array
from fpnet_core.io.topic_names import TF_TOPIC
from fpnet_ros.lasers import LaserParameters
from fpnet_ros.optional_messages import NO_TF, TFMessage
from fpnet_ros.runtime import ODOMETRY_QUEUE, TF, sensor_data
from msg_adapters.odometry import odometry_from_msg
from msg_adapters.transforms import transforms_from_msg

# Chosen, not measured:
_LATE_S = 0.15  # wheels and their fusion report ten times a second and more, or
_LATE_GAPS = 1.5  # are waited for by so many of the times between their reports
_SILENT_S = 0.5  # whoever has said nothing for so long is not waited for
_GAPS = 9  # numerical: reports that tell how far they are apart


class RobotOdometryParameters(LaserParameters):
    """Where the robot's own odometry comes from."""

    robot_odometry: Literal['none', 'topic', 'tf'] = Field(
        'none',
        description="First guess of every registration, and a check: the robot's own odometry, "
        'from the topic odom, or from odom_frame in TF.',
    )
    odom_frame: str = Field('', description="Frame of the robot's own odometry in TF.")


class Patience:
    """How long reports are waited for that come about as often as they did."""

    def __init__(self, now_s: float) -> None:
        self.heard_s = now_s
        self._gaps_s: deque[float] = deque([_SILENT_S], maxlen=_GAPS)

    @property
    def wait_s(self) -> float:
        """Return for how long the next report is worth waiting [s]."""
        return max(_LATE_S, _LATE_GAPS * median(self._gaps_s))

    def hear(self, now_s: float) -> None:
        """Take note of a report."""
        self._gaps_s.append(now_s - self.heard_s)
        self.heard_s = now_s


class RobotOdometry:
    """
    Poses of the robot's own odometry, for another thread than the executor's.

    Parameters
    ----------
    subscribe
        Makes a subscription: message class, topic, callback, QoS.
    parameters
        Where poses come from.
    report
        Takes what is wrong with a message.

    Attributes
    ----------
    missed
        Poses that were asked for and did not come in time, though the robot's odometry is heard.
    """

    def __init__(
        self,
        subscribe: Callable[[type, str, Callable[[Any], None], Any], Any],
        parameters: RobotOdometryParameters,
        report: Callable[[FpnetError], None],
    ) -> None:
        source = parameters.robot_odometry
        if source == 'tf' and not parameters.odom_frame:
            raise ConfigError(
                'parameter odom_frame is empty; with robot_odometry tf it names the frame of the '
                "robot's own odometry in TF, as odom"
            )
        self.where = PoseLookup(from_tf=source == 'tf', odom_frame=parameters.odom_frame)
        self._source, self._report = source, report
        self._odom_frame = parameters.odom_frame
        self._changed = Condition()
        self._patience = Patience(time.monotonic())
        self.missed = 0
        if source == 'topic':
            subscribe(Odometry, 'odom', self._on_odometry, sensor_data(ODOMETRY_QUEUE))
        elif source == 'tf':
            if TFMessage is None:
                raise ConfigError(NO_TF)
            subscribe(TFMessage, TF_TOPIC, self._on_tf, TF)

    @property
    def is_used(self) -> bool:
        """Whether there is one."""
        return self._source != 'none'

    def topic(self, node: Node) -> str:
        """Return the topic that it comes from."""
        if self._source == 'tf':  # where others publish as well
            return f'{node.resolve_topic_name("/tf")} from {self._odom_frame!r}'
        return node.resolve_topic_name('odom')

    @property
    def silence_s(self) -> float:
        """Time since the robot's odometry was last heard [s]."""
        return time.monotonic() - self._patience.heard_s

    def pose(self, frame: str, stamp_ns: int) -> Array | None:
        """Return ``T_odom_frame (4, 4)`` at a time; waits a moment, but not for the dead."""
        if not self.is_used:
            return None
        with self._changed:
            deadline_s = time.monotonic() + self._patience.wait_s
            while (T_odom_frame := self.where.pose(frame, stamp_ns)) is None:
                left_s = deadline_s - time.monotonic()
                if self.silence_s > _SILENT_S:
                    return None
                if left_s <= 0.0:
                    self.missed += 1
                    return None
                self._changed.wait(left_s)
        return T_odom_frame

    def add_fixed(self, parent: str, child: str, T_parent_child: Array) -> None:
        """Take a transform that never changes."""
        with self._changed:
            self.where.tree.add_fixed(parent, child, T_parent_child)
            self._changed.notify()

    def wait_until(self, is_known: Callable[[], bool], deadline_s: float) -> bool:
        """Wait for a transform that never changes; False where it has not come by a time."""
        with self._changed:
            return self._changed.wait_for(is_known, max(0.0, deadline_s - time.monotonic()))

    def _on_odometry(self, msg: Odometry) -> None:
        try:
            reading = odometry_from_msg(msg)
        except OdometryError as error:
            self._report(error)
            return
        with self._changed:
            self._patience.hear(time.monotonic())
            self.where.add_pose(
                reading.parent, reading.child, reading.T_parent_child, reading.stamp_ns
            )
            self._changed.notify()

    def _on_tf(self, msg: Any) -> None:
        transforms = transforms_from_msg(msg, self._report)
        with self._changed:
            for t in transforms:
                self.where.tree.add(t.parent, t.child, t.T_parent_child, t.stamp_ns)
            if any(t.parent == self._odom_frame for t in transforms):
                self._patience.hear(time.monotonic())
            self._changed.notify()
