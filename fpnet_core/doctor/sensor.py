# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of a scanner's returns, and of its mount from floor and ceiling."""

from __future__ import annotations

from collections.abc import Iterator
import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed, SeenScan
from fpnet_core.io.scans import Scan
from fpnet_core.io.topic_names import is_registered
from fpnet_core.submaps.heights import floor_and_ceiling

Array = NDArray[np.float64]

HIGHEST_MOUNT_M = 1.6
"""Physical: highest mount of a lidar on a robot that fits through doors, above the floor."""

HIGHEST_BASE_M = 0.4
"""Physical: base frames are on the ground or at the wheels' axle, no higher than this."""

FARTHEST_M = 100.0
"""Physical: in buildings at least half of a lidar's returns are nearer than this."""

# Chosen, not measured:
_TOLERANCE_M = 0.15  # of a manually measured mount
_NEAR_M = 1.2  # a plane this close above the sensor, without one below, is the floor
_TILT_RAD = math.radians(6.0)
_SHARPER = 1.05  # least ratio of pairs of returns at one height, with and without the tilt
# Numerical:
_LOOK_EVERY = 10  # every tenth scan is checked for the floor
_POINTS = 4000  # of all sweeps together
_STEP_RAD = math.radians(4.0)  # between candidate tilts
_RINGS, _FINER = 8, 4  # rings of candidates, and of finer ones around the best
_BIN_M = 0.1  # of heights


def check_returns(seen: Observed) -> Iterator[Finding]:
    """Yield scans if none of them has a return."""
    if seen.sweeps and not any(len(sweep.points) for sweep in seen.sweeps):
        yield Finding(
            Problem.BLIND,
            seen.scans,
            'scans arrive, but none of them has any return',
            'check that the lidar is not covered, rotates, and has the right range limits; '
            'where all walls are out of its range, the pose depends on odometry alone',
        )


def check_unit(seen: Observed) -> Iterator[Finding]:
    """Yield scans whose ranges are too long for a building; REP-103 asks for metres."""
    points = [each.points for each in seen.sweeps if len(each.points)]
    if not points:
        return
    range_m = float(np.median(np.linalg.norm(np.concatenate(points), axis=1)))
    if range_m > FARTHEST_M:
        yield Finding(
            Problem.UNIT,
            seen.scans,
            f'half of the returns are more than {range_m:,.0f} m away',
            'ranges must be in metres (REP-103): correct the driver if it publishes millimetres '
            'or centimetres',
        )


def check_point_times(seen: Observed) -> Iterator[Finding]:
    """Yield clouds without a time per point."""
    sweep = next((each for each in seen.sweeps if not each.is_planar and len(each.points)), None)
    if sweep is None or is_registered(seen.scans):  # already deskewed
        return
    if sweep.time_s is not None and np.ptp(sweep.time_s) > 0.0:
        return
    has_field = sweep.time_s is not None
    fields = f'; its fields are {", ".join(sweep.fields)}' if sweep.fields else ''
    what = 'all its times are equal' if has_field else f'no usable time field{fields}'
    yield Finding(
        Problem.POINT_TIMES,
        seen.scans,
        f'{what}: KISS-ICP deskews by the order of the points, once turns show that sweeps are '
        'skewed; with other odometry walls are smeared in turns, and the stamp is assumed to be '
        "the sweep's middle",
        'choose a point format with t, time or timestamp in the driver (point type XYZIRT or '
        'similar); a simulator with instantaneous sweeps needs no times',
    )


def check_mount(seen: Observed) -> Iterator[Finding]:
    """Yield a scanner that is tilted, upside down, or at another height than its transform."""
    sweeps = [each for each in seen.sweeps if not each.is_planar and len(each.points)]
    if not sweeps:
        return
    mount = _mount(seen, sweeps[0])
    rotation, height_m = (np.eye(3), None) if mount is None else (mount[:3, :3], mount[2, 3])
    frame = sweeps[0].frame
    points = _some(sweeps) @ rotation.T
    tilt_rad = tilt(points)
    if tilt_rad > _TILT_RAD:
        is_beyond = tilt_rad >= _STEP_RAD * _RINGS
        more = ' or more' if is_beyond else ''
        optical = '; for an optical frame (z ahead): --roll -1.5708 --yaw -1.5708' * is_beyond
        yield Finding(
            Problem.TILTED,
            frame,
            f'floor and ceiling are level only after a rotation of {math.degrees(tilt_rad):.0f} '
            f'degrees{more}{_as_mounted(mount)}',
            'add its tilt (--roll, --pitch) to the static transform from the base to the sensor'
            f'{optical}',
        )
        return
    floor, ceiling = floor_and_ceiling(points[:, 2])
    if is_upside_down(floor, ceiling, height_m):
        below = 'none' if floor is None else f'one {-floor:.2f} m'
        yield Finding(
            Problem.UPSIDE_DOWN,
            frame,
            f'it sees a plane {ceiling:.2f} m above itself and {below} below: the floor seems to '
            f'be above it{_as_mounted(mount)}',
            'add --roll 3.14159 to the static transform from the base to the sensor, or set the '
            'option of its driver',
        )
    elif height_m is not None and floor is not None:
        yield from _wrong_height(frame, -floor, float(height_m))


