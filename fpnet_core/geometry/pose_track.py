# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses of one frame over time, sorted by stamp and interpolated."""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Iterable
from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]

MAX_GAP_NS = NS_PER_S // 2
"""Poses further apart are not interpolated: the robot may have turned in between. Chosen."""

_FASTEST_TURN_RADPS = 6.0 * math.pi
"""
Physical: no robot with a lidar makes three turns per second. A frame that flips between two scans
at 10 Hz is faster.
"""

_SHORTEST_S = 0.1  # numerical: messages that arrive in bursts may have closer stamps

# Chosen: samples out of order by less than this are sorted in; more means the clock jumped back.
_DISORDER_NS = NS_PER_S


class PoseTrack:
    """
    Poses ``T_frame_child (4, 4)`` over time.

    Parameters
    ----------
    child_frame
        Frame that the poses are of; empty if unknown.
    horizon_ns
        How long poses of a live robot are kept, whose clock may jump back. None, for recordings,
        keeps all poses, in whatever order they are added.
    max_gap_ns
        Largest time between two poses that are interpolated.
    """

    def __init__(
        self,
        child_frame: str = '',
        horizon_ns: int | None = None,
        max_gap_ns: int = MAX_GAP_NS,
    ) -> None:
        self.child_frame = child_frame
        self._horizon_ns, self._max_gap_ns = horizon_ns, max_gap_ns
        self.went_back = False  # whether the clock has jumped back by more than _DISORDER_NS
        self._stamps_ns: list[int] = []
        self._poses: dict[int, Array] = {}

    @classmethod
    def of(cls, poses: Iterable[tuple[int, Array]], child_frame: str = '') -> PoseTrack:
        """Build the track of a recording from pairs of stamp [ns] and pose (4, 4)."""
        track = cls(child_frame)
        for stamp_ns, pose in poses:
            track.add(stamp_ns, pose)
        return track

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self._stamps_ns)

    def add(self, stamp_ns: int, pose: Array) -> None:
        """
        Add a pose; it replaces one with the same stamp.

        If there is a horizon and the clock jumps back, as in a looping recording, all earlier
        poses are dropped.
        """
        stamps = self._stamps_ns
        if stamps and stamp_ns < stamps[-1] - _DISORDER_NS:
            self.went_back = True
            if self._horizon_ns is not None:
                stamps.clear()
                self._poses.clear()
        if stamp_ns not in self._poses:
            insort(stamps, stamp_ns)
        self._poses[stamp_ns] = pose
        while self._horizon_ns is not None and stamps[-1] - stamps[0] > self._horizon_ns:
            del self._poses[stamps.pop(0)]

    def at(self, stamp_ns: int) -> Array | None:
        """Return the pose (4, 4) at a time; None outside the track, in a long gap or in a flip."""
        if (exact := self._poses.get(stamp_ns)) is not None:
            return exact
        neighbours = self._neighbours(stamp_ns)
        if neighbours is None or self._flip_rad(*neighbours):
            return None
        before_ns, after_ns = neighbours
        share = (stamp_ns - before_ns) / (after_ns - before_ns)
        return _interpolated(self._poses[before_ns], self._poses[after_ns], share)

    @property
    def flips(self) -> int:
        """Number of pairs of consecutive poses with an impossibly fast turn in between."""
        return sum(self._flip_rad(*pair) > 0.0 for pair in pairwise(self._stamps_ns))

    def reason(self, stamp_ns: int) -> str:
        """Return a message that explains why :meth:`at` returned None."""
        neighbours = self._neighbours(stamp_ns)
        if neighbours is None:
            return 'the odometry has no pose before and after that time'
        turned = round(math.degrees(self._flip_rad(*neighbours)))
        return (
            f'the odometry turns by {turned} degrees from one message to the next; do two nodes '
            'publish it?'
        )

    def _neighbours(self, stamp_ns: int) -> tuple[int, int] | None:
        """Return the stamps before and after a time; None outside the track or in a long gap."""
        after = bisect_right(self._stamps_ns, stamp_ns)
        if after in (0, len(self._stamps_ns)):
            return None
        before_ns, after_ns = self._stamps_ns[after - 1], self._stamps_ns[after]
        return None if after_ns - before_ns > self._max_gap_ns else (before_ns, after_ns)

    def _flip_rad(self, before_ns: int, after_ns: int) -> float:
        before, after = self._poses[before_ns], self._poses[after_ns]
        return impossible_turn_rad(before, after, (after_ns - before_ns) / NS_PER_S)


def impossible_turn_rad(T_before: Array, T_after: Array, elapsed_s: float) -> float:
    """Return the rotation between two poses (4, 4) if it is impossibly fast, else 0 [rad]."""
    # From the trace, not from yaw: a sensor mounted upright (x axis vertical) has no defined yaw.
    cosine = 0.5 * (float(np.sum(T_before[:3, :3] * T_after[:3, :3])) - 1.0)
    turn_rad = math.acos(min(max(cosine, -1.0), 1.0))
    return turn_rad if turn_rad > _FASTEST_TURN_RADPS * max(elapsed_s, _SHORTEST_S) else 0.0


def _interpolated(start: Array, end: Array, share: float) -> Array:
    """Interpolate at ``share`` between two poses: linear translation, slerp rotation."""
    m = np.eye(4)
    turn = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], end[:3, :3]]))
    m[:3, :3] = turn(share).as_matrix()
    m[:3, 3] = (1.0 - share) * start[:3, 3] + share * end[:3, 3]
    return m
