# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Leaving a storey, by the height of a 3D odometry.

Odometry drifts in height, by some centimetres a metre, and ramps that robots take are 1 in 8 at
most; stairs, escalators and lifts are steeper than 1 in 2. A lift of which the odometry sees
nothing but the cabin does not move for it: there somebody has to say on which level it stops.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.stamps import NS_PER_S

# Physical:
_RISE_M = 1.2  # half a storey, and more than odometry drifts in so short a way
_WITHIN_M = 2.4  # of way: twice as far is a ramp
_FASTEST_MPS = 4.0  # lifts that robots take; what is faster is odometry that jumps
_STILL_M = 0.2  # height changes less where nobody rides or climbs
# Chosen, not measured:
_STILL_S = 2.0  # for so long at one height: the ride is over


@dataclass(frozen=True)
class Ride:
    """The robot has gone up by ``rise_m``; ``is_over`` once it stays at one height again."""

    rise_m: float
    is_over: bool


class RideWatch:
    """Follows the height of the scans of one odometry frame."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew, as with a new odometry frame."""
        self._way_m = 0.0
        self._last: tuple[int, NDArray[np.float64]] | None = None
        self._behind: deque[tuple[float, float]] = deque()  # way and height, not far behind
        self._begun_at_m: float | None = None
        self._still: tuple[int, float] = (0, 0.0)  # since when at which height

    def follow(self, stamp_ns: int, T_odom_sensor: NDArray[np.float64]) -> Ride | None:
        """Return the ride that a scan begins or ends; None where there is nothing new."""
        xy, height_m = T_odom_sensor[:2, 3], float(T_odom_sensor[2, 3])
        if self._has_jumped(stamp_ns, T_odom_sensor[:3, 3]):
            self.forget()
        if self._last is not None:
            self._way_m += float(np.linalg.norm(xy - self._last[1][:2]))
        self._last = stamp_ns, np.array(T_odom_sensor[:3, 3])
        if self._begun_at_m is not None:
            return self._until_it_ends(stamp_ns, height_m)
        self._behind.append((self._way_m, height_m))
        while self._way_m - self._behind[0][0] > _WITHIN_M:
            self._behind.popleft()
        from_m = max(self._behind, key=lambda each: abs(height_m - each[1]))[1]
        if abs(height_m - from_m) < _RISE_M:
            return None
        self._begun_at_m, self._still = from_m, (stamp_ns, height_m)
        return Ride(height_m - from_m, is_over=False)

    def _has_jumped(self, stamp_ns: int, place: NDArray[np.float64]) -> bool:
        """Tell whether this is another odometry frame rather than a ride."""
        if self._last is None:
            return False
        seconds = (stamp_ns - self._last[0]) / NS_PER_S
        return bool(np.linalg.norm(place - self._last[1]) > _FASTEST_MPS * max(seconds, 0.1))

    def _until_it_ends(self, stamp_ns: int, height_m: float) -> Ride | None:
        assert self._begun_at_m is not None  # a ride has begun
        since_ns, at_m = self._still
        if abs(height_m - at_m) > _STILL_M:
            self._still = stamp_ns, height_m
            return None
        if stamp_ns - since_ns < _STILL_S * NS_PER_S:
            return None
        rise_m = height_m - self._begun_at_m
        self.forget()
        return Ride(rise_m, is_over=True)
