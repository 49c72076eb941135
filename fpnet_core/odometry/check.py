# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""KISS-ICP guided by the robot's odometry, with a consistency check of both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
import logging
import math
from typing import TYPE_CHECKING, Any

from kiss_icp.voxelization import voxel_down_sample
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fpnet_core.config import OdometryConfig
from fpnet_core.geometry.pose_track import impossible_turn_rad
from fpnet_core.odometry.kiss import KissOdometry
from fpnet_core.stamps import NS_PER_S

if TYPE_CHECKING:
    from fpnet_core.io.scans import RegisteredSweep, Scan

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

# Chosen, not measured:
_WINDOW_NS = 800_000_000  # with the sweep that ends it, a fault is reported within a second
_APART_M, _APART_RAD = 0.1, math.radians(3.0)  # tolerance for registration and uneven floors
_APART_SHARE = 0.15  # of the motion: worn tyres, an inaccurate wheel base
_REACH_M = 0.5  # larger distances of returns from the map are clipped to this
_VOXEL_M = 0.4  # voxel size of the returns that are compared with the map
_MENDED = 5  # agreeing windows in a row; when driving straight, even mirrored turns agree

_BETTER_M = 0.02
"""
A pose of a sweep is better than another if the returns are this much nearer to the map on
average; smaller differences are inconclusive. Chosen: noise of a lidar indoors.
"""


class Consistency(Enum):
    """Result of comparing KISS-ICP with the robot's odometry."""

    ALONE = 'alone'
    """Only KISS-ICP is available."""
    AGREE = 'agree'
    ROBOT_BROKEN = 'robot_broken'
    KISS_BROKEN = 'kiss_broken'
    UNCLEAR = 'unclear'
    """They disagree, but the scans fit both."""


@dataclass(frozen=True, eq=False)
class _WindowStart:
    """Start of a time window: both poses (4, 4), and the local map at that time."""

    stamp_ns: int
    T_kiss: Array
    T_robot: Array
    map_points: Array


class GuidedOdometry:
    """
    KISS-ICP with initial guesses from the robot's odometry.

    Both motions are compared about every second. If they disagree, the newest sweep is matched at
    both poses with the map from the start of the window: the odometry with the larger distances
    has failed. The robot's odometry is then ignored until both agree again, or KISS-ICP restarts
    at the pose of the robot's odometry, in the same odometry frame. Without poses from the robot,
    KISS-ICP continues alone.

    Parameters
    ----------
    config
        Configuration of KISS-ICP.
    on_restart
        Called with the time by which the clock went back [s].
    say
        Called with a message for each change of the consistency.
    """

    def __init__(
        self,
        config: OdometryConfig,
        on_restart: Callable[[float], None] | None = None,
        say: Callable[[str], Any] = _log.warning,
    ) -> None:
        self._on_restart, self._say = on_restart, say
        self._kiss = KissOdometry(config, self._restart)
        self._window_start: _WindowStart | None = None
        self._T_robot_last: Array | None = None
        self._last_ns = 0
        self._has_flipped = False  # the robot's odometry, since the start of the window
        self._agreements = 0
        self.consistency = Consistency.ALONE

    def register_scan(self, scan: Scan) -> RegisteredSweep:
        """
        Register a scan, as :meth:`KissOdometry.register_scan`.

        ``scan.T_odom_sensor`` is the sensor's pose from the robot's odometry, or None.
        """
        T_robot = scan.T_odom_sensor
        is_flip = self._is_flip(scan)
        self._has_flipped |= is_flip
        if (
            self.consistency is Consistency.ROBOT_BROKEN
            or is_flip
            or not self._is_likely_step(scan)
        ):
            scan = replace(scan, T_odom_sensor=None)
        self._T_robot_last, self._last_ns = T_robot, scan.stamp_ns
        sweep = self._kiss.register_scan(scan)
        if T_robot is None:
            self._window_start = None
            self._set_consistency(Consistency.ALONE, 'a scan had no pose of the robot')
            return sweep
        start = self._window_start
        if start is None:
            self._window_start = self._start_window(scan.stamp_ns, sweep.T_odom_sensor, T_robot)
        elif scan.stamp_ns - start.stamp_ns >= _WINDOW_NS:
            sweep = self._checked_window(start, sweep, T_robot, scan.stamp_ns)
        return sweep

    def _is_flip(self, scan: Scan) -> bool:
        """Return whether the robot's odometry turned impossibly fast since the last scan."""
        before, after = self._T_robot_last, scan.T_odom_sensor
        if before is None or after is None:
            return False
        return impossible_turn_rad(before, after, (scan.stamp_ns - self._last_ns) / NS_PER_S) > 0.0

    def _is_likely_step(self, scan: Scan) -> bool:
        """Return whether a scan matches the robot's last motion; False if that was a jump."""
        if self._T_robot_last is None or scan.T_odom_sensor is None:
            return True
        step, going_on = (
            np.linalg.inv(self._T_robot_last) @ scan.T_odom_sensor,
            self._kiss.last_motion,
        )
        if _is_near(np.linalg.inv(going_on) @ step, going_on):
            return True
        map_points, here = self._kiss.map_points, self._kiss.pose
        return not len(map_points) or _mean_gap_m(
            map_points, scan.points, here @ step
        ) <= _mean_gap_m(map_points, scan.points, here @ going_on)

    def _restart(self, back_s: float) -> None:
        self._window_start = self._T_robot_last = None
        if self._on_restart is not None:
            self._on_restart(back_s)

    def _start_window(self, stamp_ns: int, T_kiss: Array, T_robot: Array) -> _WindowStart:
        self._has_flipped = False
        return _WindowStart(stamp_ns, T_kiss, T_robot, self._kiss.map_points)

    def _checked_window(
        self, start: _WindowStart, sweep: RegisteredSweep, T_robot: Array, stamp_ns: int
    ) -> RegisteredSweep:
        """Check a window; return the sweep, at the robot's pose if KISS-ICP has failed."""
        T_by_robot = start.T_kiss @ np.linalg.inv(start.T_robot) @ T_robot
        moved = np.linalg.inv(start.T_kiss) @ sweep.T_odom_sensor
        apart = np.linalg.inv(sweep.T_odom_sensor) @ T_by_robot
        found = Consistency.AGREE
        if self._has_flipped:
            found, self._agreements = Consistency.ROBOT_BROKEN, 0
        elif _is_near(apart, moved):
            found = self._agreed(moved)
        elif len(start.map_points):
            better_m = _mean_gap_m(start.map_points, sweep.points, T_by_robot) - _mean_gap_m(
                start.map_points, sweep.points, sweep.T_odom_sensor
            )
            found, self._agreements = _failed_one(better_m), 0
        self._set_consistency(found, _divergence(apart, (stamp_ns - start.stamp_ns) / NS_PER_S))
        if found is Consistency.KISS_BROKEN:
            self._kiss.reset(T_by_robot)
            sweep = replace(sweep, T_odom_sensor=T_by_robot)
        self._window_start = self._start_window(stamp_ns, sweep.T_odom_sensor, T_robot)
        return sweep

    def _agreed(self, moved: Array) -> Consistency:
        """Return the consistency after a window in which both motions agreed."""
        is_still = _is_near(moved, np.eye(4))  # without motion even a failed odometry agrees
        self._agreements += 0 if is_still else 1
        is_mended = self._agreements >= _MENDED or self.consistency is not Consistency.ROBOT_BROKEN
        return Consistency.AGREE if is_mended else Consistency.ROBOT_BROKEN

    def _set_consistency(self, found: Consistency, evidence: str) -> None:
        before, self.consistency = self.consistency, found
        is_first = before is Consistency.ALONE and found is Consistency.AGREE
        if found is not before and not is_first:
            self._say(f'{evidence}; {_MESSAGES[found]}')


