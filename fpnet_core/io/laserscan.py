# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The readings of ``sensor_msgs/LaserScan`` and ``MultiEchoLaserScan``, as points.

Functions read a message's attributes only, so messages of rclpy and of rosbags both work and the
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

# Physical: scanners of a full turn repeat a few rays; degrees in place of radians are 57 turns.
_MOST_TURNS = 1.1


class LaserScanLike(Protocol):
    """What a message of planar readings has, whoever made it."""

    @property
    def angle_min(self) -> float:
        """Angle of the first ray [rad], from x to y."""

    @property
    def angle_increment(self) -> float:
        """Angle between two rays [rad]; negative: clockwise."""

    @property
    def time_increment(self) -> float:
        """Time between two rays [s]; 0: all at once, or unknown."""

    @property
    def range_min(self) -> float:
        """Least valid range [m]."""

    @property
    def range_max(self) -> float:
        """Valid ranges are shorter [m]; many drivers write it for no return."""

    @property
    def ranges(self) -> Any:
        """Range of each ray [m], or its echoes."""


@dataclass(frozen=True, eq=False)
class LaserReadings:
    """What a driver reports of one sweep, with the attributes of ``sensor_msgs/LaserScan``."""

    angle_min: float
    angle_increment: float
    time_increment: float
    range_min: float
    range_max: float
    ranges: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class LaserPoints:
    """
    What a planar scanner saw in one sweep.

    ``points (P, 3) float32`` [m] lie in z = 0 of the scanner's frame; ``time_s (P,) float64``
    counts from the first ray, which is the instant of the message's stamp, and is zero where the
    message tells no time between rays. Rays without a valid range are left out.
    """

    points: NDArray[np.float32]
    time_s: NDArray[np.float64]


def decode_laser(scan: LaserScanLike) -> LaserPoints:
    """
    Return the points of a LaserScan or MultiEchoLaserScan.

    Rays without a range from ``range_min`` to below ``range_max`` are left out, NaN and infinity
    among them; they may be no echo or too near, and drivers do not agree which. Many write
    ``range_max`` itself for no echo: taken for a return it would open the walls before it, and
    AMCL leaves it out as well. Of several echoes
    of a ray the nearest valid one counts: glass is drawn as a wall, and nothing behind it is free
    for the robot. ``angle_max`` is not read: drivers are often off by one there.

    Raises
    ------
    CloudFormatError
        If the message contradicts itself: limits, angles or times that cannot be.
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
            f'laser scan: range_max {high} m is not above range_min {low} m; the driver leaves '
            'one of them unset'
        )


def _check_angles(scan: LaserScanLike, count: int) -> None:
    first, step = scan.angle_min, scan.angle_increment
    if not (math.isfinite(first) and math.isfinite(step)):
        raise CloudFormatError(
            f'laser scan: angle_min {first}, angle_increment {step}; expected finite radians'
        )
    if count > 1 and step == 0.0:
        raise CloudFormatError(
            f'laser scan: angle_increment is 0 for {count} rays; the driver leaves it unset'
        )
    turns = abs(step) * (count - 1) / (2.0 * math.pi)
    if turns > _MOST_TURNS:
        raise CloudFormatError(
            f'laser scan: {count} rays at angle_increment {step} make {turns:.1f} turns; expected '
            'radians, and at most one turn'
        )


def _time_step_s(scan: LaserScanLike, count: int) -> float:
    step_s = float(scan.time_increment)
    if not abs(step_s) * max(count - 1, 1) <= LONGEST_SWEEP_S:  # NaN is refused as well
        raise CloudFormatError(
            f'laser scan: {count} rays at time_increment {step_s} s; expected seconds, and a '
            f'sweep of at most {LONGEST_SWEEP_S:.0f} s'
        )
    return step_s


def _nearest_ranges(scan: LaserScanLike) -> NDArray[np.float64]:
    """Return one range for each ray ``(N,)``."""
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
    # NaN fails every comparison.
    valid: NDArray[np.bool_] = (ranges >= max(scan.range_min, 0.0)) & (ranges < scan.range_max)
    return valid & np.isfinite(ranges) & (ranges > 0.0)
