# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of odometry against the robot's motion by scan registration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet.doctor.bias import OPPOSITE, check_bias
from fpnet_core.config import OdometryConfig
from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed
from fpnet_core.errors import FpnetError
from fpnet_core.geometry.pose_track import PoseTrack
from fpnet_core.io.scans import Scan
from fpnet_core.odometry import KissOdometry
from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]

Pose = tuple[int, Array]
"""A stamp [ns] and ``T_odom_sensor (4, 4)``."""

# Chosen, not measured:
_WINDOW_NS = NS_PER_S // 2  # duration of the compared motions
_MOVED_M, _TURNED_RAD = 0.1, math.radians(5.0)  # less counts as standing still
_OFF_M, _OFF_SHARE, _OFF_RAD = 0.15, 0.15, math.radians(6.0)
_FEWEST = 2  # windows with translation, or rotation
_LEAP_M = 2.5  # physical: no robot drives 5 m/s indoors


@dataclass(frozen=True, eq=False)
class Motion:
    """
    A motion ``T_start_end (4, 4)`` of the sensor over one window, by odometry and by scans.

    Its axes are the robot's: x forward, y left.
    """

    by_odometry: Array
    by_scans: Array

    @property
    def is_drive(self) -> bool:
        """Whether either source reports a translation."""
        return _length(self.by_odometry) > _MOVED_M or _length(self.by_scans) > _MOVED_M

    @property
    def is_turn(self) -> bool:
        """Whether either source reports a rotation."""
        return _turn(self.by_odometry) > _TURNED_RAD or _turn(self.by_scans) > _TURNED_RAD

    @property
    def off_m(self) -> float:
        """Distance between both end positions [m]."""
        return float(np.linalg.norm(self.by_odometry[:3, 3] - self.by_scans[:3, 3]))

    @property
    def drives_elsewhere(self) -> bool:
        """Whether the end positions differ by more than drift explains."""
        return self.off_m > _OFF_M + _OFF_SHARE * _length(self.by_scans)

    @property
    def leaps(self) -> bool:
        """Whether the scans report a translation that is impossible in the time."""
        return self.drives_elsewhere and _length(self.by_scans) > _LEAP_M

    @property
    def turns_otherwise(self) -> bool:
        """Whether the headings differ by more than drift explains."""
        rotation = self.by_odometry[:3, :3].T @ self.by_scans[:3, :3]
        return float(Rotation.from_matrix(rotation).magnitude()) > _OFF_RAD

    @property
    def turns_the_other_way(self) -> bool:
        """Whether the rotations are opposite, within drift."""
        one, other = (_yaw(T) for T in (self.by_odometry, self.by_scans))
        return abs(one + other) < 0.5 * min(abs(one), abs(other))

    @property
    def said(self) -> str:
        """Both motions as text."""
        words = [
            f'{_length(T):.2f} m and {np.rad2deg(_turn(T)):.0f} degrees to the '
            f'{"left" if _yaw(T) > 0.0 else "right"}'
            for T in (self.by_odometry, self.by_scans)
        ]
        return f'odometry reports {words[0]}, the scans {words[1]}'


def _length(T: Array) -> float:
    return float(np.linalg.norm(T[:3, 3]))


def _turn(T: Array) -> float:
    return float(Rotation.from_matrix(T[:3, :3]).magnitude())


def _yaw(T: Array) -> float:
    return math.atan2(T[1, 0], T[0, 0])


