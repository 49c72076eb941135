# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Which instant a sweep's pose is of: a header's stamp may be of the start, the middle or the end.

Odometry brings all points of a sweep with times to its end, so that is what its pose is of.
Drivers stamp either end, and a tenth of a second late is 5 degrees at 50 degrees per second.
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
An end nearer to the header's stamp than this is that stamp, by which others know the cloud.
Numerical: the gap between two firings, or a tenth of a degree at 50 degrees per second.
"""

_PERIODS = 9  # numerical: their median is the sensor's, however many clouds get lost

_TO_END = {'start': 1.0, 'middle': 0.5, 'end': 0.0}  # given by the words: shares of a sweep
_TO_MIDDLE = {'start': 0.5, 'middle': 0.0, 'end': -0.5, 'auto': 0.0}  # given by the words

_NO_TIMES = (
    'clouds carry no time for each point: their stamp is taken for the middle of a sweep; set '
    'scans.stamp where it is of the start or the end'
)
_OTHER_CLOCK = (
    'the times of points are on another clock than the stamps of their clouds, which are taken '
    'for the end of a sweep; set scans.stamp where they are of the start or the middle'
)


class SweepStamps:
    """
    Tells of one sensor's clouds when their poses are, one after another.

    Times of points are absolute on the header's clock, or relative to its stamp; either tells
    when the last point was seen. Without them the pose of a
    cloud is that of its middle, which is where it fits best, bent by the motion or not.

    Parameters
    ----------
    scan_stamp
        What the header's stamp is of; ``auto`` believes the times of points.
    say
        Takes what is assumed where nothing tells, once each.
    """

    def __init__(
        self, scan_stamp: ScanStamp = 'auto', say: Callable[[str], Any] = _log.warning
    ) -> None:
        self._scan_stamp: ScanStamp = scan_stamp
        self._say = say
        self._said: set[str] = set()
        self._last_ns: int | None = None
        self._periods_ns: deque[int] = deque(maxlen=_PERIODS)

    def pose_ns(self, cloud: CloudArrays, stamp_ns: int) -> int:
        """
        Return the instant that the pose of a cloud is of.

        That of the last point; of a cloud without times for its points the middle of the sweep.
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
        """Return how long after the stamp the last point was seen, by the points' times."""
        to_first_s = min(first_s, first_s - stamp_s, key=abs)
        if abs(to_first_s) > LONGEST_SWEEP_S:
            self._say_once(_OTHER_CLOCK)
            return 0.0
        return to_first_s + span_s

    def _to_middle_ns(self, stamp_ns: int) -> int:
        if self._scan_stamp == 'auto':
            self._say_once(_NO_TIMES)
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if last_ns is not None and 0 < stamp_ns - last_ns < LONGEST_SWEEP_S * NS_PER_S:
            self._periods_ns.append(stamp_ns - last_ns)
        period_ns = float(np.median(self._periods_ns)) if self._periods_ns else 0.0
        return round(_TO_MIDDLE[self._scan_stamp] * period_ns)

    def _say_once(self, text: str) -> None:
        if text not in self._said:
            self._said.add(text)
            self._say(text)


def in_silence(_: str) -> None:
    """Say nothing: the clouds were registered before, and their stamps are those of poses."""
