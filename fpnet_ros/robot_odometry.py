# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The robot's own odometry from a topic or TF, as initial guess for scan matching."""

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
_LATE_S = 0.15  # least wait for a pose: most odometry is published at 10 Hz or more
_LATE_GAPS = 1.5  # wait in intervals between messages, if that is longer
_SILENT_S = 0.5  # odometry silent for longer is not waited for
_GAPS = 9  # numerical: intervals of which the median counts


class RobotOdometryParameters(LaserParameters):
    """Source of the robot's own odometry."""

    robot_odometry: Literal['none', 'topic', 'tf'] = Field(
        'none',
        description="The robot's own odometry, as initial guess and check of each registration: "
        'none, from the topic odom, or from odom_frame in TF.',
    )
    odom_frame: str = Field('', description="Frame of the robot's own odometry in TF.")


class Patience:
    """Wait for periodic messages, from the intervals between the last ones."""

    def __init__(self, now_s: float) -> None:
        self.heard_s = now_s
        self._gaps_s: deque[float] = deque([_SILENT_S], maxlen=_GAPS)

    @property
    def wait_s(self) -> float:
        """Return how long to wait for the next message [s]."""
        return max(_LATE_S, _LATE_GAPS * median(self._gaps_s))

    def hear(self, now_s: float) -> None:
        """Note a received message."""
        self._gaps_s.append(now_s - self.heard_s)
        self.heard_s = now_s


class RobotOdometry:
    """
    Poses of the robot's own odometry; another thread than the executor's may query them.

    Parameters
    ----------
    subscribe
        Creates a subscription from message class, topic, callback and QoS.
    parameters
        Source of the poses.
    report
        Called with the error of an unusable message.

    Attributes
    ----------
    missed
        Queried poses that did not arrive in time although the odometry is received.
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
                'parameter odom_frame is empty; with robot_odometry tf set it to the frame of the '
                "robot's own odometry in TF, for example odom"
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
        """Whether a source is configured."""
        return self._source != 'none'

    def topic(self, node: Node) -> str:
        """Return the topic of the odometry, for log lines."""
        if self._source == 'tf':  # /tf has other publishers too
            return f'{node.resolve_topic_name("/tf")} from {self._odom_frame!r}'
        return node.resolve_topic_name('odom')

    @property
    def silence_s(self) -> float:
        """Time since the last message of the robot's odometry [s]."""
        return time.monotonic() - self._patience.heard_s

    def pose(self, frame: str, stamp_ns: int) -> Array | None:
        """Return ``T_odom_frame (4, 4)`` at a time, None if it does not arrive in time."""
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
        """Add a static transform."""
        with self._changed:
            self.where.tree.add_fixed(parent, child, T_parent_child)
            self._changed.notify()

    def wait_until(self, is_known: Callable[[], bool], deadline_s: float) -> bool:
        """Wait for a static transform until a monotonic time; return whether it arrived."""
        with self._changed:
            return self._changed.wait_for(is_known, max(0.0, deadline_s - time.monotonic()))

    def _on_odometry(self, msg: Odometry) -> None:
        try:
            stamped = odometry_from_msg(msg)
        except OdometryError as error:
            self._report(error)
            return
        with self._changed:
            self._patience.hear(time.monotonic())
            self.where.add_pose(
                stamped.parent, stamped.child, stamped.T_parent_child, stamped.stamp_ns
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
