# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Outputs kept of a run: all of them, with maps only as far as a memory limit allows."""

from __future__ import annotations

from array import array
from dataclasses import replace
import math

import numpy as np

from fpnet_core.geometry import SE2
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import UNKNOWN, GridMap, LocalizerOutput, Submap

# Numerical: the smallest possible map.
_NO_CELLS = GridMap(np.full((1, 1), UNKNOWN, np.int8), 1.0, frame='submap')
_BEST = 3  # chosen: placements shown in a report
_CHANGE_RANK = 6  # chosen: outputs with a status change rank with every 64th one


def in_brief(output: LocalizerOutput) -> LocalizerOutput:
    """Return an output without its maps; its submap keeps only the robot's last position."""
    seen = output.submap
    if seen is not None:
        at, no_lintel = seen.path_xy[-1:], np.zeros((1, 1), np.bool_)
        seen = Submap(_NO_CELLS, no_lintel, at, seen.T_odom_submap, seen.stamp_ns, seen.id)
    best = output.estimates.take(np.s_[:_BEST])
    return replace(output, submap=seen, segmentation=None, graph=None, match=None, estimates=best)


def is_brief(output: LocalizerOutput) -> bool:
    """Return whether an output has lost its maps."""
    return output.submap is not None and output.submap.grid.shape == _NO_CELLS.shape


class KeptOutputs:
    """
    Outputs of a run in time order, with a memory limit for their maps.

    The newest output keeps its maps. So do evenly spaced earlier ones and usually those
    with a change of status; all others are reduced by :func:`in_brief`.

    Parameters
    ----------
    map_bytes : memory for maps [bytes]
    """

    def __init__(self, map_bytes: float = math.inf) -> None:
        self._map_bytes = map_bytes
        self._outputs: list[LocalizerOutput] = []
        self._sizes: dict[int, int] = {}  # of the outputs with maps

    def append(self, output: LocalizerOutput) -> None:
        """Add the newest output."""
        self._sizes[len(self._outputs)] = _map_bytes(output)
        self._outputs.append(output)
        while len(self._sizes) > 1 and sum(self._sizes.values()) > self._map_bytes:
            least = min(list(self._sizes)[:-1], key=self._rank)
            del self._sizes[least]
            self._outputs[least] = in_brief(self._outputs[least])

    def _rank(self, index: int) -> int:
        """Return the rank by which maps are kept: how often two divides the output's number."""
        evenly = (index & -index).bit_length()
        before = self._outputs[max(index - 1, 0)]
        is_change = not index or before.status is not self._outputs[index].status
        return max(evenly, _CHANGE_RANK) if is_change else evenly

    @property
    def newest(self) -> tuple[LocalizerOutput, ...]:
        """The last two outputs in time order, or fewer."""
        return tuple(self._outputs[-2:])

    def all(self) -> tuple[LocalizerOutput, ...]:
        """Return all outputs."""
        return tuple(self._outputs)


def _map_bytes(output: LocalizerOutput) -> int:
    arrays = []
    if output.submap is not None:
        arrays += [output.submap.grid.cells, output.submap.lintel, output.submap.path_xy]
        arrays += [output.submap.recent_xy]
    if output.segmentation is not None:
        arrays += [output.segmentation.labels]
    return sum(each.nbytes for each in arrays)


class KeptPoses:
    """Stamped planar poses in compact arrays: a megabyte for an hour of scans."""

    def __init__(self) -> None:
        self._stamps_ns, self._poses = array('q'), array('d')

    def __len__(self) -> int:
        """Count the poses."""
        return len(self._stamps_ns)

    @property
    def first_ns(self) -> int:
        """Stamp of the first pose."""
        return self._stamps_ns[0]

    @property
    def last_ns(self) -> int:
        """Stamp of the last pose."""
        return self._stamps_ns[-1]

    def append(self, stamp_ns: int, T: SE2) -> None:
        """Add a pose."""
        self._stamps_ns.append(stamp_ns)
        self._poses.extend((*T.translation, T.yaw))

    def trajectory(self) -> PlanarTrajectory:
        """Return all poses as a trajectory."""
        poses = np.array(self._poses).reshape(-1, 3)
        return PlanarTrajectory(np.array(self._stamps_ns, np.int64), poses[:, :2], poses[:, 2])
