# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Gyroscope of an IMU: rotation of the lidar between sweeps."""

from __future__ import annotations

from collections.abc import Callable
from threading import Condition
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Imu

from fpnet_core.errors import FpnetError, OdometryError
from fpnet_core.geometry.frame_tree import FrameTree, plain_frame
from fpnet_core.geometry.gyro_track import GyroTrack
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.runtime import ODOMETRY_QUEUE, sensor_data
from msg_adapters.imu import rate_from_msg
from msg_adapters.stamps import stamp_from_msg

_KEPT_NS = 5 * NS_PER_S  # chosen: sweeps do not wait longer
_LATE_S = 0.05  # chosen: rates up to a sweep's end arrive within a few messages
_SILENT_S = 0.5  # chosen: an IMU silent for longer is not waited for


class GyroInput:
    """
    Orientations of a sensor from an IMU; another thread than the executor's may query them.

    Parameters
    ----------
    subscribe
        Creates a subscription from message class, topic, callback and QoS.
    tree
        Transforms with the mounts of IMU and sensor.
    report
        Called with the error of an unusable message.
    """

    def __init__(
        self,
        subscribe: Callable[[type, str, Callable[[Any], None], Any], Any],
        tree: FrameTree,
        report: Callable[[FpnetError], None],
    ) -> None:
        self._tree, self._report = tree, report
        self._track, self._changed = GyroTrack(_KEPT_NS), Condition()
        self._frame = ''
        self.heard_s = time.monotonic()
        subscribe(Imu, 'imu', self._on_imu, sensor_data(ODOMETRY_QUEUE))

    def orientation(self, sensor: str, stamp_ns: int) -> NDArray[np.float64] | None:
        """Return ``R_start_sensor (3, 3)`` at a time; None if unknown after a short wait."""
        with self._changed:
            if time.monotonic() - self.heard_s < _SILENT_S:
                self._changed.wait_for(lambda: self._track.newest_ns >= stamp_ns, _LATE_S)
            R_start_imu, frame = self._track.at(stamp_ns), self._frame
        if R_start_imu is None or not frame:
            return None
        try:
            return np.asarray(R_start_imu @ self._tree.mount(frame, sensor)[:3, :3])
        except OdometryError as error:
            self._report(error)
            return None

    def _on_imu(self, msg: Imu) -> None:
        try:
            rate = rate_from_msg(msg)
        except OdometryError as error:
            self._report(error)
            return
        with self._changed:
            self.heard_s = time.monotonic()
            self._frame = plain_frame(msg.header.frame_id)
            self._track.add(stamp_from_msg(msg.header.stamp), rate)
            self._changed.notify()
