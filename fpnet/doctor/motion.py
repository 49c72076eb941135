# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether odometry says the same of the robot's motion as the scans do."""

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
_WINDOW_NS = NS_PER_S // 2  # motions over so long are compared
_MOVED_M, _TURNED_RAD = 0.1, math.radians(5.0)  # less is standing still
_OFF_M, _OFF_SHARE, _OFF_RAD = 0.15, 0.15, math.radians(6.0)
_FEWEST = 2  # windows in which the robot drives, or turns
_LEAP_M = 2.5  # physical: no robot drives 5 m/s indoors


@dataclass(frozen=True, eq=False)
class Motion:
    """
    A motion ``T_start_end (4, 4)`` of the sensor over one window, by two odometries.

    Its axes are the robot's: x ahead, y to the left.
    """

    by_odometry: Array
    by_scans: Array

    @property
    def is_drive(self) -> bool:
        """Tell whether either says that the robot went on."""
        return _length(self.by_odometry) > _MOVED_M or _length(self.by_scans) > _MOVED_M

    @property
    def is_turn(self) -> bool:
        """Tell whether either says that the robot turned."""
        return _turn(self.by_odometry) > _TURNED_RAD or _turn(self.by_scans) > _TURNED_RAD

    @property
    def off_m(self) -> float:
        """Distance between both ends [m]."""
        return float(np.linalg.norm(self.by_odometry[:3, 3] - self.by_scans[:3, 3]))

    @property
    def drives_elsewhere(self) -> bool:
        """Tell whether the ends are further apart than drift explains."""
        return self.off_m > _OFF_M + _OFF_SHARE * _length(self.by_scans)

    @property
    def leaps(self) -> bool:
        """Tell whether the scans say that the robot went where no robot gets in the time."""
        return self.drives_elsewhere and _length(self.by_scans) > _LEAP_M

    @property
    def turns_otherwise(self) -> bool:
        """Tell whether the headings are further apart than drift explains."""
        rotation = self.by_odometry[:3, :3].T @ self.by_scans[:3, :3]
        return float(Rotation.from_matrix(rotation).magnitude()) > _OFF_RAD

    @property
    def turns_the_other_way(self) -> bool:
        """Tell whether the headings are one another's mirror image, as far as drift allows."""
        one, other = (_yaw(T) for T in (self.by_odometry, self.by_scans))
        return abs(one + other) < 0.5 * min(abs(one), abs(other))

    @property
    def said(self) -> str:
        """Return both in words."""
        words = [
            f'{_length(T):.2f} m and {np.rad2deg(_turn(T)):.0f} degrees to the '
            f'{"left" if _yaw(T) > 0.0 else "right"}'
            for T in (self.by_odometry, self.by_scans)
        ]
        return f'odometry says {words[0]}, the scans {words[1]}'


def _length(T: Array) -> float:
    return float(np.linalg.norm(T[:3, 3]))


def _turn(T: Array) -> float:
    return float(Rotation.from_matrix(T[:3, :3]).magnitude())


def _yaw(T: Array) -> float:
    return math.atan2(T[1, 0], T[0, 0])


def check_odometry(seen: Observed, poses: Sequence[Pose]) -> Iterator[Finding]:
    """
    Yield odometry that moves the robot otherwise than the ``poses`` of the scans do.

    Where these leap as no robot does it is they that are wrong.
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
            f'KISS-ICP leaps as no robot does, in {len(leaps)} of {len(found)} half seconds; in '
            f'one {worst.said}',
            'take the odometry that the robot brings (odometry:=robot, fpnet localize --odometry '
            'robot): a narrow field of view, or bare walls all along, hold no registration',
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
        evidence = f'in {len(opposite)} of {len(turns)} half seconds of turning the other way'
        said = f'{evidence}; in one {most.said}'
        yield Finding(Problem.ODOMETRY, seen.odometry, said, OPPOSITE)
        return
    worst = max(off, key=lambda each: each.off_m)
    yield Finding(
        Problem.ODOMETRY,
        seen.odometry,
        f'in {len(off)} of {count} half seconds of {what}; in one {worst.said}',
        'look at both in RViz (fixed frame odom, clouds with a decay time of 10 s): smeared walls '
        "mean odometry is wrong (wheel radius, track width, an IMU's sign), or the yaw of the "
        'static transform to the sensor; meanwhile use KISS-ICP (fpnet localize --odometry kiss)',
    )


def check_flips(seen: Observed) -> Iterator[Finding]:
    """Yield odometry that turns to and fro faster than any robot."""
    if (flips := seen.track.flips) >= _FEWEST:
        yield Finding(
            Problem.ODOMETRY,
            seen.odometry,
            f'it turns from one message to the next as no robot does, {flips} times',
            'do two nodes publish it (ros2 topic info -v), of which one has the robot the other '
            'way round? Meanwhile use KISS-ICP (fpnet localize --odometry kiss)',
        )


def _most(all_of_them: list[Motion], off: list[Motion]) -> list[Motion]:
    """Return those that are off where they are most of enough."""
    return off if len(all_of_them) >= _FEWEST and 2 * len(off) > len(all_of_them) else []


def registered(seen: Observed) -> list[Pose]:
    """Return stamps and poses of the sweeps by KISS-ICP; those that it refuses are left out."""
    kiss, found = KissOdometry(OdometryConfig()), []
    for sweep in seen.sweeps:
        try:
            scan = Scan(sweep.stamp_ns, sweep.points, sweep.time_s)
            found.append((sweep.stamp_ns, kiss.register_scan(scan).T_odom_sensor))
        except FpnetError:
            continue
    return found


def motions(poses: Sequence[Pose], track: PoseTrack, T_child_sensor: Array) -> Iterator[Motion]:
    """Yield the motions between poses of the scans that are one window apart."""
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