_MESSAGES = {
    Consistency.ALONE: "KISS-ICP continues alone: is the robot's odometry still published?",
    Consistency.AGREE: 'both odometries agree again',
    Consistency.ROBOT_BROKEN: "the scans do not fit the robot's odometry, which is ignored until "
    'it agrees again: do wheels slip, has it stopped, or is the sign of its turns wrong?',
    Consistency.KISS_BROKEN: 'the scans do not fit the poses of KISS-ICP, which restarts at the '
    "pose of the robot's odometry: does the sensor see walls?",
    Consistency.UNCLEAR: 'the scans fit both: they may see walls in one direction only',
}


def _is_near(apart: Array, moved: Array) -> bool:
    """Return whether a difference of two motions is within the tolerance of odometry."""
    path_m, turn_rad = _size(moved)
    apart_m, apart_rad = _size(apart)
    return (
        apart_m <= _APART_M + _APART_SHARE * path_m
        and apart_rad <= _APART_RAD + _APART_SHARE * turn_rad
    )


def _failed_one(robot_is_farther_m: float) -> Consistency:
    if robot_is_farther_m > _BETTER_M:
        return Consistency.ROBOT_BROKEN
    return Consistency.KISS_BROKEN if robot_is_farther_m < -_BETTER_M else Consistency.UNCLEAR


def _mean_gap_m(map_points: Array, points: NDArray[np.float32], T_map_sensor: Array) -> float:
    """Return the mean distance of returns from the map at a given pose [m]."""
    few = np.asarray(voxel_down_sample(points.astype(np.float64), _VOXEL_M))
    placed = few @ T_map_sensor[:3, :3].T + T_map_sensor[:3, 3]
    gaps, _ = cKDTree(map_points).query(placed, distance_upper_bound=_REACH_M)
    return float(np.minimum(gaps, _REACH_M).mean())


def _size(T: Array) -> tuple[float, float]:
    """Return translation [m] and rotation [rad] of a motion (4, 4)."""
    cosine = (float(np.trace(T[:3, :3])) - 1.0) / 2.0
    return float(np.linalg.norm(T[:3, 3])), math.acos(min(1.0, max(-1.0, cosine)))


def _divergence(apart: Array, seconds: float) -> str:
    apart_m, apart_rad = _size(apart)
    return (
        f'the odometries diverged by {apart_m:.2f} m and {math.degrees(apart_rad):.0f} degrees '
        f'in {seconds:.1f} s'
    )
