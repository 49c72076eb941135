# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Named frames that move against one another: where was a sensor when it looked?"""

from __future__ import annotations

from bisect import bisect_right, insort
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]

# Samples arrive out of order by less than this; one that is older says that the clock went back.
_DISORDER_NS = NS_PER_S


@dataclass(eq=False)
class _Edge:
    """``T_parent_child`` over time; one sample without a stamp where it never moves."""

    parent: str
    stamps_ns: list[int] = field(default_factory=list)
    samples: dict[int, Array] = field(default_factory=dict)
    fixed: Array | None = None


class FrameTree:
    """
    Transforms by frame name and time; a frame has one parent, the last one given.

    Parameters
    ----------
    horizon_s : how long moving transforms are kept
    max_gap_s : no interpolation between samples further apart
    """

    def __init__(self, horizon_s: float = 10.0, max_gap_s: float = 0.5) -> None:
        self._horizon_ns = int(horizon_s * NS_PER_S)
        self._max_gap_ns = int(max_gap_s * NS_PER_S)
        self._edges: dict[str, _Edge] = {}

    def clear(self) -> None:
        """Forget everything that moves; what is fixed stays."""
        self._edges = {c: edge for c, edge in self._edges.items() if edge.fixed is not None}

    def add_fixed(self, parent: str, child: str, T_parent_child: Array) -> None:
        """Take a transform that never changes."""
        self._edges[child] = _Edge(parent, fixed=T_parent_child)

    def add(self, parent: str, child: str, T_parent_child: Array, stamp_ns: int) -> None:
        """
        Take a sample of a moving transform.

        Where the clock goes back, as in a looping recording, the edge starts anew.
        """
        edge = self._edges.get(child)
        if edge is None or edge.parent != parent or edge.fixed is not None:
            edge = self._edges[child] = _Edge(parent)
        if edge.stamps_ns and stamp_ns < edge.stamps_ns[-1] - _DISORDER_NS:
            edge = self._edges[child] = _Edge(parent)
        if stamp_ns not in edge.samples:
            insort(edge.stamps_ns, stamp_ns)
        edge.samples[stamp_ns] = T_parent_child
        while edge.stamps_ns[-1] - edge.stamps_ns[0] > self._horizon_ns:
            del edge.samples[edge.stamps_ns.pop(0)]

    def lookup(self, target: str, source: str, stamp_ns: int) -> Array | None:
        """
        Return ``T_target_source (4, 4)`` at a time.

        None where the frames are not connected or a sample before or after that time is missing.
        """
        to_target = self._chain(target)
        to_source = self._chain(source)
        root = next((frame for frame in to_source if frame in to_target), None)
        if root is None:
            return None
        T_root_target = self._along(target, root, stamp_ns)
        T_root_source = self._along(source, root, stamp_ns)
        if T_root_target is None or T_root_source is None:
            return None
        T_target_source: Array = np.linalg.inv(T_root_target) @ T_root_source
        return T_target_source

    def _chain(self, frame: str) -> list[str]:
        """Return the frame and its ancestors; a loop ends where it closes."""
        chain = [frame]
        while (edge := self._edges.get(chain[-1])) is not None and edge.parent not in chain:
            chain.append(edge.parent)
        return chain

    def _along(self, frame: str, root: str, stamp_ns: int) -> Array | None:
        """Return ``T_root_frame`` through the ancestors of ``frame``."""
        T_here_frame = np.eye(4)
        while frame != root:
            edge = self._edges[frame]
            T_parent_frame = self._sample(edge, stamp_ns)
            if T_parent_frame is None:
                return None
            T_here_frame, frame = T_parent_frame @ T_here_frame, edge.parent
        return T_here_frame

    def _sample(self, edge: _Edge, stamp_ns: int) -> Array | None:
        if edge.fixed is not None:
            return edge.fixed
        if (exact := edge.samples.get(stamp_ns)) is not None:
            return exact
        after = bisect_right(edge.stamps_ns, stamp_ns)
        if after in (0, len(edge.stamps_ns)):
            return None
        before_ns, after_ns = edge.stamps_ns[after - 1], edge.stamps_ns[after]
        if after_ns - before_ns > self._max_gap_ns:
            return None
        share = (stamp_ns - before_ns) / (after_ns - before_ns)
        return _between(edge.samples[before_ns], edge.samples[after_ns], share)


def _between(start: Array, end: Array, share: float) -> Array:
    """Return the transform at ``share`` of the way: straight, and turning evenly."""
    m = np.eye(4)
    turn = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], end[:3, :3]]))
    m[:3, :3] = turn(share).as_matrix()
    m[:3, 3] = (1.0 - share) * start[:3, 3] + share * end[:3, 3]
    return m
