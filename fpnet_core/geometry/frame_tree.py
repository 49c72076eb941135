# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tree of named frames with fixed and moving transforms, as in tf2."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import OdometryError
from fpnet_core.geometry.pose_track import MAX_GAP_NS, PoseTrack
from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]


def plain_frame(frame: str) -> str:
    """
    Return a frame's name without a leading slash.

    Some publishers still write one. tf2 has dropped it, so both names mean the same frame.
    """
    return frame.lstrip('/')


@dataclass(eq=False)
class _Edge:
    """``T_parent_child``, fixed or sampled over time."""

    parent: str
    place: Array | PoseTrack

    def at(self, stamp_ns: int) -> Array | None:
        return self.place.at(stamp_ns) if isinstance(self.place, PoseTrack) else self.place


class FrameTree:
    """
    Transforms by frame name and time; a frame has one parent, the last one given.

    Names are compared as :func:`plain_frame` returns them. Frames are never assumed to
    coincide: without a connecting transform the result is unknown, offline as on a robot.

    Parameters
    ----------
    horizon_s : how long moving transforms are kept [s]
    max_gap_s : largest time between two samples that are interpolated [s]
    """

    def __init__(self, horizon_s: float = 10.0, max_gap_s: float = MAX_GAP_NS / NS_PER_S) -> None:
        self._horizon_ns = int(horizon_s * NS_PER_S)
        self._max_gap_ns = int(max_gap_s * NS_PER_S)
        self._edges: dict[str, _Edge] = {}

    def clear(self) -> None:
        """Remove the moving transforms and keep the fixed ones."""
        self._edges = {
            child: edge
            for child, edge in self._edges.items()
            if not isinstance(edge.place, PoseTrack)
        }

    def add_fixed(self, parent: str, child: str, T_parent_child: Array) -> None:
        """Add a fixed transform."""
        self._edges[plain_frame(child)] = _Edge(plain_frame(parent), T_parent_child)

    def add(self, parent: str, child: str, T_parent_child: Array, stamp_ns: int) -> None:
        """
        Add a sample of a moving transform.

        If the clock jumps back, as in a looping recording, earlier samples are dropped.
        """
        parent, child = plain_frame(parent), plain_frame(child)
        edge = self._edges.get(child)
        if edge is None or edge.parent != parent or not isinstance(edge.place, PoseTrack):
            track = PoseTrack(child, self._horizon_ns, self._max_gap_ns)
            self._edges[child] = _Edge(parent, track)
        else:
            track = edge.place
        track.add(stamp_ns, T_parent_child)

    def lookup(self, target: str, source: str, stamp_ns: int) -> Array | None:
        """
        Return ``T_target_source (4, 4)`` at a time.

        None if the frames are not connected, or a sample before or after that time is missing;
        :meth:`reason` says which.
        """
        ancestor = self._common_ancestor(target, source)
        if ancestor is None:
            return None
        T_ancestor_target = self._along(target, ancestor, stamp_ns)
        T_ancestor_source = self._along(source, ancestor, stamp_ns)
        if T_ancestor_target is None or T_ancestor_source is None:
            return None
        T_target_source: Array = np.linalg.inv(T_ancestor_target) @ T_ancestor_source
        return T_target_source

    def mount(self, base: str, sensor: str) -> Array:
        """
        Return the fixed transform ``T_base_sensor (4, 4)`` of a sensor's mount.

        Raises
        ------
        OdometryError
            If no fixed transforms connect the two frames.
        """
        T_base_sensor = self.lookup(base, sensor, 0)
        if T_base_sensor is None:
            raise OdometryError(self.reason(base, sensor, 0))
        return T_base_sensor

    def reason(self, target: str, source: str, stamp_ns: int) -> str:
        """Return a message that explains why :meth:`lookup` returned None."""
        target, source = plain_frame(target), plain_frame(source)
        if not target:
            return f'the pose of {source!r} is unknown: the odometry has no child_frame_id'
        if self._common_ancestor(target, source) is None:
            return (
                f'the pose of {source!r} in {target!r} is unknown: no transform on /tf_static '
                'connects them'
            )
        return f'{source!r} in {target!r} is unknown at {stamp_ns} ns: no pose before and after it'

    def parent(self, frame: str) -> str | None:
        """Return the parent of a frame, or None if it has none."""
        edge = self._edges.get(plain_frame(frame))
        return None if edge is None else edge.parent

    def children(self, frame: str) -> list[str]:
        """Return the child frames of a frame, in the order in which they were added."""
        frame = plain_frame(frame)
        return [child for child, edge in self._edges.items() if edge.parent == frame]

    def root(self, frame: str) -> str:
        """Return the topmost ancestor of a frame, or the frame itself if it has no parent."""
        return self._chain(frame)[-1]

    def body(self, frame: str) -> str:
        """Return the topmost ancestor that fixed transforms connect to a frame, or the frame."""
        chain = self._chain(frame)
        for here, above in pairwise(chain):
            if isinstance(self._edges[here].place, PoseTrack):
                return here
            frame = above
        return plain_frame(frame)

    def _common_ancestor(self, one: str, other: str) -> str | None:
        """Return the nearest common ancestor of two frames, or None."""
        above = self._chain(one)
        return next((frame for frame in self._chain(other) if frame in above), None)

    def _chain(self, frame: str) -> list[str]:
        """Return the frame and its ancestors; stop before a frame repeats (a loop in TF)."""
        chain = [plain_frame(frame)]
        while (edge := self._edges.get(chain[-1])) is not None and edge.parent not in chain:
            chain.append(edge.parent)
        return chain

    def _along(self, frame: str, root: str, stamp_ns: int) -> Array | None:
        """Return ``T_root_frame`` through the ancestors of ``frame``."""
        T_here_frame, frame = np.eye(4), plain_frame(frame)
        while frame != root:
            edge = self._edges[frame]
            T_parent_frame = edge.at(stamp_ns)
            if T_parent_frame is None:
                return None
            T_here_frame, frame = T_parent_frame @ T_here_frame, edge.parent
        return T_here_frame