def _wrong_height(frame: str, seen_m: float, told_m: float) -> Iterator[Finding]:
    if not -_TOLERANCE_M < seen_m - told_m < HIGHEST_BASE_M + _TOLERANCE_M:
        yield Finding(
            Problem.HEIGHT,
            frame,
            f'the floor is {seen_m:.2f} m below it, but /tf_static puts it {told_m:.2f} m above '
            'the base',
            f'correct --z of its static transform: {seen_m:.2f} if the base frame is on the floor',
        )


def is_upside_down(floor: float | None, ceiling: float | None, told_m: float | None) -> bool:
    """
    Return whether the apparent ceiling is the floor.

    Parameters
    ----------
    floor, ceiling
        Heights of the planes below and above the sensor, relative to it [m]; None if not seen.
    told_m
        Height of the sensor above its base by its transform [m]; None if unknown.
    """
    if ceiling is None:
        return False
    if floor is None:
        return ceiling < _NEAR_M
    if -floor <= ceiling:
        return False
    if told_m is not None:  # the floor is the plane that is closer to its expected height
        return abs(ceiling - told_m) < abs(-floor - told_m) and ceiling < HIGHEST_MOUNT_M
    return -floor > HIGHEST_MOUNT_M > ceiling


class MountVotes:
    """Votes of scans on whether the scanner is upside down; one in ten is checked."""

    def __init__(self) -> None:
        self._scans, self._looks, self._votes = 0, 0, 0

    def look(self, scan: Scan) -> None:
        """Add a scan."""
        if self._scans % _LOOK_EVERY == 0:
            self._looks += 1
            self._votes += upside_down_vote(scan)
        self._scans += 1

    @property
    def is_upside_down(self) -> bool:
        """Whether most of the checked scans vote for it."""
        return 2 * self._votes > self._looks


def upside_down_vote(scan: Scan) -> int:
    """Return 1 if a scan shows the floor above the sensor, -1 if below, 0 if not at all."""
    T = scan.T_odom_sensor if scan.T_base_sensor is None else scan.T_base_sensor
    heights = scan.points @ (np.eye(3) if T is None else T[:3, :3])[2]
    floor, ceiling = floor_and_ceiling(heights)
    told_m = None if scan.T_base_sensor is None else float(scan.T_base_sensor[2, 3])
    if is_upside_down(floor, ceiling, told_m):
        return 1
    return 0 if floor is None else -1


def tilt(points: Array) -> float:
    """
    Return the angle between the normal of level planes and the z axis [rad].

    Parameters
    ----------
    points : (P, 3), sensor frame [m]
    """
    level = _sharpness(points[:, 2])
    coarse, sharp = _sharpest(points, np.eye(3), _STEP_RAD, _RINGS)
    up, sharp = _sharpest(points, _turned_to(coarse), _STEP_RAD / _FINER, _FINER)
    return 0.0 if sharp < _SHARPER * level else float(np.arccos(np.clip(up[2], -1.0, 1.0)))


def _sharpest(points: Array, turned: Array, step_rad: float, rings: int) -> tuple[Array, float]:
    """Return the direction (3,) with the highest sharpness around z of ``turned``, and that."""
    ups = _directions(step_rad, rings) @ turned.T
    sharp = np.array([_sharpness(points @ up) for up in ups])
    best = int(sharp.argmax())
    return ups[best], float(sharp[best])


def _turned_to(up: Array) -> Array:
    """Return a rotation (3, 3) that maps z to ``up``."""
    rotation = Rotation.align_vectors(up[None], [[0.0, 0.0, 1.0]])[0]
    return np.asarray(rotation.as_matrix(), dtype=np.float64)


def _directions(step_rad: float, rings: int) -> Array:
    """Return unit vectors ``(D, 3)``: z, then rings around it."""
    found = [(0.0, 0.0, 1.0)]
    for ring in range(1, rings + 1):
        angle = ring * step_rad
        for turn in np.linspace(0.0, 2.0 * np.pi, 6 * ring, endpoint=False):
            x, y = math.sin(angle) * math.cos(turn), math.sin(angle) * math.sin(turn)
            found.append((x, y, math.cos(angle)))
    return np.array(found)


def _sharpness(heights: Array) -> float:
    """Return the share of pairs of returns in the same height bin."""
    bins = np.floor(heights / _BIN_M).astype(np.int64)
    counts = np.bincount(bins - bins.min())
    return float(np.sum(counts.astype(np.float64) ** 2)) / len(heights) ** 2


def _some(sweeps: list[SeenScan]) -> Array:
    """Return an even subset ``(P, 3)`` of the points of all sweeps."""
    share = max(1, sum(len(each.points) for each in sweeps) // _POINTS)
    # Different points of each sweep, because those of a standing robot repeat.
    points = np.concatenate([each.points[k % share :: share] for k, each in enumerate(sweeps)])
    return points.astype(np.float64)


def _mount(seen: Observed, sweep: SeenScan) -> Array | None:
    """Return ``T_base_sensor (4, 4)``, or None if it is unknown."""
    base = seen.child_frame or seen.tree.root(sweep.frame)
    return None if base == sweep.frame else seen.tree.lookup(base, sweep.frame, 0)


def _as_mounted(mount: Array | None) -> str:
    return '' if mount is None else ', with the mount from /tf_static'
