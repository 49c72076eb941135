# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What every recording of lidar scans yields, whatever it is stored in."""

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
        Sensor time of the last point, which is the instant that poses are of; where points have
        no times of their own, that of the middle of the sweep.
    points : (P, 3) float32
        Finite returns, sensor frame [m]; a planar scanner's lie in z = 0. Where planar scanners
        are mounted on a robot, its base is the sensor.
    time_s : (P,) float64
        Times of the points since the first one; None if the recording has none.
    T_odom_sensor : (4, 4) float64
        Pose that the recording brings; None for raw clouds, which need an odometry (see
        :class:`fpnet_core.odometry.KissOdometry`).
    T_truth_sensor : (4, 4) float64
        Ground truth in its own frame, for evaluation only; None unless asked for.
    viewpoints : (P, 3) float32
        Where each point's ray began, sensor frame [m]; None: in its origin. Those of several
        scanners in one sweep begin in different places.
    T_base_sensor : (4, 4) float64
        Place of the sensor on the robot, whose base is level; None: nobody knows, and the sensor
        is taken to be.
    R_gyro_sensor : (3, 3) float64
        Orientation at the stamp by a gyroscope, in a frame that drifts slowly; None without one.
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
        """The instant of the first point; the stamp where points have no times."""
        if self.time_s is None or not len(self.time_s):
            return self.stamp_ns
        return self.stamp_ns - round(float(self.time_s.max()) * NS_PER_S)

    def without_motion(
        self, T_before_now: NDArray[np.float64], seconds: float | None = None
    ) -> Self:
        """
        Return all points as seen at the stamp, given the sensor's motion up to it.

        ``seconds`` are those that the motion took; None: since the first point.
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
    A sweep and where it was taken.

    Parameters
    ----------
    points : (Q, 3) float32
        As seen from where the sensor was at the end of the sweep [m].
    T_odom_sensor : (4, 4) float64
        Pose at that instant.
    viewpoints : (Q, 3) float32
        Where the points' rays began, in the same frame; None: in its origin.
    """

    points: NDArray[np.float32]
    T_odom_sensor: NDArray[np.float64]
    viewpoints: NDArray[np.float32] | None = None


class ScanSource(Protocol):
    """Recorded scans in time order; can be iterated again."""

    @property
    def kind(self) -> Literal['bag', 'carmen', 'folder']:
        """What the scans are stored in."""

    @property
    def has_poses(self) -> bool:
        """Whether scans bring ``T_odom_sensor``."""

    def __len__(self) -> int:
        """Count the scans, an upper bound where some have no pose and are left out."""

    def __iter__(self) -> Iterator[Scan]:
        """Yield the scans."""
