# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""KISS-ICP lidar odometry, guarded; the offline runner and the odometry node share it."""

from __future__ import annotations

from collections.abc import Callable
import logging
from typing import TYPE_CHECKING

from kiss_icp.config import KISSConfig
from kiss_icp.kiss_icp import KissICP
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import OdometryConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry.motion import carried, part_of
from fpnet_core.geometry.voxels import voxel_means
from fpnet_core.io.scans import RegisteredSweep
from fpnet_core.odometry.deskew_detection import DeskewDetector, turn_shares
from fpnet_core.odometry.registration import (
    MIN_POINTS,
    deskewed,
    placed,
    register_planar,
    register_sweep,
    upright,
)
from fpnet_core.odometry.yaw_search import Guess, YawSearch
from fpnet_core.stamps import NS_PER_S, ClockGuard

if TYPE_CHECKING:
    from fpnet_core.io.scans import Scan

Array = NDArray[np.float64]

STALE_BEFORE_RESTART = 3
"""Old sweeps in a row that are a clock that went back; fewer are disorder. Chosen."""

_log = logging.getLogger(__name__)

_FLAT_M = 0.01
"""Sweeps that are lower than this [m] are those of a planar scanner. Chosen."""

_AT_ONCE = np.zeros(0)  # given: no times
_END, _MIDDLE = 0.5, 0.0  # given: instants of poses, in periods from the middle of the sweep


def _warn(back_s: float) -> None:
    _log.warning('the clock went back by %.3f s; odometry starts anew', back_s)


