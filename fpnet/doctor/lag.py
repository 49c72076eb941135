# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether scans and odometry are of one time: stamps at the other end of a sweep are 0.1 s off."""

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
_LEAST_LAG_S = 0.07  # less is within what turns can tell
_LEAST_TURN_RAD = math.radians(1.5)  # of turns over a span, in the mean square root
_BETTER = 0.85  # of what turns are apart by without a shift
_FEWEST = 20  # spans
# Numerical:
_SHIFTS_S = np.arange(-10, 11) * 0.02  # that are tried
_SPAN = 3  # sweeps over which turns are compared


def check_lag(seen: Observed, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Yield scans that nodes take for earlier or later than they are, by a part of a sweep."""
    lag_s = lag(poses, seen.track)
    if lag_s is None or abs(lag_s) < _LEAST_LAG_S:
        return
    when = 'early' if lag_s > 0.0 else 'late'
    yield Finding(
        Problem.LAG,
        seen.scans,
        f'its turns fit those of {seen.odometry} best if its stamps are {abs(lag_s):.2f} s {when}',
        'say what they are of with scans.stamp (scan_stamp:=start, middle or end): taken for '
        'another end of the sweep they are early or late by its duration. Stamps of arrival are '
        'late: let the driver stamp by the sensor',
    )


def lag(poses: Sequence[Pose], track: PoseTrack) -> float | None:
    """
    Return by how much stamps of the scans are too early [s]; None where turns do not tell.

    Parameters
    ----------
    poses
        Stamps [ns] and ``T_odom_sensor (4, 4)`` by the scans.
    track
        Poses by odometry; where its frame sits on the robot does not matter for turns.
    """
    if len(poses) <= _SPAN:
        return None
    by_scans = _turns(np.array([T for _, T in poses]))
    apart = np.array([_apart(poses, track, by_scans, shift_s) for shift_s in _SHIFTS_S])
    as_it_is = apart[len(_SHIFTS_S) // 2]
    if np.sqrt(np.mean(by_scans**2)) < _LEAST_TURN_RAD or not np.isfinite(as_it_is):
        return None
    best = int(np.nanargmin(apart))
    return float(_SHIFTS_S[best]) if apart[best] < _BETTER * as_it_is else 0.0


def _apart(poses: Sequence[Pose], track: PoseTrack, by_scans: Array, shift_s: float) -> float:
    """Return the root mean square of what turns differ by; NaN where too few can be compared."""
    unknown = np.full((4, 4), np.nan)
    shift_ns = round(shift_s * NS_PER_S)
    found = [track.at(stamp_ns + shift_ns) for stamp_ns, _ in poses]
    off = by_scans - _turns(np.array([unknown if T is None else T for T in found]))
    off = np.arctan2(np.sin(off), np.cos(off))
    known = np.isfinite(off)
    return float(np.sqrt(np.mean(off[known] ** 2))) if known.sum() >= _FEWEST else math.nan


def _turns(poses: Array) -> Array:
    """Return by how much each pose ``(S, 4, 4)`` is turned against one a span before [rad]."""
    yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    turn = yaw[_SPAN:] - yaw[:-_SPAN]
    return np.asarray(np.arctan2(np.sin(turn), np.cos(turn)), dtype=np.float64)
