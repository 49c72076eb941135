# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion of ``sensor_msgs/LaserScan`` and ``MultiEchoLaserScan`` messages to points.

The functions only read attributes, so that messages of rclpy and of rosbags both work and the
core needs no message package.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import CloudFormatError
from fpnet_core.io.pointcloud2 import LONGEST_SWEEP_S

# Physical: scanners with a full turn repeat a few rays; degrees in place of radians give 57 turns.
_MOST_TURNS = 1.1


class LaserScanLike(Protocol):
    """Attributes of a LaserScan message."""

    @property
    def angle_min(self) -> float:
        """Angle of the first ray [rad], counterclockwise from x."""

    @property
    def angle_increment(self) -> float:
        """Angle between two rays [rad]; negative for clockwise scanners."""

    @property
    def time_increment(self) -> float:
        """Time between two rays [s]; 0 if simultaneous or unknown."""

    @property
    def range_min(self) -> float:
        """Shortest valid range [m]."""

    @property
    def range_max(self) -> float:
        """Limit below which ranges are valid [m]; many drivers write it for no return."""

    @property
    def ranges(self) -> Any:
        """Range [m] or echoes of each ray."""


@dataclass(frozen=True, eq=False)
class LaserReadings:
    """Readings of one sweep, with the attributes of ``sensor_msgs/LaserScan``."""

    angle_min: float
    angle_increment: float
    time_increment: float
    range_min: float
    range_max: float
    ranges: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class LaserPoints:
    """
    Points of a planar scanner in one sweep.

    ``points (P, 3) float32`` [m] have z = 0 in the scanner's frame. ``time_s (P,) float64`` is the
    time since the first ray, which is the message's stamp; it is zero if the message has no time
    between rays. Rays without a valid range are left out.
    """

    points: NDArray[np.float32]
    time_s: NDArray[np.float64]


def decode_laser(scan: LaserScanLike) -> LaserPoints:
    """
    Return the points of a LaserScan or MultiEchoLaserScan.

    Only ranges from ``range_min`` to below ``range_max`` are used. NaN, infinity and other values
    may mean no echo or too near; drivers differ. Many write ``range_max`` for no echo: used as a
    return it would clear walls in front of it, and AMCL skips it as well. Of several echoes the
    nearest valid one is used: glass is drawn as a wall, and the space behind it is not free for
    the robot. ``angle_max`` is ignored, because drivers are often off by one.

    Raises
    ------
    CloudFormatError
        If limits, angles or times are impossible.
    """
    _check_limits(scan)
    ranges = _nearest_ranges(scan)
    index = np.flatnonzero(_valid(ranges, scan))
    _check_angles(scan, len(ranges))
    angles = scan.angle_min + scan.angle_increment * index
    points = np.zeros((len(index), 3), dtype=np.float32)
    points[:, 0] = ranges[index] * np.cos(angles)
    points[:, 1] = ranges[index] * np.sin(angles)
    time_s = index.astype(np.float64) * _time_step_s(scan, len(ranges))
    return LaserPoints(points, time_s)


def _check_limits(scan: LaserScanLike) -> None:
    low, high = scan.range_min, scan.range_max
    if math.isnan(low) or math.isnan(high) or high <= max(low, 0.0):
        raise CloudFormatError(
            f'laser scan: range_max {high} m is not above range_min {low} m; the driver did not '
            'set one of them'
        )


def _check_angles(scan: LaserScanLike, count: int) -> None:
    first, step = scan.angle_min, scan.angle_increment
    if not (math.isfinite(first) and math.isfinite(step)):
        raise CloudFormatError(
            f'laser scan: angle_min {first}, angle_increment {step}; expected finite radians'
        )
    if count > 1 and step == 0.0:
        raise CloudFormatError(
            f'laser scan: angle_increment is 0 for {count} rays; the driver did not set it'
        )
    turns = abs(step) * (count - 1) / (2.0 * math.pi)
    if turns > _MOST_TURNS:
        raise CloudFormatError(
            f'laser scan: {count} rays at angle_increment {step} make {turns:.1f} turns; expected '
            'radians, and at most one turn'
        )


def _time_step_s(scan: LaserScanLike, count: int) -> float:
    step_s = float(scan.time_increment)
    if not abs(step_s) * max(count - 1, 1) <= LONGEST_SWEEP_S:  # also refuses NaN
        raise CloudFormatError(
            f'laser scan: {count} rays at time_increment {step_s} s; expected seconds, and a '
            f'sweep of at most {LONGEST_SWEEP_S:.0f} s'
        )
    return step_s


def _nearest_ranges(scan: LaserScanLike) -> NDArray[np.float64]:
    """Return the nearest valid range of each ray ``(N,)``."""
    ranges = scan.ranges
    if not len(ranges) or not hasattr(ranges[0], 'echoes'):
        return np.asarray(ranges, dtype=np.float64)
    echoes = [np.asarray(ray.echoes, dtype=np.float64) for ray in ranges]
    every = np.concatenate(echoes)
    is_valid = _valid(every, scan)
    ray = np.repeat(np.arange(len(echoes)), [len(own) for own in echoes])
    nearest = np.full(len(echoes), np.inf)
    np.minimum.at(nearest, ray[is_valid], every[is_valid])
    return nearest


def _valid(ranges: NDArray[np.float64], scan: LaserScanLike) -> NDArray[np.bool_]:
    # Comparisons with NaN are false.
    valid: NDArray[np.bool_] = (ranges >= max(scan.range_min, 0.0)) & (ranges < scan.range_max)
    return valid & np.isfinite(ranges) & (ranges > 0.0)
