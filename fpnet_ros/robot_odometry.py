# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a robot knows of its motion: odometry from a topic or TF, mounts, and a gyroscope."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from threading import Condition
import time
from typing import Any, Self

from nav_msgs.msg import Odometry
import numpy as np
from sensor_msgs.msg import Imu

from fpnet_core.errors import ConfigError, OdometryError
from fpnet_core.geometry.frame_tree import FrameTree, plain_frame
from fpnet_core.geometry.gyro_track import GyroTrack
from fpnet_core.geometry.pose_lookup import PoseLookup
from fpnet_core.geometry.pose_track import Array
from fpnet_core.io.topic_names import TF_STATIC_TOPIC, TF_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.logs import NodeLog
from fpnet_ros.params import OwnValues
from fpnet_ros.runtime import NO_TF, ODOMETRY_QUEUE, TF, TF_STATIC, TFMessage, sensor_data
from fpnet_ros.sweeps import Numbering
from msg_adapters.imu import rate_from_msg
from msg_adapters.odometry import odometry_from_msg
from msg_adapters.stamps import stamp_from_msg
from msg_adapters.transforms import transforms_from_msg

# Chosen, not measured:
_LATE_S = 0.15  # least wait for a pose: most odometry is published at 10 Hz or more
_LATE_GAPS = 1.5  # wait in intervals between messages, if that is longer
_SILENT_S = 0.5  # odometry or an IMU silent for longer is not waited for
_KEPT_NS = 5 * NS_PER_S  # rates of the gyroscope; sweeps do not wait longer
_LATE_RATE_S = 0.05  # rates up to a sweep's end arrive within a few messages
_GAPS = 9  # numerical: intervals of which the median counts


