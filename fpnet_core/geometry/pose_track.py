# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses of one frame over time: kept in order, interpolated between neighbours."""

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
"""Poses further apart are not interpolated: a robot may have turned by then. Chosen."""

_FASTEST_TURN_RADPS = 6.0 * math.pi
"""
Physical: no robot that carries a lidar turns three times in a second; a frame that is flipped
between two scans of 10 Hz does.
"""

_SHORTEST_S = 0.1  # numerical: stamps of messages that come in bursts are nearer to one another

# Chosen: samples are out of order by less than this; an older one is a clock that went back.
_DISORDER_NS = NS_PER_S


class PoseTrack:
    """
    Poses ``T_frame_child (4, 4)`` over time.

    Parameters
    ----------
    child_frame
        Whose poses these are; empty where nobody said.
    horizon_ns
        How long poses are kept: those of a robot that is driving, whose clock may go back. None
        keeps all, in whatever order they come: those of a recording.
    max_gap_ns
        No interpolation between poses further apart.
    """

    def __init__(
        self,
        child_frame: str = '',
        horizon_ns: int | None = None,
        max_gap_ns: int = MAX_GAP_NS,
    ) -> None:
        self.child_frame = child_frame
        self._horizon_ns, self._max_gap_ns = horizon_ns, max_gap_ns
        self.went_back = False  # the clock has, by more than disorder
        self._stamps_ns: list[int] = []
        self._poses: dict[int, Array] = {}

    @classmethod
    def of(cls, poses: Iterable[tuple[int, Array]], child_frame: str = '') -> PoseTrack:
        """Return the track of a recording's poses, each with its stamp [ns]."""
        track = cls(child_frame)
        for stamp_ns, pose in poses:
            track.add(stamp_ns, pose)
        return track

    def __len__(self) -> int:
        """Count the poses."""
        return len(self._stamps_ns)

    def add(self, stamp_ns: int, pose: Array) -> None:
        """
        Take a pose; of two at the same time the later one counts.

        Where there is a horizon and the clock goes back, as in a looping recording, the track
        starts anew.
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
        """Return the pose (4, 4) at a time; None outside the track, in a long gap or at a flip."""
        if (exact := self._poses.get(stamp_ns)) is not None:
            return exact
        around = self._around(stamp_ns)
        if around is None or self._tear_rad(*around):
            return None
        before_ns, after_ns = around
        share = (stamp_ns - before_ns) / (after_ns - before_ns)
        return _between(self._poses[before_ns], self._poses[after_ns], share)

    @property
    def flips(self) -> int:
        """How many neighbours there are that no robot turns between."""
        return sum(self._tear_rad(*pair) > 0.0 for pair in pairwise(self._stamps_ns))

    def reason(self, stamp_ns: int) -> str:
        """Return in words why :meth:`at` knows nothing."""
        around = self._around(stamp_ns)
        if around is None:
            return 'no pose of the odometry before and after it'
        turned = round(math.degrees(self._tear_rad(*around)))
        return (
            f'the odometry turns by {turned} degrees from one message to the next; do two nodes '
            'publish it?'
        )

    def _around(self, stamp_ns: int) -> tuple[int, int] | None:
        """Return the stamps before and after a time; None outside the track or in a long gap."""
        after = bisect_right(self._stamps_ns, stamp_ns)
        if after in (0, len(self._stamps_ns)):
            return None
        before_ns, after_ns = self._stamps_ns[after - 1], self._stamps_ns[after]
        return None if after_ns - before_ns > self._max_gap_ns else (before_ns, after_ns)

    def _tear_rad(self, before_ns: int, after_ns: int) -> float:
        before, after = self._poses[before_ns], self._poses[after_ns]
        return impossible_turn_rad(before, after, (after_ns - before_ns) / NS_PER_S)


def impossible_turn_rad(T_before: Array, T_after: Array, elapsed_s: float) -> float:
    """Return the turn between two poses (4, 4) if no robot makes it in the time, else 0 [rad]."""
    # By the trace: mounted upright, a sensor has no yaw of its own.
    cosine = 0.5 * (float(np.sum(T_before[:3, :3] * T_after[:3, :3])) - 1.0)
    turn_rad = math.acos(min(max(cosine, -1.0), 1.0))
    return turn_rad if turn_rad > _FASTEST_TURN_RADPS * max(elapsed_s, _SHORTEST_S) else 0.0


def _between(start: Array, end: Array, share: float) -> Array:
    """Return the pose at ``share`` of the way: straight, and turning evenly."""
    m = np.eye(4)
    turn = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], end[:3, :3]]))
    m[:3, :3] = turn(share).as_matrix()
    m[:3, 3] = (1.0 - share) * start[:3, 3] + share * end[:3, 3]
    return m
