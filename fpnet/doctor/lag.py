# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Check of the time offset of scans and odometry: 0.1 s for stamps at the wrong sweep end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
import math

import numpy as np
from numpy.typing import NDArray

from fpnet.doctor.motion import Pose
from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed
from fpnet_core.geometry.pose_track import PoseTrack
from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]

# Chosen, not measured:
_LEAST_LAG_S = 0.07  # smaller offsets are below the resolution
_LEAST_TURN_RAD = math.radians(1.5)  # RMS of the rotations over a span
_BETTER = 0.85  # largest residual with a shift over the one without
_FEWEST = 20  # spans
# Numerical:
_SHIFTS_S = np.arange(-10, 11) * 0.02  # candidates
_SPAN = 3  # sweeps over which rotations are compared


def check_lag(seen: Observed, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Yield a finding if nodes interpret scan stamps as too early or late by part of a sweep."""
    lag_s = lag(poses, seen.track)
    if lag_s is None or abs(lag_s) < _LEAST_LAG_S:
        return
    when = 'early' if lag_s > 0.0 else 'late'
    yield Finding(
        Problem.LAG,
        seen.scans,
        f'its rotation fits {seen.odometry} best if its stamps are {abs(lag_s):.2f} s too {when}',
        'set scans.stamp (scan_stamp:=start, middle or end) to what the stamps mean: at the wrong '
        'end of the sweep they are early or late by its duration. Arrival times are late: make '
        'the driver use the time of the sensor',
    )


def lag(poses: Sequence[Pose], track: PoseTrack) -> float | None:
    """
    Return by how much the scan stamps are too early [s]; None if rotations do not tell.

    Parameters
    ----------
    poses
        Stamps [ns] and ``T_odom_sensor (4, 4)`` by scan registration.
    track
        Poses by odometry; rotations do not depend on the position of its frame on the robot.
    """
    if len(poses) <= _SPAN:
        return None
    by_scans = _turns(np.array([T for _, T in poses]))
    apart = np.array([_apart(poses, track, by_scans, shift_s) for shift_s in _SHIFTS_S])
    unshifted = apart[len(_SHIFTS_S) // 2]
    if np.sqrt(np.mean(by_scans**2)) < _LEAST_TURN_RAD or not np.isfinite(unshifted):
        return None
    best = int(np.nanargmin(apart))
    return float(_SHIFTS_S[best]) if apart[best] < _BETTER * unshifted else 0.0


def _apart(poses: Sequence[Pose], track: PoseTrack, by_scans: Array, shift_s: float) -> float:
    """Return the RMS difference of the rotations [rad]; NaN with too few common spans."""
    unknown = np.full((4, 4), np.nan)
    shift_ns = round(shift_s * NS_PER_S)
    found = [track.at(stamp_ns + shift_ns) for stamp_ns, _ in poses]
    off = by_scans - _turns(np.array([unknown if T is None else T for T in found]))
    off = np.arctan2(np.sin(off), np.cos(off))
    known = np.isfinite(off)
    return float(np.sqrt(np.mean(off[known] ** 2))) if known.sum() >= _FEWEST else math.nan


def _turns(poses: Array) -> Array:
    """Return the rotation [rad] of each pose ``(S, 4, 4)`` since the pose one span before."""
    yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    turn = yaw[_SPAN:] - yaw[:-_SPAN]
    return np.asarray(np.arctan2(np.sin(turn), np.cos(turn)), dtype=np.float64)
