# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""KISS-ICP lidar odometry, guarded; the offline runner and the odometry node share it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kiss_icp.config import KISSConfig
from kiss_icp.kiss_icp import KissICP
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import OdometryConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry.motion import carried
from fpnet_core.io.scans import RegisteredSweep
from fpnet_core.stamps import NS_PER_S

if TYPE_CHECKING:
    from fpnet_core.io.scans import Scan

MIN_POINTS = 100
"""A sweep with fewer returns within range moves the estimate at random; it is refused. Chosen."""

_FLAT_M = 0.01
"""Sweeps that are lower than this [m] are those of a planar scanner. Chosen."""


class KissOdometry:
    """
    Register sweeps one after another with KISS-ICP (Vizzo et al., RA-L 2023).

    The odometry frame ``odom`` is the sensor's pose at the first sweep, which also tells planar
    scanners from others: their sweeps are flat. Two things are different for them. The map gets
    voxels of its own: KISS-ICP keeps one point in one and a half voxels, which of a single beam
    would leave a few dozen. And they are deskewed here, by the motion since the last sweep's
    stamp: KISS-ICP takes every sweep for a whole turn, where a scanner of 270 degrees fires
    during three quarters of one, and two scanners together during more. What is flat stays so:
    no motion out of the plane brings flat sweeps nearer to a flat map.

    A refused sweep leaves the state as it was.
    """

    def __init__(self, config: OdometryConfig) -> None:
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget the map and start again at identity."""
        self._kiss: KissICP | None = None
        self._is_planar = False
        self._last_ns: int | None = None
        self._period_ns = 0

    def _started(self, first: NDArray[np.float64]) -> KissICP:
        """Return an empty odometry for the kind of scanner that saw ``first (P, 3)``."""
        config = self._config
        self._is_planar = float(np.ptp(first[:, 2])) < _FLAT_M
        voxel_size = config.planar_voxel_size if self._is_planar else config.voxel_size
        return KissICP(
            KISSConfig(
                data={
                    'max_range': config.max_range,
                    'min_range': config.min_range,
                    'deskew': config.deskew and not self._is_planar,
                },
                mapping={'voxel_size': voxel_size},
            )
        )

    def register(
        self,
        points: NDArray[np.floating],
        time_s: NDArray[np.float64] | None,
        stamp_ns: int | None = None,
        viewpoints: NDArray[np.floating] | None = None,
    ) -> RegisteredSweep:
        """
        Return where a sweep was taken, and its points without the motion during the sweep.

        Parameters
        ----------
        points : (P, 3)
            Sensor frame [m]; points that are not finite or out of range are left out.
        time_s : (P,)
            Times of the points, any origin; None registers the sweep without deskewing.
        stamp_ns : int
            Of the sweep; two of them tell how long a motion took that was found. None: as long
            as the sweep.
        viewpoints : (P, 3)
            Where rays of planar scanners began, sensor frame [m]; None: in its origin. Of other
            sensors they are not kept.

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
        if self._is_planar:
            seen_from = None if viewpoints is None else np.asarray(viewpoints)[usable]
            found = self._register_planar(self._kiss, sweep[usable], times, seen_from)
        else:
            deskewed, _ = self._kiss.register_frame(sweep[usable], times)
            found = RegisteredSweep(
                np.asarray(deskewed, dtype=np.float32), self._kiss.last_pose.copy()
            )
        if stamp_ns is not None:
            last_ns, self._last_ns = self._last_ns, stamp_ns
            self._period_ns = 0 if last_ns is None else max(0, stamp_ns - last_ns)
        return found

    def register_scan(self, scan: Scan) -> RegisteredSweep:
        """Return where a scan was taken, and its points; see :meth:`register`."""
        return self.register(scan.points, scan.time_s, scan.stamp_ns, scan.viewpoints)

    def _register_planar(
        self,
        kiss: KissICP,
        sweep: NDArray[np.float64],
        times: NDArray[np.float64],
        viewpoints: NDArray[np.float64] | None,
    ) -> RegisteredSweep:
        if self._config.deskew and len(times):
            period_s = self._period_ns / NS_PER_S or float(np.ptp(times))
            share = (times - times.max()) / period_s
            sweep = carried(sweep, kiss.last_delta, share)
            if viewpoints is not None:
                viewpoints = carried(viewpoints, kiss.last_delta, share)
        kiss.register_frame(sweep, np.zeros(0))
        return RegisteredSweep(
            sweep.astype(np.float32),
            kiss.last_pose.copy(),
            None if viewpoints is None else viewpoints.astype(np.float32),
        )

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
