# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Angular rates of a gyroscope over time, and the orientation from integrating them."""

from __future__ import annotations

from array import array
from bisect import bisect_left, bisect_right

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fpnet_core.stamps import NS_PER_S

Array = NDArray[np.float64]

MAX_GAP_NS = NS_PER_S // 10
"""Largest gap between two rates that is integrated. Chosen: at least 10 Hz."""


class GyroTrack:
    """
    Buffer of angular rates ``(3,)`` in the sensor's frame [rad/s].

    Parameters
    ----------
    horizon_ns
        How long rates are kept [ns]; None keeps all of them.
    """

    def __init__(self, horizon_ns: int | None = None) -> None:
        self._horizon_ns = horizon_ns
        self._stamps_ns, self._rates = array('q'), array('d')
        self._last_ns, self._R = 0, np.eye(3)

    def __len__(self) -> int:
        """Return the number of rates."""
        return len(self._stamps_ns)

    @property
    def newest_ns(self) -> int:
        """Stamp of the newest rate [ns], 0 if there is none."""
        return self._stamps_ns[-1] if self._stamps_ns else 0

    def add(self, stamp_ns: int, rate: ArrayLike) -> None:
        """Add a rate ``(3,)``; drop all earlier ones if the clock jumps back."""
        if stamp_ns <= self.newest_ns:
            if stamp_ns > self.newest_ns - MAX_GAP_NS:
                return  # out of order, or a duplicate
            del self._stamps_ns[:], self._rates[:]
        self._stamps_ns.append(stamp_ns)
        self._rates.extend(np.asarray(rate, dtype=np.float64).tolist())
        if self._horizon_ns is not None:
            old = bisect_right(self._stamps_ns, stamp_ns - self._horizon_ns)
            del self._stamps_ns[:old], self._rates[: 3 * old]

    def at(self, stamp_ns: int) -> Array | None:
        """
        Return the orientation ``R_start_sensor (3, 3)`` at a time; call with increasing times.

        The first call defines the start. None if rates since the last call are missing or have a
        gap; later calls then return the rotation from here on.
        """
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if not last_ns:
            return self._R
        turn = self._turn(last_ns, stamp_ns)
        if turn is None:
            return None
        self._R = self._R @ turn
        return self._R

    def _turn(self, first_ns: int, last_ns: int) -> Array | None:
        """Return ``R_first_last (3, 3)``, or None if rates are missing."""
        stamps = self._stamps_ns
        begin, end = bisect_right(stamps, first_ns) - 1, bisect_left(stamps, last_ns) + 1
        if last_ns <= first_ns or begin < 0 or end > len(stamps):
            return None
        known_ns = np.array(stamps[begin:end])
        if np.diff(known_ns).max(initial=0) > MAX_GAP_NS:
            return None
        rates = np.array(self._rates[3 * begin : 3 * end]).reshape(-1, 3)
        within = known_ns[(known_ns > first_ns) & (known_ns < last_ns)]
        at_ns = np.concatenate([[first_ns], within, [last_ns]])
        at = np.stack([np.interp(at_ns, known_ns, rate) for rate in rates.T], axis=1)
        seconds = np.diff(at_ns) / NS_PER_S
        turn = np.eye(3)
        for step in Rotation.from_rotvec(0.5 * (at[1:] + at[:-1]) * seconds[:, None]).as_matrix():
            turn = turn @ step
        return turn