class KissOdometry:
    """
    Register sweeps one after another with KISS-ICP (Vizzo et al., RA-L 2023).

    The odometry frame ``odom`` is the robot's pose at the first sweep, the sensor's where nobody
    knows its place on the robot. That sweep also tells planar scanners from others: theirs are
    flat. Two things are different for them. The map gets voxels of its own, and all that it
    takes of a sweep registers: one point in one and a half voxels, as of others, would leave a
    few dozen of a single beam. And they are deskewed here, with the places that their rays began
    at.
    What is flat stays so: no motion out of the plane brings flat sweeps nearer to a flat map.
    Of other sweeps, what stands tells the place and what lies the level: see
    :mod:`fpnet_core.odometry.registration`. Those without times are deskewed to their middle if
    the map says that they need it: see :mod:`fpnet_core.odometry.deskew_detection`.

    All others are deskewed by the motion since the last sweep's stamp, for the share of that time
    that a point was seen before the end: a scanner of 270 degrees fires during three quarters of
    a turn, and one that looks into the open sees nothing in range for a part of it. The motion,
    which the registration begins with as well, is that of the last two sweeps, turned as a
    gyroscope says, or as the walls of the last sweeps say where that is more likely: see
    :mod:`fpnet_core.odometry.yaw_search`. Where scans bring poses of another odometry, it is that
    one's.

    A refused sweep leaves the state as it was.
    """

    def __init__(
        self, config: OdometryConfig, on_restart: Callable[[float], None] = _warn
    ) -> None:
        self._config, self._on_restart = config, on_restart
        voxel_means(np.zeros((1, 3)), 1.0)  # compiled before the first sweep waits for it
        self.reset()

    def reset(self, T_odom_sensor: Array | None = None) -> None:
        """Forget the map and start again, in a new frame unless told where the sensor is."""
        self._kiss: KissICP | None = None
        self._first: Scan | None = None  # until the second one tells how the sensor moved
        self._first_motion = np.eye(4)
        self._clock = ClockGuard(STALE_BEFORE_RESTART)
        self._turning = DeskewDetector(is_decided=not self._config.deskew)
        self._is_planar = False
        self._start = T_odom_sensor
        self._last_ns: int | None = None
        self._period_ns = 0
        self._T_guess_last: Array | None = None
        self._R_gyro_last: Array | None = None
        self._told: Array | None = None
        self._turned: Array | None = None
        self._search = YawSearch()
        self._T_start_end: Array | None = None  # of the last sweep, where the walls have told it

    @property
    def pose(self) -> Array:
        """``T_odom_sensor (4, 4)`` of the last sweep."""
        return np.eye(4) if self._kiss is None else self._kiss.last_pose

    @property
    def last_motion(self) -> Array:
        """The sensor's motion ``(4, 4)`` between the last two sweeps."""
        return np.eye(4) if self._kiss is None else self._kiss.last_delta

    @property
    def map_points(self) -> Array:
        """Points ``(P, 3)`` of the local map, odometry frame [m]; a copy."""
        if self._kiss is None:
            return np.zeros((0, 3))
        return np.asarray(self._kiss.local_map.point_cloud(), dtype=np.float64).reshape(-1, 3)

    def _started(self, first: Array, T_base_sensor: Array | None) -> KissICP:
        """Return an empty odometry for the kind of scanner that saw ``first (P, 3)``."""
        config = self._config
        self._is_planar = float(np.ptp(first[:, 2])) < _FLAT_M
        voxel_size = config.planar_voxel_size if self._is_planar else config.voxel_size
        kiss = KissICP(
            KISSConfig(
                data={
                    'max_range': config.max_range,
                    'min_range': config.min_range,
                    'deskew': config.deskew and not self._is_planar,
                },
                mapping={'voxel_size': voxel_size},
            )
        )
        start = T_base_sensor if self._start is None else self._start
        kiss.last_pose = np.eye(4) if start is None else start
        kiss.last_delta = self._first_motion
        return kiss

    def register_scan(self, scan: Scan) -> RegisteredSweep:
        """
        Return where a scan was taken, and its points without the motion during it.

        Points that are not finite or out of range are left out, and so are viewpoints of sensors
        that are not planar. A pose that the scan brings, of another odometry in any frame that
        stays, is the guess. Its place on the robot counts where it is the first. Where the clock
        went back the odometry begins anew.

        Raises
        ------
        OdometryError
            If the scan is no newer than the last one.
        CloudFormatError
            If shapes disagree or fewer than ``MIN_POINTS`` points are in range.
        """
        if self._last_ns is not None:
            back_s = self._clock.back_s(scan.stamp_ns, self._last_ns)
            if back_s is not None:
                self._on_restart(back_s)
                self.reset()
        first = self._first
        registered = self._registered(scan)
        if first is None:
            return registered
        self._begin_again(first)
        return self._registered(scan)

    def _begin_again(self, first: Scan) -> None:
        """
        Take the first sweep once more, without its motion, which the second one has told.

        Nobody knew it when that sweep made the map. In the mean its points were seen a share of
        a period before its end, which is where the map has them seen from: of an even motion the
        second sweep tells that share too much.
        """
        assert self._kiss is not None
        assert first.time_s is not None
        T_first = self._kiss.last_pose @ np.linalg.inv(self._kiss.last_delta)
        late = -float(self._share_of_period(first.time_s).mean())
        motion = part_of(self._kiss.last_delta, 1.0 / (1.0 + late))
        period_ns = self._period_ns
        self.reset(T_first @ np.linalg.inv(motion))
        self._first_motion, self._last_ns = motion, first.stamp_ns - period_ns
        self._registered(first)
        self._first = None

    def _registered(self, scan: Scan) -> RegisteredSweep:
        sweep: Array = np.asarray(scan.points, dtype=np.float64)
        if sweep.ndim != 2 or sweep.shape[1] != 3:
            raise CloudFormatError(f'sweep: expected points (P, 3), got {sweep.shape}')
        usable = self._in_range(sweep)
        times = self._usable_times(scan.time_s, len(sweep))
        if self._kiss is None:
            self._kiss = self._started(sweep[usable], scan.T_base_sensor)
            self._first = scan if len(times) and self._config.deskew else None
        last_ns, self._last_ns = self._last_ns, scan.stamp_ns
        self._period_ns = 0 if last_ns is None else scan.stamp_ns - last_ns
        self._note_guess(scan.T_odom_sensor, scan.R_gyro_sensor)
        share = self._share_of_period(times)
        share = share[usable] if len(share) else share
        if self._is_planar:
            seen_from = None if scan.viewpoints is None else scan.viewpoints[usable]
            return self._register_planar(self._kiss, sweep[usable], share, seen_from)
        if len(times):
            points = self._register_timed(self._kiss, sweep[usable], share)
        else:
            points = self._register_untimed(self._kiss, sweep, usable)
        return RegisteredSweep(points.astype(np.float32), self._kiss.last_pose.copy())

    def _note_guess(self, T_guess_sensor: Array | None, R_gyro_sensor: Array | None) -> None:
        """Note the motion since the last sweep by another odometry, and by a gyroscope."""
        T_last, self._T_guess_last = self._T_guess_last, T_guess_sensor
        R_last, self._R_gyro_last = self._R_gyro_last, R_gyro_sensor
        self._told = self._turned = None
        if T_last is not None and T_guess_sensor is not None:
            self._told = np.linalg.inv(T_last) @ T_guess_sensor
        if R_last is not None and R_gyro_sensor is not None:
            self._turned = R_last.T @ R_gyro_sensor

    def _best(self, kiss: KissICP, sweep: Array, share: Array, instant: float = _END) -> Guess:
        """Return where and how the sensor moved; ``share (P,)`` in periods to its instant."""
        if self._told is not None:
            self._T_start_end = None
            return Guess.moved(kiss.last_pose, self._told)
        motion, by_gyro = kiss.last_delta.copy(), None
        if self._T_start_end is not None:
            motion[:3, :3] = self._T_start_end[:3, :3]
        guess = Guess.moved(kiss.last_pose, motion)
        if self._turned is not None:
            motion[:3, :3] = self._turned
            by_gyro = Guess.moved(kiss.last_pose, motion)
        is_wall = upright(placed(sweep, guess.T_odom_sensor)) | self._is_planar
        share = share[is_wall] if len(share) else share
        best, is_found = self._search.best(guess, by_gyro, sweep[is_wall], share, instant)
        self._T_start_end = best.T_start_end if is_found else None
        return best

    def _share_of_period(self, times: Array) -> Array:
        """Return when points were seen, from the sweep's end back, by the time of a motion."""
        if not len(times) or not self._config.deskew:
            return np.zeros(0)
        period_s = self._period_ns / NS_PER_S or float(np.ptp(times))
        share: Array = (times - times.max()) / period_s
        return share

    def _register_timed(self, kiss: KissICP, sweep: Array, share: Array) -> Array:
        """Register a sweep with times, and return its points as seen from its end."""
        best = self._best(kiss, sweep, share)
        points = deskewed(kiss, sweep, share, best.T_start_end) if len(share) else sweep
        self._take(kiss, register_sweep(kiss, points, best.T_odom_sensor))
        return points

    def _register_untimed(self, kiss: KissICP, sweep: Array, usable: NDArray[np.bool_]) -> Array:
        """Register a sweep without times as of its middle, and return its points in range."""
        turning, shares = self._turning, None
        if turning.part or not turning.is_decided:
            shares = turn_shares(sweep)  # of all points: where it begins is no matter of range
        sweep = sweep[usable]
        shares = _AT_ONCE if shares is None else shares[usable] - 0.5
        bent = turning.part * shares if turning.part else _AT_ONCE
        best = self._best(kiss, sweep, bent, _MIDDLE)
        points = carried(sweep, best.T_start_end, bent) if len(bent) else sweep
        self._take(kiss, register_sweep(kiss, points, best.T_odom_sensor))
        if len(shares) and not turning.is_decided:
            turning.look(sweep, shares, kiss.last_pose, kiss.last_delta)
        return points

    def _register_planar(
        self,
        kiss: KissICP,
        sweep: Array,
        share: Array,
        viewpoints: NDArray[np.floating] | None,
    ) -> RegisteredSweep:
        best = self._best(kiss, sweep, share)
        if len(share):
            sweep = carried(sweep, best.T_start_end, share)
            if viewpoints is not None:
                viewpoints = carried(viewpoints, best.T_start_end, share)
        self._take(kiss, register_planar(kiss, sweep, best.T_odom_sensor))
        return RegisteredSweep(
            sweep.astype(np.float32),
            kiss.last_pose.copy(),
            None if viewpoints is None else viewpoints.astype(np.float32),
        )

    def _take(self, kiss: KissICP, walls: Array) -> None:
        """Take walls of a registered sweep ``(P, 3)``, sensor frame [m], for the next ones."""
        self._search.note(placed(walls, kiss.last_pose))

    def _in_range(self, points: Array) -> NDArray[np.bool_]:
        # NaN fails both comparisons; infinity fails the second.
        distance = np.sqrt(np.einsum('pi,pi->p', points, points))
        usable: NDArray[np.bool_] = (distance > self._config.min_range) & (
            distance < self._config.max_range
        )
        if np.count_nonzero(usable) < MIN_POINTS:
            raise CloudFormatError(
                f'sweep has {np.count_nonzero(usable)} of {len(points)} points within '
                f'{self._config.min_range} to {self._config.max_range} m; expected at least '
                f'{MIN_POINTS}: check the sensor and the odometry ranges'
            )
        return usable

    @staticmethod
    def _usable_times(time_s: Array | None, count: int) -> Array:
        """Return the times of the points, or none at all if they cannot deskew."""
        none = np.zeros(0)
        if time_s is None:
            return none
        times: Array = np.asarray(time_s, dtype=np.float64)
        if times.shape != (count,):
            raise CloudFormatError(f'sweep: {count} points but times {times.shape}')
        # KISS-ICP scales times to [0, 1]: without a spread it would abort the process.
        return times if np.isfinite(times).all() and np.ptp(times) > 0.0 else none