@dataclass(frozen=True)
class OdometryRun:
    """
    Identity of a run of the odometry, whose frame starts anew with every process.

    DDS gives every publisher a unique identifier, and publishers number their messages: together
    they show whether odometry went on while the localizer was down. ``publishers`` are the
    identifiers of all publishers on the topic, of a killed one for a while. ``number`` is that of
    the newest message, 0 if the middleware does not number them.
    """

    publishers: frozenset[str] = frozenset()
    number: int = 0

    def goes_on_from(self, saved: OdometryRun) -> bool | None:
        """Return whether this run continues a saved one; None if unknown."""
        if not (self.publishers and saved.publishers):
            return None
        return bool(self.publishers & saved.publishers) and self.number >= saved.number

    def as_text(self) -> str:
        """Return number and identifiers as words of one line."""
        return ' '.join([str(self.number), *sorted(self.publishers)])

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return the run that :meth:`as_text` wrote; the unknown run for other texts."""
        number, *publishers = text.split() or ['']
        return cls(frozenset(publishers), int(number)) if number.isdecimal() else cls()


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


class PoseInput:
    """
    Poses of the robot from an odometry topic or TF, and mounts of its sensors from ``/tf_static``.

    ``source`` is ``none``, ``topic`` or ``tf``, the value of the parameter ``source_key``; frames
    are as of :class:`fpnet_core.geometry.pose_lookup.PoseLookup`, ``where``. ``on_change`` is
    called after each message. If a new process publishes the odometry, older poses are cleared
    and ``on_restart`` is called; None keeps them. ``log`` gets the errors of unusable messages.

    Another thread than the executor's may call :meth:`awaited` and :meth:`wait_until`. ``missed``
    counts awaited poses that did not arrive in time although the odometry is received.

    Raises
    ------
    ConfigError
        If TF is needed but not available, or its odometry frame is unknown.
    """

    def __init__(
        self,
        node: OwnValues,
        source: str,
        source_key: str,
        topic: str,
        log: NodeLog,
        odom_frame: str = '',
        base_frame: str = '',
        on_change: Callable[[], None] = lambda: None,
        on_restart: Callable[[], None] | None = None,
    ) -> None:
        self._node, self._source, self._topic, self._log = node, source, topic, log
        self._odom_frame, self._on_change, self._on_restart = odom_frame, on_change, on_restart
        is_tf = source == 'tf'
        self.where = PoseLookup(from_tf=is_tf, odom_frame=odom_frame, base_frame=base_frame)
        self._changed, self._patience = Condition(), Patience(time.monotonic())
        self._heard_s, self._numbering = time.monotonic(), Numbering()
        self.missed = 0
        if is_tf and not odom_frame:
            raise ConfigError(
                f'parameter odom_frame is empty; with {source_key} tf set it to the odometry '
                'frame in TF, for example odom'
            )
        if source == 'topic':
            poses = sensor_data(ODOMETRY_QUEUE)
            node.add_subscription(Odometry, topic, self._on_odometry, poses)
        needs_tf = source != 'none' and self.where.needs_tf
        if TFMessage is not None:
            node.add_subscription(TFMessage, TF_STATIC_TOPIC, self._on_tf_static, TF_STATIC)
            if needs_tf:
                node.add_subscription(TFMessage, TF_TOPIC, self._on_tf, TF)
        elif needs_tf:
            raise ConfigError(NO_TF)

    @property
    def silence_s(self) -> float:
        """Time since the last message of the odometry, or since the start [s]."""
        return time.monotonic() - self._heard_s

    @property
    def topic(self) -> str:
        """Topic of the odometry, for log lines."""
        if self._source == 'tf':  # /tf has other publishers too
            return f'{self._node.resolve_topic_name(TF_TOPIC)} from {self._odom_frame!r}'
        return self._node.resolve_topic_name(self._topic)

    def run(self) -> OdometryRun:
        """Return the current run of the odometry; with TF it is unknown."""
        if self._source != 'topic':
            return OdometryRun()
        found = self._node.get_publishers_info_by_topic(self._topic)
        publishers = frozenset(bytes(each.endpoint_gid).hex() for each in found)
        return OdometryRun(publishers, self._numbering.newest)

    def awaited(self, frame: str, stamp_ns: int) -> Array | None:
        """Return ``T_odom_frame (4, 4)`` at a time, None if it does not arrive in time."""
        if self._source == 'none':
            return None
        with self._changed:
            deadline_s = time.monotonic() + self._patience.wait_s
            while (T_odom_frame := self.where.pose(frame, stamp_ns)) is None:
                left_s = deadline_s - time.monotonic()
                if time.monotonic() - self._patience.heard_s > _SILENT_S:
                    return None
                if left_s <= 0.0:
                    self.missed += 1
                    return None
                self._changed.wait(left_s)
        return T_odom_frame

    def wait_until(self, is_known: Callable[[], bool], deadline_s: float) -> bool:
        """Wait for a static transform until a monotonic time; return whether it arrived."""
        with self._changed:
            return self._changed.wait_for(is_known, max(0.0, deadline_s - time.monotonic()))

    def _on_odometry(self, msg: Odometry, info: dict[str, Any]) -> None:
        self._heard_s = time.monotonic()
        if self._numbering.follow(info) and self._on_restart is not None:
            self.where.clear()
            self._on_restart()
        try:
            odometry = odometry_from_msg(msg)
        except OdometryError as error:
            self._log.report(error)
            return
        with self._changed:
            self._patience.hear(self._heard_s)
            pose = odometry.T_parent_child
            self.where.add_pose(odometry.parent, odometry.child, pose, odometry.stamp_ns)
            self._changed.notify_all()
        self._on_change()

    def _on_tf_static(self, msg: Any) -> None:
        with self._changed:
            for each in transforms_from_msg(msg, self._log.report):
                self.where.tree.add_fixed(each.parent, each.child, each.T_parent_child)
            self._changed.notify_all()
        self._on_change()

    def _on_tf(self, msg: Any) -> None:
        with self._changed:
            transforms = transforms_from_msg(msg, self._log.report)
            for each in transforms:
                self.where.tree.add(each.parent, each.child, each.T_parent_child, each.stamp_ns)
            if any(each.parent == self._odom_frame for each in transforms):
                self._heard_s = time.monotonic()
                self._patience.hear(self._heard_s)
            self._changed.notify_all()
        self._on_change()


class GyroInput:
    """
    Orientations of a sensor from an IMU; another thread than the executor's may query them.

    ``tree`` has the mounts of IMU and sensor; ``log`` gets the errors of unusable messages.
    """

    def __init__(self, node: OwnValues, tree: FrameTree, log: NodeLog) -> None:
        self._tree, self._log = tree, log
        self._track, self._changed = GyroTrack(_KEPT_NS), Condition()
        self._frame = ''
        self.heard_s = time.monotonic()
        node.add_subscription(Imu, 'imu', self._on_imu, sensor_data(ODOMETRY_QUEUE))

    def orientation(self, sensor: str, stamp_ns: int) -> Array | None:
        """Return ``R_start_sensor (3, 3)`` at a time; None if unknown after a short wait."""
        with self._changed:
            if time.monotonic() - self.heard_s < _SILENT_S:
                self._changed.wait_for(lambda: self._track.newest_ns >= stamp_ns, _LATE_RATE_S)
            R_start_imu, frame = self._track.at(stamp_ns), self._frame
        if R_start_imu is None or not frame:
            return None
        try:
            return np.asarray(R_start_imu @ self._tree.mount(frame, sensor)[:3, :3])
        except OdometryError as error:
            self._log.report(error)
            return None

    def _on_imu(self, msg: Imu) -> None:
        try:
            rate = rate_from_msg(msg)
        except OdometryError as error:
            self._log.report(error)
            return
        with self._changed:
            self.heard_s = time.monotonic()
            self._frame = plain_frame(msg.header.frame_id)
            self._track.add(stamp_from_msg(msg.header.stamp), rate)
            self._changed.notify()
