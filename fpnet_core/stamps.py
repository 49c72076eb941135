# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Times are whole nanoseconds since the epoch of whatever clock stamped the data, as in ROS 2."""

from __future__ import annotations

from fpnet_core.errors import OdometryError

NS_PER_S = 1_000_000_000
"""Nanoseconds of a second. Physical: by definition."""


class ClockGuard:
    """
    Tells single scans from the past from a clock that went back, as a looping recording's does.

    Parameters
    ----------
    patience
        Scans in a row from the past that are a clock that went back; fewer are disorder on the
        way, or two publishers.
    """

    def __init__(self, patience: int) -> None:
        self._patience = patience
        self._stale = 0

    def back_s(self, stamp_ns: int, last_ns: int) -> float | None:
        """
        Return by how much the clock went back between two scans [s]; None where it went on.

        Raises
        ------
        OdometryError
            If the scan is no newer than the last one and not yet one of many.
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
