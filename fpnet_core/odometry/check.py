# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two odometries of one robot: KISS-ICP helped by the robot's own, and which has broken."""

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
_WINDOW_NS = 800_000_000  # with the sweep that ends it, a word comes within a second
_APART_M, _APART_RAD = 0.1, math.radians(3.0)  # what registration and a rough floor make of it
_APART_SHARE = 0.15  # of the motion: worn tyres, a wheel base that was measured badly
_REACH_M = 0.5  # a return farther from all of the map is off, no matter how far
_VOXEL_M = 0.4  # of the returns that are compared with the map
_MENDED = 5  # windows in a row: straight ahead, one that turns the wrong way round is right

_BETTER_M = 0.02
"""
Of two places of a sweep the one that its returns lie nearer to the map at, by this much in the
mean, is right; less tells nothing. Chosen: noise of a lidar indoors.
"""


class Consistency(Enum):
    """What the scans say of two odometries."""

    ALONE = 'alone'
    """There is only one of them: KISS-ICP."""
    AGREE = 'agree'
    ROBOT_BROKEN = 'robot_broken'
    KISS_BROKEN = 'kiss_broken'
    UNCLEAR = 'unclear'
    """They disagree, and the scans fit both."""


@dataclass(frozen=True, eq=False)
class _Begin:
    """Where a window of time began: by both odometries, and the map that was known then."""

    stamp_ns: int
    T_kiss: Array
    T_robot: Array
    map_points: Array


class GuidedOdometry:
    """
    KISS-ICP that begins every registration where the robot's own odometry says.

    Both motions are compared about every second. Where they disagree, the newest sweep is laid
    into the map of a second ago at either end: the odometry that it fits less well is broken. A
    broken one of the robot's is no longer believed until both agree again; a broken KISS-ICP
    begins anew where the robot's says that the sensor is, in the same odometry frame. Where
    nothing comes from the robot's, KISS-ICP goes on alone.

    Parameters
    ----------
    config
        Of KISS-ICP.
    on_restart
        Is told by how much the clock went back [s].
    say
        Takes every change of the consistency in words.
    """

    def __init__(
        self,
        config: OdometryConfig,
        on_restart: Callable[[float], None] | None = None,
        say: Callable[[str], Any] = _log.warning,
    ) -> None:
        self._on_restart, self._say = on_restart, say
        self._kiss = KissOdometry(config, self._restart)
        self._begin: _Begin | None = None
        self._T_robot_last: Array | None = None
        self._last_ns = 0
        self._has_flipped = False  # the robot's, since the window began
        self._agreements = 0
        self.consistency = Consistency.ALONE

    def register_scan(self, scan: Scan) -> RegisteredSweep:
        """
        Return where a scan was taken, as :meth:`KissOdometry.register_scan` does.

        ``scan.T_odom_sensor`` is the sensor's pose by the robot's odometry, None without one.
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
            self._begin = None
            self._judge(Consistency.ALONE, 'no pose of the robot came with a scan')
            return sweep
        begin = self._begin
        if begin is None:
            self._begin = self._begun(scan.stamp_ns, sweep.T_odom_sensor, T_robot)
        elif scan.stamp_ns - begin.stamp_ns >= _WINDOW_NS:
            sweep = self._compared(begin, sweep, T_robot, scan.stamp_ns)
        return sweep

    def _is_flip(self, scan: Scan) -> bool:
        """Tell whether the robot's odometry turns as no robot does since the last scan."""
        before, after = self._T_robot_last, scan.T_odom_sensor
        if before is None or after is None:
            return False
        return impossible_turn_rad(before, after, (scan.stamp_ns - self._last_ns) / NS_PER_S) > 0.0

    def _is_likely_step(self, scan: Scan) -> bool:
        """Tell whether a scan fits where the robot's last step leads, or that was a jump."""
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
        self._begin = self._T_robot_last = None
        if self._on_restart is not None:
            self._on_restart(back_s)

    def _begun(self, stamp_ns: int, T_kiss: Array, T_robot: Array) -> _Begin:
        self._has_flipped = False
        return _Begin(stamp_ns, T_kiss, T_robot, self._kiss.map_points)

    def _compared(
        self, begin: _Begin, sweep: RegisteredSweep, T_robot: Array, stamp_ns: int
    ) -> RegisteredSweep:
        """Judge a window of time; returns the sweep, where the robot says if KISS-ICP broke."""
        T_by_robot = begin.T_kiss @ np.linalg.inv(begin.T_robot) @ T_robot
        moved = np.linalg.inv(begin.T_kiss) @ sweep.T_odom_sensor
        apart = np.linalg.inv(sweep.T_odom_sensor) @ T_by_robot
        found = Consistency.AGREE
        if self._has_flipped:
            found, self._agreements = Consistency.ROBOT_BROKEN, 0
        elif _is_near(apart, moved):
            found = self._agreed(moved)
        elif len(begin.map_points):
            better_m = _mean_gap_m(begin.map_points, sweep.points, T_by_robot) - _mean_gap_m(
                begin.map_points, sweep.points, sweep.T_odom_sensor
            )
            found, self._agreements = _broken_one(better_m), 0
        self._judge(found, _in_words(apart, (stamp_ns - begin.stamp_ns) / NS_PER_S))
        if found is Consistency.KISS_BROKEN:
            self._kiss.reset(T_by_robot)
            sweep = replace(sweep, T_odom_sensor=T_by_robot)
        self._begin = self._begun(stamp_ns, sweep.T_odom_sensor, T_robot)
        return sweep

    def _agreed(self, moved: Array) -> Consistency:
        """Return what a window says in which both motions were the same."""
        is_still = _is_near(moved, np.eye(4))  # then a broken odometry is as good as any
        self._agreements += 0 if is_still else 1
        is_mended = self._agreements >= _MENDED or self.consistency is not Consistency.ROBOT_BROKEN
        return Consistency.AGREE if is_mended else Consistency.ROBOT_BROKEN

    def _judge(self, found: Consistency, evidence: str) -> None:
        before, self.consistency = self.consistency, found
        is_first = before is Consistency.ALONE and found is Consistency.AGREE
        if found is not before and not is_first:
            self._say(f'{evidence}; {_SAID[found]}')


