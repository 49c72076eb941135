# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Named frames that move against one another: where was a sensor when it looked?"""

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
    Return a frame's name without a slash before it.

    Some publishers still put one there; tf2 knows none, so both are the same frame.
    """
    return frame.lstrip('/')


@dataclass(eq=False)
class _Edge:
    """``T_parent_child``, always the same or over time."""

    parent: str
    place: Array | PoseTrack

    def at(self, stamp_ns: int) -> Array | None:
        return self.place.at(stamp_ns) if isinstance(self.place, PoseTrack) else self.place


class FrameTree:
    """
    Transforms by frame name and time; a frame has one parent, the last one given.

    Names are compared as :func:`plain_frame` returns them. Nothing is ever
    taken to coincide: what no transform joins is unknown, in a recording as on a robot.

    Parameters
    ----------
    horizon_s : how long moving transforms are kept
    max_gap_s : no interpolation between samples further apart
    """

    def __init__(self, horizon_s: float = 10.0, max_gap_s: float = MAX_GAP_NS / NS_PER_S) -> None:
        self._horizon_ns = int(horizon_s * NS_PER_S)
        self._max_gap_ns = int(max_gap_s * NS_PER_S)
        self._edges: dict[str, _Edge] = {}

    def clear(self) -> None:
        """Forget everything that moves; what is fixed stays."""
        self._edges = {
            child: edge
            for child, edge in self._edges.items()
            if not isinstance(edge.place, PoseTrack)
        }

    def add_fixed(self, parent: str, child: str, T_parent_child: Array) -> None:
        """Take a transform that never changes."""
        self._edges[plain_frame(child)] = _Edge(plain_frame(parent), T_parent_child)

    def add(self, parent: str, child: str, T_parent_child: Array, stamp_ns: int) -> None:
        """
        Take a sample of a moving transform.

        Where the clock goes back, as in a looping recording, the edge starts anew.
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

        None where the frames are not connected or a sample before or after that time is missing;
        :meth:`reason` says which.
        """
        joint = self._joint(target, source)
        if joint is None:
            return None
        T_joint_target = self._along(target, joint, stamp_ns)
        T_joint_source = self._along(source, joint, stamp_ns)
        if T_joint_target is None or T_joint_source is None:
            return None
        T_target_source: Array = np.linalg.inv(T_joint_target) @ T_joint_source
        return T_target_source

    def mount(self, base: str, sensor: str) -> Array:
        """
        Return ``T_base_sensor (4, 4)``, where a sensor sits on a robot.

        Raises
        ------
        OdometryError
            If nothing fixed joins both: the sensor may be anywhere on the robot.
        """
        T_base_sensor = self.lookup(base, sensor, 0)
        if T_base_sensor is None:
            raise OdometryError(self.reason(base, sensor, 0))
        return T_base_sensor

    def reason(self, target: str, source: str, stamp_ns: int) -> str:
        """Return in words why :meth:`lookup` knows nothing."""
        target, source = plain_frame(target), plain_frame(source)
        if not target:
            return f'the place of {source!r} is unknown: the odometry names no child_frame_id'
        if self._joint(target, source) is None:
            return (
                f'the place of {source!r} on {target!r} is unknown: no transform on /tf_static '
                'joins them'
            )
        return f'{source!r} in {target!r} is unknown at {stamp_ns} ns: no pose before and after it'

    def parent(self, frame: str) -> str | None:
        """Return the parent of a frame, None where nobody has named one."""
        edge = self._edges.get(plain_frame(frame))
        return None if edge is None else edge.parent

    def children(self, frame: str) -> list[str]:
        """Return the frames whose parent a frame is, in the order in which they came."""
        frame = plain_frame(frame)
        return [child for child, edge in self._edges.items() if edge.parent == frame]

    def root(self, frame: str) -> str:
        """Return the last ancestor of a frame, itself where it has no parent."""
        return self._chain(frame)[-1]

    def body(self, frame: str) -> str:
        """Return the last ancestor of a frame that it is fixed to, itself where there is none."""
        chain = self._chain(frame)
        for here, above in pairwise(chain):
            if isinstance(self._edges[here].place, PoseTrack):
                return here
            frame = above
        return plain_frame(frame)

    def _joint(self, one: str, other: str) -> str | None:
        """Return the nearest common ancestor of two frames, None where they have none."""
        above = self._chain(one)
        return next((frame for frame in self._chain(other) if frame in above), None)

    def _chain(self, frame: str) -> list[str]:
        """Return the frame and its ancestors; a loop ends where it closes."""
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
