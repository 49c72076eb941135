# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""KISS-ICP lidar odometry, as used offline and by the odometry node."""

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
"""Consecutive old sweeps that count as a clock reset; fewer are out of order. Chosen."""

_log = logging.getLogger(__name__)

_FLAT_M = 0.01
"""Sweeps with a smaller extent in z [m] are from a planar scanner. Chosen."""

_AT_ONCE = np.zeros(0)  # given: no times
_END, _MIDDLE = 0.5, 0.0  # given: reference times of poses, in periods from the sweep's middle


def _warn(back_s: float) -> None:
    _log.warning('the clock went back by %.3f s; odometry restarts', back_s)


class KissOdometry:
    """
    Registers sweeps one after another with KISS-ICP (Vizzo et al., RA-L 2023).

    The odometry frame ``odom`` is the robot's pose at the first sweep, or the sensor's if its
    mount is unknown. A flat first sweep means a planar scanner, which is treated differently in
    two ways. The map has its own voxel size, and all points that go into the map are used for
    registration, as one point per 1.5 voxels would leave only a few dozen of a single beam. And
    the sweeps are deskewed here, together with the origins of their rays. Planar motion stays
    planar: no motion out of the plane improves the fit of a flat sweep to a flat map. For other
    sweeps, upright surfaces give x, y and yaw, and level ones height, roll and pitch: see
    :mod:`fpnet_core.odometry.registration`. Sweeps without times are deskewed to their middle if
    that fits the map better: see :mod:`fpnet_core.odometry.deskew_detection`.

    Sweeps with times are deskewed by the motion since the last stamp. A point's share of that
    motion is its time before the end over the period between stamps, not over the duration of the
    sweep: a 270 degree scanner measures during three quarters of a turn, and in the open a part
    of the turn has no returns. The motion is also the initial guess of the registration: that of
    the last two sweeps, with the rotation of a gyroscope, or of the search in the walls of the
    last sweeps if that is more likely, see :mod:`fpnet_core.odometry.yaw_search`. If scans have
    poses of another odometry, its motion is used.

    A refused sweep leaves the state unchanged.
    """

    def __init__(
        self, config: OdometryConfig, on_restart: Callable[[float], None] = _warn
    ) -> None:
        self._config, self._on_restart = config, on_restart
        voxel_means(np.zeros((1, 3)), 1.0)  # compile now, not at the first sweep
        self.reset()

    def reset(self, T_odom_sensor: Array | None = None) -> None:
        """Clear the map and restart, at ``T_odom_sensor`` or, if None, in a new frame."""
        self._kiss: KissICP | None = None
        self._first: Scan | None = None  # kept until the second one gives the sensor's motion
        self._first_motion = np.eye(4)
        self._clock = ClockGuard(STALE_BEFORE_RESTART)
        self._turning = DeskewDetector(is_decided=not self._config.deskew)
        self._is_planar = False
        self._start = T_odom_sensor
        self._last_ns: int | None = None
        self._period_ns = 0
        self._T_guess_last: Array | None = None
        self._R_gyro_last: Array | None = None
        self._odom_motion: Array | None = None
        self._gyro_rotation: Array | None = None
        self._search = YawSearch()
        self._T_start_end: Array | None = None  # of the last sweep, if found by the yaw search

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

    def _new_kiss(self, first: Array, T_base_sensor: Array | None) -> KissICP:
        """Return an empty odometry for the scanner type of the first sweep ``(P, 3)``."""
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
        Register a scan and return its pose and deskewed points.

        Points that are not finite or out of range are dropped, and so are viewpoints of sensors
        that are not planar. A pose of the scan, from another odometry in any fixed frame, is used
        as initial guess. ``T_base_sensor`` is only used of the first scan. If the clock went back,
        the odometry restarts.

        Raises
        ------
        OdometryError
            If the scan is not newer than the last one.
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
        self._redo_first(first)
        return self._registered(scan)

    def _redo_first(self, first: Scan) -> None:
        """
        Register the first sweep again, deskewed by the motion that the second one has given.

        The motion was unknown when the first sweep made the map. Its points were measured on
        average a share ``late`` of a period before its end, so that the map shows them from there:
        at constant speed the measured motion is too large by that share, which is corrected here.
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
            self._kiss = self._new_kiss(sweep[usable], scan.T_base_sensor)
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
        """Store the motion since the last sweep from another odometry and from a gyroscope."""
        T_last, self._T_guess_last = self._T_guess_last, T_guess_sensor
        R_last, self._R_gyro_last = self._R_gyro_last, R_gyro_sensor
        self._odom_motion = self._gyro_rotation = None
        if T_last is not None and T_guess_sensor is not None:
            self._odom_motion = np.linalg.inv(T_last) @ T_guess_sensor
        if R_last is not None and R_gyro_sensor is not None:
            self._gyro_rotation = R_last.T @ R_gyro_sensor

    def _guess(self, kiss: KissICP, sweep: Array, share: Array, instant: float = _END) -> Guess:
        """Return the best initial guess; ``share (P,)`` in periods relative to the pose's time."""
        if self._odom_motion is not None:
            self._T_start_end = None
            return Guess.moved(kiss.last_pose, self._odom_motion)
        motion, by_gyro = kiss.last_delta.copy(), None
        if self._T_start_end is not None:
            motion[:3, :3] = self._T_start_end[:3, :3]
        guess = Guess.moved(kiss.last_pose, motion)
        if self._gyro_rotation is not None:
            motion[:3, :3] = self._gyro_rotation
            by_gyro = Guess.moved(kiss.last_pose, motion)
        is_wall = upright(placed(sweep, guess.T_odom_sensor)) | self._is_planar
        share = share[is_wall] if len(share) else share
        best, is_found = self._search.best(guess, by_gyro, sweep[is_wall], share, instant)
        self._T_start_end = best.T_start_end if is_found else None
        return best

    def _share_of_period(self, times: Array) -> Array:
        """Return times of points relative to the sweep's end, in periods (<= 0)."""
        if not len(times) or not self._config.deskew:
            return np.zeros(0)
        period_s = self._period_ns / NS_PER_S or float(np.ptp(times))
        share: Array = (times - times.max()) / period_s
        return share

    def _register_timed(self, kiss: KissICP, sweep: Array, share: Array) -> Array:
        """Register a sweep with times; return its points deskewed to its end."""
        best = self._guess(kiss, sweep, share)
        points = deskewed(kiss, sweep, share, best.T_start_end) if len(share) else sweep
        self._add_walls(kiss, register_sweep(kiss, points, best.T_odom_sensor))
        return points

    def _register_untimed(self, kiss: KissICP, sweep: Array, usable: NDArray[np.bool_]) -> Array:
        """Register a sweep without times at its middle; return its points in range."""
        turning, shares = self._turning, None
        if turning.part or not turning.is_decided:
            shares = turn_shares(sweep)  # of all points: the start must not depend on the range
        sweep = sweep[usable]
        shares = _AT_ONCE if shares is None else shares[usable] - 0.5
        skewed_shares = turning.part * shares if turning.part else _AT_ONCE
        best = self._guess(kiss, sweep, skewed_shares, _MIDDLE)
        points = carried(sweep, best.T_start_end, skewed_shares) if len(skewed_shares) else sweep
        self._add_walls(kiss, register_sweep(kiss, points, best.T_odom_sensor))
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
        best = self._guess(kiss, sweep, share)
        if len(share):
            sweep = carried(sweep, best.T_start_end, share)
            if viewpoints is not None:
                viewpoints = carried(viewpoints, best.T_start_end, share)
        self._add_walls(kiss, register_planar(kiss, sweep, best.T_odom_sensor))
        return RegisteredSweep(
            sweep.astype(np.float32),
            kiss.last_pose.copy(),
            None if viewpoints is None else viewpoints.astype(np.float32),
        )

    def _add_walls(self, kiss: KissICP, walls: Array) -> None:
        """Add the walls of a registered sweep ``(P, 3)``, sensor frame [m], to the yaw search."""
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
        """Return the times of the points, or an empty array if they cannot be used to deskew."""
        none = np.zeros(0)
        if time_s is None:
            return none
        times: Array = np.asarray(time_s, dtype=np.float64)
        if times.shape != (count,):
            raise CloudFormatError(f'sweep: {count} points but times {times.shape}')
        # KISS-ICP scales times to [0, 1]; equal times would abort the process.
        return times if np.isfinite(times).all() and np.ptp(times) > 0.0 else none
