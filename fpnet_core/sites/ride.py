# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection of storey changes from the height of a 3D odometry.

Odometry drifts in height by some centimetres per metre, and ramps for robots have a slope of at
most 1:8; stairs, escalators and lifts are steeper than 1:2. In a closed cabin lidar odometry does
not see the motion; then the level must come from a hint.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.stamps import NS_PER_S

# Physical:
_RISE_M = 1.2  # half a storey, and more than the drift of odometry over _WITHIN_M
_WITHIN_M = 2.4  # length of path for this rise; over twice that it is a ramp
_FASTEST_MPS = 4.0  # speed of lifts for robots; faster motion is a jump of the odometry
_STILL_M = 0.2  # largest change of height without a ride
# Chosen, not measured:
_STILL_S = 2.0  # time at constant height after which a ride is over


@dataclass(frozen=True)
class Ride:
    """A change of height by ``rise_m``; ``is_over`` once the height is constant again."""

    rise_m: float
    is_over: bool


class RideWatch:
    """Tracks the height of scans in one odometry frame."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Reset the state, as for a new odometry frame."""
        self._path_m = 0.0
        self._last: tuple[int, NDArray[np.float64]] | None = None
        self._recent: deque[tuple[float, float]] = deque()  # recent path length and height
        self._start_m: float | None = None
        self._still: tuple[int, float] = (0, 0.0)  # time since when the height is constant, height

    def follow(self, stamp_ns: int, T_odom_sensor: NDArray[np.float64]) -> Ride | None:
        """Add a scan; return the ride that it begins or ends, or None."""
        xy, height_m = T_odom_sensor[:2, 3], float(T_odom_sensor[2, 3])
        if self._has_jumped(stamp_ns, T_odom_sensor[:3, 3]):
            self.forget()
        if self._last is not None:
            self._path_m += float(np.linalg.norm(xy - self._last[1][:2]))
        self._last = stamp_ns, np.array(T_odom_sensor[:3, 3])
        if self._start_m is not None:
            return self._ended_ride(stamp_ns, height_m)
        self._recent.append((self._path_m, height_m))
        while self._path_m - self._recent[0][0] > _WITHIN_M:
            self._recent.popleft()
        from_m = max(self._recent, key=lambda each: abs(height_m - each[1]))[1]
        if abs(height_m - from_m) < _RISE_M:
            return None
        self._start_m, self._still = from_m, (stamp_ns, height_m)
        return Ride(height_m - from_m, is_over=False)

    def _has_jumped(self, stamp_ns: int, place: NDArray[np.float64]) -> bool:
        """Return whether the odometry jumped to another frame, which is not a ride."""
        if self._last is None:
            return False
        seconds = (stamp_ns - self._last[0]) / NS_PER_S
        return bool(np.linalg.norm(place - self._last[1]) > _FASTEST_MPS * max(seconds, 0.1))

    def _ended_ride(self, stamp_ns: int, height_m: float) -> Ride | None:
        assert self._start_m is not None  # a ride has begun
        since_ns, at_m = self._still
        if abs(height_m - at_m) > _STILL_M:
            self._still = stamp_ns, height_m
            return None
        if stamp_ns - since_ns < _STILL_S * NS_PER_S:
            return None
        rise_m = height_m - self._start_m
        self.forget()
        return Ride(rise_m, is_over=True)
