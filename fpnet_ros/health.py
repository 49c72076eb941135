# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Health of a localizer node: silent inputs, and dropped or lost scans."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
import math
import time
from typing import Any

from fpnet_core.io.topic_names import CLOCK_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import LocalizerOutput, Status
from fpnet_ros.inputs import ScanInput
from fpnet_ros.logs import NodeLog
from fpnet_ros.settings import STALE_INPUT_S
from fpnet_ros.wiring import LARGE_CLOUDS
from fpnet_ros.work import DroppingWorker
from msg_adapters.diagnostics import LocalizerReport, report_of_output

LOST = 'scans are lost in transport: see "Large clouds"'
"""Warning about scans that do not arrive. Given."""

# Chosen: an input counts as missing if its age exceeds this many seconds, or this share of the
# time without a located scan, which matters for recordings played faster than real time.
_HEARD_S, _HEARD_SHARE = 0.5, 0.5

_SLOW = 'scans are dropped: they arrive faster than they can be added'
_UNLOCATED = 'scans are dropped: their poses do not arrive, see the log'
_REFUSED = 'scans are refused: see the log'
_PAST = 'scans are dropped: their stamps do not advance, although those of the odometry do'
_REMEDIES = {
    _SLOW: 'send smaller clouds, or every second one, and check what else uses the CPU',
    _PAST: "check whether the lidar's clock was set back, two drivers publish on one topic, or a "
    'driver repeats a stamp',
    LOST: LARGE_CLOUDS,
}

DIAGNOSTICS_PERIOD_S = 1.0
"""Period of a node's diagnostics. Chosen."""


class ClockSilence:
    """
    Time since simulated time last advanced: a paused recording, or no ``/clock`` at all.

    ``clock`` is the node's; system time always advances.
    """

    def __init__(self, clock: Any) -> None:
        self._clock = clock
        self._now_ns = 0  # before the first /clock
        self._moved_s, self._runs_since_s = time.monotonic(), -math.inf

    @property
    def age_s(self) -> float:
        """Time since the clock last advanced [s], as seen by calls of this property."""
        now_ns, now_s = self._clock.now().nanoseconds, time.monotonic()
        if now_ns != self._now_ns or not self._clock.ros_time_is_active:
            if now_s - self._moved_s > STALE_INPUT_S:
                self._runs_since_s = now_s
            self._now_ns, self._moved_s = now_ns, now_s
        return now_s - self._moved_s

    def without(self, ages_s: Mapping[str, float]) -> dict[str, float]:
        """Return ages of inputs [s] without the time in which the clock stood still."""
        still_s = self.age_s
        ran_s = self._moved_s - self._runs_since_s
        return {name: min(age_s - still_s, ran_s) for name, age_s in ages_s.items()}


class Health:
    """
    Collects counts, ages and warnings of one localizer node, and logs lost scans.

    ``scans`` is the worker that adds scans. While the node's clock stands still no other input
    counts as silent.
    """

    def __init__(
        self, inputs: ScanInput, scans: DroppingWorker[Any], clock: Any, log: NodeLog
    ) -> None:
        self._inputs, self._scans, self._log = inputs, scans, log
        self._clock = ClockSilence(clock)
        self._scan_ns: int | None = None  # when a located scan was last added, by the node's clock
        self._scan_s = time.monotonic()  # the same by the monotonic clock
        self.is_starved = False
        """Whether scans have stopped, which invalidates an accepted pose."""

    @property
    def silence_s(self) -> dict[str, float]:
        """Time since the last message of each topic while the clock ran [s], ``/clock`` first."""
        return {CLOCK_TOPIC: self._clock.age_s, **self._clock.without(self._inputs.silence_s)}

    def saw_scan(self, now_ns: int) -> None:
        """Note that a scan with a pose was added now, by the node's clock."""
        self._scan_ns, self._scan_s = now_ns, time.monotonic()

    def has_turned(self, now_ns: int, scan_timeout_s: float) -> bool:
        """Return whether scans have stopped or resumed since the last call."""
        last_ns, before = self._scan_ns, self.is_starved
        self.is_starved = last_ns is not None and now_ns - last_ns > scan_timeout_s * NS_PER_S
        return self.is_starved is not before

    def news(self, output: LocalizerOutput, stale_input_s: float) -> LocalizerReport:
        """Return :meth:`report`, with a warning about scans lost since the last call."""
        return self.report(output, stale_input_s, self._log.losses(self._lost(), _REMEDIES))

    def report(
        self, output: LocalizerOutput, stale_input_s: float, losses: Sequence[str] = ()
    ) -> LocalizerReport:
        """Return the report of an update; it warns about inputs silent for longer [s]."""
        inputs, scans, lost = self._inputs, self._scans, self._lost()
        ages_s = {CLOCK_TOPIC: self._clock.age_s, **self._clock.without(inputs.ages_s)}
        silent = {name: age_s for name, age_s in ages_s.items() if age_s > stale_input_s}
        silences = (f'no {n.removesuffix("_age_s")} for {s:.0f} s' for n, s in silent.items())
        warning = ', '.join([*losses, *silences])
        figures = {
            **inputs.ages_s,
            'scan_ms': scans.work_ms,
            'scans': float(scans.done),
            'dropped_scans': float(lost[_SLOW] + lost[_UNLOCATED] + lost[_PAST]),
            'refused_scans': float(lost[_REFUSED]),
            'lost_scans': float(lost[LOST]),
            'earlier_scans': float(inputs.earlier),
        }
        is_starved = self.is_starved and output.status is not Status.NO_PLAN
        if not (is_starved or self._lacks_input(output, stale_input_s)):
            return report_of_output(output, figures, warning)
        since = 'arrives any more' if is_starved else 'has arrived yet'
        reason = f'no scan with a pose {since}: {self._missing()}'
        report = report_of_output(output, figures, warning or 'scans have stopped')
        return replace(report, status=Status.WAITING, probability=0.0, reason=reason)

    def _lacks_input(self, output: LocalizerOutput, stale_input_s: float) -> bool:
        """Return whether no located scan ever arrived and one of its topics is silent."""
        if self._scan_ns is not None or output.status is not Status.WAITING:
            return False
        return max(self._clock.without(self._inputs.silence_s).values()) > stale_input_s

    def _missing(self) -> str:
        """Return a text that says why no located scan arrives."""
        topic, age_s = max(self._inputs.silence_s.items(), key=lambda silent: silent[1])
        if age_s > min(_HEARD_S, _HEARD_SHARE * (time.monotonic() - self._scan_s)):
            return f'no message on {topic} for {age_s:.1f} s'
        return self._inputs.waits_for or 'see the log'

    def _lost(self) -> dict[str, int]:
        """Return the number of unused scans so far, by warning."""
        inputs, scans = self._inputs, self._scans
        return {
            _SLOW: scans.dropped,
            _UNLOCATED: inputs.unlocated,
            _PAST: inputs.past,
            _REFUSED: scans.refused + inputs.refused,
            LOST: inputs.lost,
        }
