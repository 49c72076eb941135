# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Returns over the last metres of the path: the part of a submap too recent for odometry drift."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

# Numerical: a scan is kept after this much translation or rotation since the last kept one.
_STEP_M, _STEP_RAD = 0.25, 0.25
_SCANS = 24  # numerical
RECENT_M = _STEP_M * _SCANS
"""Numerical: length of the path that recent returns cover; shorter where the robot turns."""

_UNBENT = 8  # numerical: kept scans over so short a path that drift has not deformed them
# Numerical: number of newest scans; a non-repetitive scanner needs more than one.
_NEWEST = 3
# Numerical: number of returns kept per scan, and edge of the squares that output one return each.
_RETURNS = 400
_SPACING_M = 0.1  # numerical
_SECTOR_RAD = 0.005  # numerical: returns within a sector this narrow share one direction
_BEHIND_M = 0.5  # physical: depth range of a wall in a sector, at a slant 10 m down a corridor


class RecentReturns:
    """Returns at body height of the last scans, kept every few decimetres of path."""

    def __init__(self) -> None:
        self._scans: deque[NDArray[np.float64]] = deque(maxlen=_SCANS)
        self._newest: deque[NDArray[np.float64]] = deque(maxlen=_NEWEST)
        self._walls: deque[NDArray[np.float64]] = deque(maxlen=_NEWEST)
        self._place = np.full(2, np.inf)
        self._yaw = 0.0
        self.unbent: NDArray[np.float64] = np.zeros((0, 2))
        """Returns of the last few kept scans ``(P, 2)`` [m]; replaced when a scan is kept."""

    def add(
        self,
        returns: NDArray[np.float64],
        is_wall: NDArray[np.bool_],
        xy: NDArray[np.float64],
        yaw: float,
    ) -> None:
        """
        Add the returns ``(P, 2)`` of a scan from ``xy (2,)``, all in one frame [m].

        ``is_wall (P,)`` marks returns with nothing seen behind them.
        """
        chosen = np.linspace(0, len(returns) - 1, min(_RETURNS, len(returns))).astype(np.int64)
        self._newest.append(returns[chosen])
        self._walls.append(returns[chosen][is_wall[chosen]])
        turned = abs(np.angle(np.exp(1j * (yaw - self._yaw))))
        if np.hypot(*(xy - self._place)) < _STEP_M and turned < _STEP_RAD:
            return
        self._place, self._yaw = xy.copy(), yaw
        self._scans.append(self._newest[-1])
        self.unbent = np.concatenate(list(self._scans)[-_UNBENT:])

    def points(self) -> NDArray[np.float64]:
        """Return the kept returns ``(P, 2)``, thinned evenly [m]."""
        everything = np.concatenate([np.zeros((0, 2)), *self._scans])
        if not len(everything):
            return everything
        squares = np.floor(everything / _SPACING_M).astype(np.int64)
        rows, cols = (squares - squares.min(axis=0)).T
        _, first = np.unique(rows * (cols.max() + 1) + cols, return_index=True)
        return np.asarray(everything[first])

    def newest(self) -> NDArray[np.float64]:
        """Return the returns ``(P, 2)`` of the last few scans [m]."""
        return np.concatenate([np.zeros((0, 2)), *self._newest])

    def newest_walls(self) -> NDArray[np.float64]:
        """Return the newest returns ``(P, 2)`` with nothing seen behind them [m]."""
        return np.concatenate([np.zeros((0, 2)), *self._walls])


def is_last_seen(rays: NDArray[np.float64]) -> NDArray[np.bool_]:
    """
    Return which returns of one scan have nothing seen behind them at any height, ``(P,)``.

    A wall occludes everything behind it; over a cabinet and under a table the sensor sees more of
    the room. ``rays (P, 2)`` go from the scan's origin to its returns [m].
    """
    reach = np.hypot(*rays.T)
    sector = np.floor(np.arctan2(rays[:, 1], rays[:, 0]) / _SECTOR_RAD).astype(np.int64)
    sector -= sector.min(initial=0)
    farthest = np.zeros(sector.max(initial=0) + 1)
    np.maximum.at(farthest, sector, reach)
    return np.asarray(reach >= farthest[sector] - _BEHIND_M)
