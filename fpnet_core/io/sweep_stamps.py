# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reference time of a sweep's pose: drivers stamp the start, the middle or the end of a sweep.

Odometry deskews sweeps with point times to their end, so poses refer to the end. Drivers stamp
either end; an error of 0.1 s is 5 degrees at 50 degrees per second.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
import logging
from typing import Any

import numpy as np

from fpnet_core.config import ScanStamp
from fpnet_core.io.pointcloud2 import LONGEST_SWEEP_S, CloudArrays
from fpnet_core.stamps import NS_PER_S

_log = logging.getLogger(__name__)

_SAME_NS = 2_000_000
"""
If the end is closer to the header's stamp than this, the stamp is kept, so that it still
identifies the cloud. Numerical: the gap between two firings, or 0.1 degrees at 50 degrees/s.
"""

_PERIODS = 9  # numerical: their median is the sensor's period even if clouds are lost

_TO_END = {'start': 1.0, 'middle': 0.5, 'end': 0.0}  # given by definition: shares of a sweep
_TO_MIDDLE = {'start': 0.5, 'middle': 0.0, 'end': -0.5, 'auto': 0.0}  # given by definition

_NO_TIMES = (
    'clouds have no time per point: their stamp is assumed to be the middle of a sweep; set '
    'scans.stamp if it is the start or the end'
)
_OTHER_CLOCK = (
    'point times are on another clock than the stamps of their clouds, which are assumed to be '
    'the end of a sweep; set scans.stamp if they are the start or the middle'
)


class SweepStamps:
    """
    Computes the reference times of one sensor's clouds, in order.

    Point times may be absolute on the header's clock or relative to its stamp; both give the time
    of the last point. Without point times, the reference is the middle of the sweep, where a
    skewed cloud fits best.

    Parameters
    ----------
    scan_stamp
        Part of the sweep that the header's stamp refers to; ``auto`` uses the point times.
    say
        Called with each assumption that is made without evidence, once each.
    """

    def __init__(
        self, scan_stamp: ScanStamp = 'auto', say: Callable[[str], Any] = _log.warning
    ) -> None:
        self._scan_stamp: ScanStamp = scan_stamp
        self._report = say
        self._reported: set[str] = set()
        self._last_ns: int | None = None
        self._periods_ns: deque[int] = deque(maxlen=_PERIODS)

    def pose_ns(self, cloud: CloudArrays, stamp_ns: int) -> int:
        """
        Return the reference time of a cloud's pose.

        This is the time of the last point, or the middle of the sweep without point times.
        """
        if cloud.time_s is None or not len(cloud.time_s) or not cloud.time_s.any():
            return stamp_ns + self._to_middle_ns(stamp_ns)
        span_s = float(cloud.time_s.max())
        if self._scan_stamp == 'auto':
            to_end_s = self._to_end_s(cloud.first_s, span_s, stamp_ns / NS_PER_S)
        else:
            to_end_s = _TO_END[self._scan_stamp] * span_s
        to_end_ns = round(to_end_s * NS_PER_S)
        return stamp_ns + (to_end_ns if abs(to_end_ns) > _SAME_NS else 0)

    def _to_end_s(self, first_s: float, span_s: float, stamp_s: float) -> float:
        """Return the time from the stamp to the last point, from the point times."""
        to_first_s = min(first_s, first_s - stamp_s, key=abs)
        if abs(to_first_s) > LONGEST_SWEEP_S:
            self._report_once(_OTHER_CLOCK)
            return 0.0
        return to_first_s + span_s

    def _to_middle_ns(self, stamp_ns: int) -> int:
        if self._scan_stamp == 'auto':
            self._report_once(_NO_TIMES)
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if last_ns is not None and 0 < stamp_ns - last_ns < LONGEST_SWEEP_S * NS_PER_S:
            self._periods_ns.append(stamp_ns - last_ns)
        period_ns = float(np.median(self._periods_ns)) if self._periods_ns else 0.0
        return round(_TO_MIDDLE[self._scan_stamp] * period_ns)

    def _report_once(self, text: str) -> None:
        if text not in self._reported:
            self._reported.add(text)
            self._report(text)


def in_silence(_: str) -> None:
    """Ignore the message: registered clouds are stamped like their poses."""