_SAID = {
    Consistency.ALONE: "KISS-ICP goes on alone: is the robot's odometry still published?",
    Consistency.AGREE: 'both odometries agree again',
    Consistency.ROBOT_BROKEN: "the scans do not fit the robot's odometry, which is left out until "
    'it agrees again: do wheels slip, or has its publisher stopped or turned the wrong way round?',
    Consistency.KISS_BROKEN: "the scans do not fit KISS-ICP's poses, which begins anew where the "
    "robot's odometry says: does the sensor see walls?",
    Consistency.UNCLEAR: 'the scans fit both: they may see walls in one direction only',
}


def _is_near(apart: Array, moved: Array) -> bool:
    """Tell whether two motions differ by no more than odometries do."""
    path_m, turn_rad = _size(moved)
    apart_m, apart_rad = _size(apart)
    return (
        apart_m <= _APART_M + _APART_SHARE * path_m
        and apart_rad <= _APART_RAD + _APART_SHARE * turn_rad
    )


def _broken_one(robot_is_farther_m: float) -> Consistency:
    if robot_is_farther_m > _BETTER_M:
        return Consistency.ROBOT_BROKEN
    return Consistency.KISS_BROKEN if robot_is_farther_m < -_BETTER_M else Consistency.UNCLEAR


def _mean_gap_m(map_points: Array, points: NDArray[np.float32], T_map_sensor: Array) -> float:
    """Return how far returns lie from the map in the mean, seen from a pose [m]."""
    few = np.asarray(voxel_down_sample(points.astype(np.float64), _VOXEL_M))
    placed = few @ T_map_sensor[:3, :3].T + T_map_sensor[:3, 3]
    gaps, _ = cKDTree(map_points).query(placed, distance_upper_bound=_REACH_M)
    return float(np.minimum(gaps, _REACH_M).mean())


def _size(T: Array) -> tuple[float, float]:
    """Return by how much a motion goes [m] and turns [rad]."""
    cosine = (float(np.trace(T[:3, :3])) - 1.0) / 2.0
    return float(np.linalg.norm(T[:3, 3])), math.acos(min(1.0, max(-1.0, cosine)))


def _in_words(apart: Array, seconds: float) -> str:
    apart_m, apart_rad = _size(apart)
    return (
        f'the odometries came apart by {apart_m:.2f} m and {math.degrees(apart_rad):.0f} degrees '
        f'in {seconds:.1f} s'
    )
