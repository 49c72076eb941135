# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection of a closed lift cabin: walls nearby on all sides, for some time.

A lidar cannot see the motion of a closed cabin, so the storey is unknown until the doors open. The
caller checks for the position of a lift; closets and lobbies look the same from inside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.stamps import NS_PER_S

CABIN_M = 3.0
"""Physical: diagonal of a large lift; nothing inside is further away."""

_BAND_M = 0.5
"""Physical: height above and below the sensor that is used; excludes floor and ceiling."""

# Numerical:
_SECTORS = 36  # azimuth sectors to search for an opening; a lift door covers several
_STRAY = 1  # open sectors that are allowed for noise or a mirror
# Chosen, not measured:
_SEEN = 0.7  # least share of sectors with returns; a forward-looking sensor is not sufficient
_SHUT_S = 1.0  # shortest time enclosed to count as closed; a ride takes several seconds


def is_shut_in(points: NDArray[np.float32], T_odom_sensor: NDArray[np.float64]) -> bool:
    """
    Return whether a scan has no returns further away than a lift's walls.

    Parameters
    ----------
    points : (P, 3) returns, sensor frame [m]
    T_odom_sensor : (4, 4) its pose, to level the points
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
    """Tracks over scans whether the robot is in a closed cabin, and since when."""

    def __init__(self) -> None:
        self.is_shut = False
        """Whether the robot has been enclosed for at least ``_SHUT_S``."""
        self._since_ns: int | None = None

    @property
    def is_shutting(self) -> bool:
        """Whether the robot is enclosed in the newest scan."""
        return self._since_ns is not None

    def follow(
        self, stamp_ns: int, points: NDArray[np.float32], T_odom_sensor: NDArray[np.float64]
    ) -> bool:
        """Add a scan; return whether it changed :attr:`is_shut`."""
        before = self.is_shut
        if not is_shut_in(points, T_odom_sensor):
            self.forget()
        else:
            if self._since_ns is None or stamp_ns < self._since_ns:
                self._since_ns = stamp_ns
            self.is_shut = before or stamp_ns - self._since_ns >= _SHUT_S * NS_PER_S
        return self.is_shut is not before

    def forget(self) -> None:
        """Reset the state."""
        self.is_shut, self._since_ns = False, None