def check_odometry(seen: Observed, poses: Sequence[Pose]) -> Iterator[Finding]:
    """
    Yield a finding if odometry disagrees with the ``poses`` of the scans.

    If these jump impossibly far, scan registration is wrong, not odometry.
    """
    if not (seen.sweeps and len(seen.track)):
        return
    T_child_sensor = seen.tree.lookup(seen.child_frame, seen.sweeps[0].frame, 0)
    if T_child_sensor is None:
        return
    found = list(motions(poses, seen.track, T_child_sensor))
    if leaps := [motion for motion in found if motion.leaps]:
        worst = max(leaps, key=lambda each: each.off_m)
        yield Finding(
            Problem.REGISTRATION,
            seen.scans,
            f'KISS-ICP jumps impossibly far in {len(leaps)} of {len(found)} half seconds; in '
            f'one {worst.said}',
            'use the odometry of the robot (odometry:=robot, fpnet localize --odometry robot): a '
            'narrow field of view or long bare walls do not constrain scan registration',
        )
        return
    drives, turns = [m for m in found if m.is_drive], [m for m in found if m.is_turn]
    astray = _most(drives, [m for m in drives if m.drives_elsewhere])
    off = astray or _most(turns, [m for m in turns if m.turns_otherwise])
    if not off:
        yield from check_bias(seen.odometry, [(m.by_odometry, m.by_scans) for m in found])
        return
    what, count = ('driving', len(drives)) if astray else ('turning', len(turns))
    if opposite := _most(turns, [m for m in turns if m.turns_the_other_way]):
        most = max(opposite, key=lambda each: abs(_yaw(each.by_scans)))
        evidence = f'opposite rotation in {len(opposite)} of {len(turns)} half seconds of turning'
        said = f'{evidence}; in one {most.said}'
        yield Finding(Problem.ODOMETRY, seen.odometry, said, OPPOSITE)
        return
    worst = max(off, key=lambda each: each.off_m)
    yield Finding(
        Problem.ODOMETRY,
        seen.odometry,
        f'in {len(off)} of {count} half seconds of {what}; in one {worst.said}',
        'look at both in RViz (fixed frame odom, clouds with a decay time of 10 s): smeared walls '
        "mean that odometry (wheel radius, track width, an IMU's sign) or the yaw of the static "
        'transform to the sensor is wrong; meanwhile use KISS-ICP (fpnet localize --odometry '
        'kiss)',
    )


def check_flips(seen: Observed) -> Iterator[Finding]:
    """Yield a finding if odometry rotates back and forth faster than any robot."""
    if (flips := seen.track.flips) >= _FEWEST:
        yield Finding(
            Problem.ODOMETRY,
            seen.odometry,
            f'it rotates impossibly fast from one message to the next, {flips} times',
            'check whether two nodes publish it (ros2 topic info -v), one with the opposite '
            'heading; meanwhile use KISS-ICP (fpnet localize --odometry kiss)',
        )


def _most(all_of_them: list[Motion], off: list[Motion]) -> list[Motion]:
    """Return ``off`` if it is the majority of enough motions, else an empty list."""
    return off if len(all_of_them) >= _FEWEST and 2 * len(off) > len(all_of_them) else []


def registered(seen: Observed) -> list[Pose]:
    """Return stamps and KISS-ICP poses of the sweeps; sweeps that it rejects are skipped."""
    kiss, found = KissOdometry(OdometryConfig()), []
    for sweep in seen.sweeps:
        try:
            scan = Scan(sweep.stamp_ns, sweep.points, sweep.time_s)
            found.append((sweep.stamp_ns, kiss.register_scan(scan).T_odom_sensor))
        except FpnetError:
            continue
    return found


def motions(poses: Sequence[Pose], track: PoseTrack, T_child_sensor: Array) -> Iterator[Motion]:
    """Yield the motions between scan poses that are one window apart."""
    axes = np.eye(4)
    axes[:3, :3] = T_child_sensor[:3, :3]
    start: tuple[int, Array, Array] | None = None
    for stamp_ns, by_scans in poses:
        T_odom_child = track.at(stamp_ns)
        if T_odom_child is None:
            continue
        by_odometry = T_odom_child @ T_child_sensor
        if start is None or stamp_ns < start[0]:
            start = stamp_ns, by_odometry, by_scans
        elif stamp_ns - start[0] >= _WINDOW_NS:
            ends = (start[1], by_odometry), (start[2], by_scans)
            yield Motion(*(axes @ np.linalg.inv(first) @ last @ axes.T for first, last in ends))
            start = stamp_ns, by_odometry, by_scans
