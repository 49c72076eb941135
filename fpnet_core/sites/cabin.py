# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A lift whose doors are shut: walls near by on all sides, for a while.

A cabin moves without anything that a lidar sees, so where its doors open nobody knows before they
do. The caller knows where lifts are; closets and lobbies look the same from within.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.stamps import NS_PER_S

CABIN_M = 3.0
"""Physical: from one corner of a large lift to the other; nothing inside is further off."""

_BAND_M = 0.5
"""Physical: of height, above and below the sensor; neither floor nor ceiling is meant."""

# Numerical:
_SECTORS = 36  # in which one looks for an opening; a lift's doors take several of them
_STRAY = 1  # sectors that noise or a mirror may reach into
# Chosen, not measured:
_SEEN = 0.7  # share of the sectors that must be seen: who looks ahead only cannot tell
_SHUT_S = 1.0  # for so long: doors that close; a ride takes several seconds


def is_shut_in(points: NDArray[np.float32], T_odom_sensor: NDArray[np.float64]) -> bool:
    """
    Tell whether a scan sees nothing that is further off than a lift's walls.

    Parameters
    ----------
    points : (P, 3) returns, sensor frame [m]
    T_odom_sensor : (4, 4) its pose, for what is level
    """
    level = points @ T_odom_sensor[:3, :3].T.astype(np.float32)
    x, y, z = level.T
    band = np.abs(z) <= _BAND_M
    turn = np.arctan2(y[band], x[band]) / (2.0 * np.pi)
    farthest = np.zeros(_SECTORS, dtype=np.float32)
    np.maximum.at(farthest, np.floor(turn * _SECTORS).astype(int), np.hypot(x[band], y[band]))
    open_sectors = np.count_nonzero(farthest > CABIN_M)
    return bool((farthest > 0.0).mean() >= _SEEN and open_sectors <= _STRAY)


class CabinWatch:
    """Follows scans; knows whether the robot is shut in, and since when."""

    def __init__(self) -> None:
        self.is_shut = False
        """Whether it has been shut in for a while."""
        self._since_ns: int | None = None

    @property
    def is_shutting(self) -> bool:
        """Whether the robot is shut in, be it for a moment."""
        return self._since_ns is not None

    def follow(
        self, stamp_ns: int, points: NDArray[np.float32], T_odom_sensor: NDArray[np.float64]
    ) -> bool:
        """Take a scan; tell whether :attr:`is_shut` has changed with it."""
        before = self.is_shut
        if not is_shut_in(points, T_odom_sensor):
            self.forget()
        else:
            if self._since_ns is None or stamp_ns < self._since_ns:
                self._since_ns = stamp_ns
            self.is_shut = before or stamp_ns - self._since_ns >= _SHUT_S * NS_PER_S
        return self.is_shut is not before

    def forget(self) -> None:
        """Begin anew."""
        self.is_shut, self._since_ns = False, None
