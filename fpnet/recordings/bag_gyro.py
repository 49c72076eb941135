# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Orientation of a lidar from the gyroscope in a bag."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import OdometryError
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.geometry.gyro_track import GyroTrack
from fpnet_core.io.bags import BagReader, first_frame
from fpnet_core.io.message_types import IMU
from fpnet_core.io.messages import rate_of, stamp_to_ns

_log = logging.getLogger(__name__)


class BagGyro:
    """
    Orientations of a sensor from one IMU of a bag: the first with a known mount.

    Parameters
    ----------
    bag, path
        Open bag, and its path for messages.
    static
        Static transforms.
    sensor
        Frame whose orientation is wanted.
    """

    def __init__(self, bag: BagReader, path: Path, static: FrameTree, sensor: str) -> None:
        self._track = GyroTrack()
        self._R_imu_sensor = np.eye(3)
        imus = sorted(t for t, kind in bag.topics.items() if kind == IMU and bag.count(t))
        for topic in imus:
            try:
                T_imu_sensor = static.mount(first_frame(bag, topic, path), sensor)
                self._track = _rates(bag, topic)
            except (OdometryError, ValueError) as error:
                _log.warning('%s: the gyroscope on %s is not used: %s', path, topic, error)
                continue
            self._R_imu_sensor = T_imu_sensor[:3, :3]
            _log.info('%s: rotations are taken from the gyroscope on %s', path, topic)
            break

    def at(self, stamp_ns: int) -> NDArray[np.float64] | None:
        """Return ``R_gyro_sensor (3, 3)``; None without a gyroscope or where it has a gap."""
        R_start_imu = self._track.at(stamp_ns) if len(self._track) else None
        return None if R_start_imu is None else R_start_imu @ self._R_imu_sensor


def _rates(bag: BagReader, topic: str) -> GyroTrack:
    track = GyroTrack()
    for _, recorded_ns, message in bag.messages([topic]):
        track.add(stamp_to_ns(message.header.stamp) or recorded_ns, rate_of(message))
    return track
