# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""KISS-ICP lidar odometry, guarded; the offline runner and the odometry node share it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

from kiss_icp.config import KISSConfig
from kiss_icp.kiss_icp import KissICP
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import OdometryConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.stamps import ClockGuard

if TYPE_CHECKING:
    from fpnet_core.io.scans import Scan

MIN_POINTS = 100
"""A sweep with fewer returns within range moves the estimate at random; it is refused."""

STALE_BEFORE_RESTART = 3
"""Old sweeps in a row that are a clock that went back; fewer are disorder on the way here."""

_log = logging.getLogger(__name__)

_FLAT_M = 0.01
"""Sweeps that are lower than this [m] are those of a planar scanner."""


class RegisteredSweep(NamedTuple):
    """
    A sweep and where it was taken.

    ``T_odom_sensor (4, 4)`` is the pose at the end of the sweep, as KISS-ICP deskews towards the
    last point's time; ``points (Q, 3) float64`` are those within range [m], Q <= P, in the
    sensor frame at that instant.
    """

    T_odom_sensor: NDArray[np.float64]
    points: NDArray[np.float64]


class KissOdometry:
    """
    Register sweeps one after another with KISS-ICP (Vizzo et al., RA-L 2023).

    The odometry frame ``odom`` is the sensor's pose at the first sweep, which also tells a planar
    scanner from others: its sweeps are flat, and its map gets voxels of its own. KISS-ICP keeps
    one point in one and a half voxels; of a single beam that would leave a few dozen. A refused
    sweep leaves the state as it was.
    """

    def __init__(self, config: OdometryConfig) -> None:
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget the map and start again at identity."""
        self._kiss: KissICP | None = None
        self._newest_ns: int | None = None
        self._clock = ClockGuard(STALE_BEFORE_RESTART)

    def _started(self, first: NDArray[np.float64]) -> KissICP:
        """Return an empty odometry for the kind of scanner that saw ``first (P, 3)``."""
        config = self._config
        is_planar = float(np.ptp(first[:, 2])) < _FLAT_M
        voxel_size = config.planar_voxel_size if is_planar else config.voxel_size
        return KissICP(
            KISSConfig(
                data={
                    'max_range': config.max_range,
                    'min_range': config.min_range,
                    'deskew': config.deskew,
                },
                mapping={'voxel_size': voxel_size},
            )
        )

    def register(
        self, points: NDArray[np.floating], time_s: NDArray[np.float64] | None
    ) -> RegisteredSweep:
        """
        Return where a sweep was taken, and its points without the motion during the sweep.

        Parameters
        ----------
        points : (P, 3)
            Sensor frame [m]; points that are not finite or out of range are left out.
        time_s : (P,)
            Times of the points, any origin; None registers the sweep without deskewing.

        Raises
        ------
        CloudFormatError
            If shapes disagree or fewer than ``MIN_POINTS`` points are in range.
        """
        sweep: NDArray[np.float64] = np.asarray(points, dtype=np.float64)
        if sweep.ndim != 2 or sweep.shape[1] != 3:
            raise CloudFormatError(f'sweep: expected points (P, 3), got {sweep.shape}')
        usable = self._in_range(sweep)
        if np.count_nonzero(usable) < MIN_POINTS:
            raise CloudFormatError(
                f'sweep has {np.count_nonzero(usable)} of {len(sweep)} points within '
                f'{self._config.min_range} to {self._config.max_range} m; expected at least '
                f'{MIN_POINTS}: check the sensor and the odometry ranges'
            )
        times = self._usable_times(time_s, usable)
        if self._kiss is None:
            self._kiss = self._started(sweep[usable])
        deskewed, _ = self._kiss.register_frame(sweep[usable], times)
        return RegisteredSweep(self._kiss.last_pose.copy(), np.asarray(deskewed))

    def register_scan(self, scan: Scan) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """
        Return deskewed points (Q, 3) float32 and ``T_odom_sensor (4, 4)`` of a scan.

        Where the clock went back the odometry begins anew.

        Raises
        ------
        OdometryError
            If the scan is no newer than the last one.
        CloudFormatError
            As :meth:`register`.
        """
        last_ns = scan.stamp_ns - 1 if self._newest_ns is None else self._newest_ns
        back_s = self._clock.back_s(scan.stamp_ns, last_ns)
        if back_s is not None:
            _log.warning('the clock went back by %.3f s; odometry starts anew', back_s)
            self.reset()
        self._newest_ns = scan.stamp_ns
        sweep = self.register(scan.points, scan.time_s)
        return sweep.points.astype(np.float32), sweep.T_odom_sensor

    def _in_range(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        # NaN fails both comparisons; infinity fails the second.
        distance = np.sqrt(np.einsum('pi,pi->p', points, points))
        usable: NDArray[np.bool_] = (distance > self._config.min_range) & (
            distance < self._config.max_range
        )
        return usable

    @staticmethod
    def _usable_times(
        time_s: NDArray[np.float64] | None, usable: NDArray[np.bool_]
    ) -> NDArray[np.float64]:
        """Return the times of the usable points, or none at all if they cannot deskew."""
        none = np.zeros(0)
        if time_s is None:
            return none
        times: NDArray[np.float64] = np.asarray(time_s, dtype=np.float64)
        if times.shape != usable.shape:
            raise CloudFormatError(f'sweep: {len(usable)} points but times {times.shape}')
        times = times[usable]
        # KISS-ICP scales times to [0, 1]: without a spread it would abort the process.
        return times if np.isfinite(times).all() and np.ptp(times) > 0.0 else none
