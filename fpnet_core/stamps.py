# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Time stamps: integer nanoseconds since the epoch of the clock of the data, as in ROS 2."""

from __future__ import annotations

from fpnet_core.errors import OdometryError

NS_PER_S = 1_000_000_000
"""Nanoseconds per second. Physical: by definition."""


class ClockGuard:
    """
    Detector of a clock that was set back, for example by a looping recording.

    Parameters
    ----------
    patience
        Consecutive scans with old stamps that count as a reset; fewer are reordered messages or
        come from a second publisher.
    """

    def __init__(self, patience: int) -> None:
        self._patience = patience
        self._stale = 0

    def back_s(self, stamp_ns: int, last_ns: int) -> float | None:
        """
        Return by how much the clock went back between two scans [s]; None if it advanced.

        Raises
        ------
        OdometryError
            If the scan is not newer than the last one and it is not yet a clock reset.
        """
        if stamp_ns > last_ns:
            self._stale = 0
            return None
        self._stale += 1
        if self._stale < self._patience:
            raise OdometryError(
                f'scan at {stamp_ns} ns is not newer than the last one at {last_ns} ns; it was '
                'dropped (is the recording looping, or are there two publishers?)'
            )
        self._stale = 0
        return (last_ns - stamp_ns) / NS_PER_S
