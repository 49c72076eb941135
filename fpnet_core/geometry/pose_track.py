# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses of one frame over time: kept in order, interpolated between neighbours."""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]

MAX_GAP_NS = NS_PER_S // 2
"""Poses further apart are not interpolated: a robot may have turned by then. Chosen."""

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
        if self._horizon_ns is not None and stamps and stamp_ns < stamps[-1] - _DISORDER_NS:
            stamps.clear()
            self._poses.clear()
        if stamp_ns not in self._poses:
            insort(stamps, stamp_ns)
        self._poses[stamp_ns] = pose
        while self._horizon_ns is not None and stamps[-1] - stamps[0] > self._horizon_ns:
            del self._poses[stamps.pop(0)]

    def at(self, stamp_ns: int) -> Array | None:
        """Return the pose (4, 4) at a time; None outside the track or in a long gap."""
        if (exact := self._poses.get(stamp_ns)) is not None:
            return exact
        after = bisect_right(self._stamps_ns, stamp_ns)
        if after in (0, len(self._stamps_ns)):
            return None
        before_ns, after_ns = self._stamps_ns[after - 1], self._stamps_ns[after]
        if after_ns - before_ns > self._max_gap_ns:
            return None
        share = (stamp_ns - before_ns) / (after_ns - before_ns)
        return _between(self._poses[before_ns], self._poses[after_ns], share)


def _between(start: Array, end: Array, share: float) -> Array:
    """Return the pose at ``share`` of the way: straight, and turning evenly."""
    m = np.eye(4)
    turn = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], end[:3, :3]]))
    m[:3, :3] = turn(share).as_matrix()
    m[:3, 3] = (1.0 - share) * start[:3, 3] + share * end[:3, 3]
    return m
