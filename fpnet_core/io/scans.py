# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scan types that the readers of all recording formats yield."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry.motion import carried
from fpnet_core.stamps import NS_PER_S


@dataclass(frozen=True, eq=False)
class Scan:
    """
    One sweep of a lidar.

    Parameters
    ----------
    stamp_ns
        Time of the last point, to which poses refer; the middle of the sweep if points have no
        times.
    points : (P, 3) float32
        Finite returns, sensor frame [m]; z = 0 for planar scanners. For planar scanners mounted
        on a robot, the sensor frame is the robot's base.
    time_s : (P,) float64
        Times of the points since the first one [s]; None if the recording has none.
    T_odom_sensor : (4, 4) float64
        Pose from the recording; None for raw clouds, which need odometry (see
        :class:`fpnet_core.odometry.KissOdometry`).
    T_truth_sensor : (4, 4) float64
        Ground truth in its own frame, for evaluation only; None unless requested.
    viewpoints : (P, 3) float32
        Origin of each point's ray, sensor frame [m]; None means the frame's origin. Merged
        scanners have different origins in one sweep.
    T_base_sensor : (4, 4) float64
        Mount of the sensor on the robot, whose base is level; None if unknown, and then the
        sensor is assumed to be level.
    R_gyro_sensor : (3, 3) float64
        Orientation from a gyroscope at the stamp, in a slowly drifting frame; None without one.
    """

    stamp_ns: int
    points: NDArray[np.float32]
    time_s: NDArray[np.float64] | None = None
    T_odom_sensor: NDArray[np.float64] | None = None
    T_truth_sensor: NDArray[np.float64] | None = None
    viewpoints: NDArray[np.float32] | None = None
    T_base_sensor: NDArray[np.float64] | None = None
    R_gyro_sensor: NDArray[np.float64] | None = None

    @property
    def first_ns(self) -> int:
        """Time of the first point; the stamp if points have no times."""
        if self.time_s is None or not len(self.time_s):
            return self.stamp_ns
        return self.stamp_ns - round(float(self.time_s.max()) * NS_PER_S)

    def without_motion(
        self, T_before_now: NDArray[np.float64], seconds: float | None = None
    ) -> Self:
        """
        Deskew: return all points relative to the sensor's pose at the stamp.

        ``T_before_now`` is the motion over the last ``seconds``; None: since the first point.
        """
        if self.time_s is None or self.first_ns == self.stamp_ns:
            return self
        last_s = float(self.time_s.max())
        share = (self.time_s - last_s) / (seconds or last_s)
        begins = self.viewpoints
        if begins is not None:
            begins = carried(begins, T_before_now, share).astype(np.float32)
        points = carried(self.points, T_before_now, share).astype(np.float32)
        return replace(self, points=points, viewpoints=begins, time_s=None)


@dataclass(frozen=True, eq=False)
class RegisteredSweep:
    """
    A deskewed sweep with its pose.

    Parameters
    ----------
    points : (Q, 3) float32
        In the sensor frame at the end of the sweep [m].
    T_odom_sensor : (4, 4) float64
        Pose at that time.
    viewpoints : (Q, 3) float32
        Origins of the points' rays in the same frame; None means the frame's origin.
    """

    points: NDArray[np.float32]
    T_odom_sensor: NDArray[np.float64]
    viewpoints: NDArray[np.float32] | None = None


class ScanSource(Protocol):
    """Recorded scans in time order; can be iterated again."""

    @property
    def kind(self) -> Literal['bag', 'carmen', 'folder']:
        """Storage format of the scans."""

    @property
    def has_poses(self) -> bool:
        """Whether scans have ``T_odom_sensor``."""

    def __len__(self) -> int:
        """Return the number of scans, an upper bound if some have no pose and are skipped."""

    def __iter__(self) -> Iterator[Scan]:
        """Yield the scans."""
