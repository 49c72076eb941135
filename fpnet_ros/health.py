# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How a localizer node fares beside what it says of the robot: its inputs and its scans."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
import math
import time
from typing import Any

from fpnet_core.io.topic_names import CLOCK_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import LocalizerOutput, Status
from fpnet_ros.inputs import ScanInput
from fpnet_ros.large_clouds import LARGE_CLOUDS
from fpnet_ros.runtime import STALE_INPUT_S, LossLog
from fpnet_ros.work import DroppingWorker
from msg_adapters.diagnostics import LocalizerReport, report_of_output

LOST = 'scans are lost on the way here: see "Large clouds"'
"""What is said of scans that do not arrive. Given."""

# Chosen: an input that was heard within so many seconds is not the one that is missing, or within
# such a share of the time without a scan, where a recording is played faster than it was made.
_HEARD_S, _HEARD_SHARE = 0.5, 0.5

_SLOW = 'scans are dropped: more come than can be added'
_UNLOCATED = 'scans are dropped: their poses do not come, see the log'
_REFUSED = 'scans cannot be used: see the log'
_PAST = 'scans are dropped: their stamps do not go on, and those of the odometry do'
_REMEDIES = {
    _SLOW: 'send smaller clouds, or every second one, and look what else takes the processor',
    _PAST: "is the lidar's clock set while it runs, do two drivers publish on one topic, or does "
    'a driver repeat a stamp?',
    LOST: LARGE_CLOUDS,
}

DIAGNOSTICS_PERIOD_S = 1.0
"""Of a node's diagnostics. Chosen."""


class ClockSilence:
    """
    Tells for how long simulated time has stood still: a paused recording, or nobody's at all.

    Parameters
    ----------
    clock
        The node's; the system's time never stands still.
    """

    def __init__(self, clock: Any) -> None:
        self._clock = clock
        self._now_ns = 0  # until somebody publishes it
        self._moved_s, self._runs_since_s = time.monotonic(), -math.inf

    @property
    def age_s(self) -> float:
        """Time since it moved last, as far as somebody has asked."""
        now_ns, now_s = self._clock.now().nanoseconds, time.monotonic()
        if now_ns != self._now_ns or not self._clock.ros_time_is_active:
            if now_s - self._moved_s > STALE_INPUT_S:
                self._runs_since_s = now_s
            self._now_ns, self._moved_s = now_ns, now_s
        return now_s - self._moved_s

    def without(self, ages_s: Mapping[str, float]) -> dict[str, float]:
        """Return ages of inputs without the time that the clock stood still: it silences all."""
        still_s = self.age_s
        ran_s = self._moved_s - self._runs_since_s
        return {name: min(age_s - still_s, ran_s) for name, age_s in ages_s.items()}


class Health:
    """
    Puts figures and warnings of one node beside its outputs.

    Parameters
    ----------
    inputs, scans
        What comes, and what is made of it.
    clock
        The node's. While it stands still nothing is expected of the others.
    warn
        Takes what scans are lost by, for the log.
    """

    def __init__(
        self,
        inputs: ScanInput,
        scans: DroppingWorker[Any],
        clock: Any,
        warn: Callable[[str], Any],
    ) -> None:
        self._inputs = inputs
        self._clock = ClockSilence(clock)
        self._scans = scans
        self._losses = LossLog(warn)
        self._scan_ns: int | None = None  # of the last scan with a pose, by the node's clock
        self._scan_s = time.monotonic()  # and by the system's
        self.is_starved = False
        """Whether scans have ceased to come: what was claimed holds no longer."""

    @property
    def silence_s(self) -> dict[str, float]:
        """Time since each topic was last heard while the clock ran, that of the clock first."""
        return {CLOCK_TOPIC: self._clock.age_s, **self._clock.without(self._inputs.silence_s)}

    def saw_scan(self, now_ns: int) -> None:
        """Note that a scan with a pose was added now, by the node's clock."""
        self._scan_ns, self._scan_s = now_ns, time.monotonic()

    def has_turned(self, now_ns: int, scan_timeout_s: float) -> bool:
        """Tell whether scans have ceased, or come again, since the last call."""
        last_ns, before = self._scan_ns, self.is_starved
        self.is_starved = last_ns is not None and now_ns - last_ns > scan_timeout_s * NS_PER_S
        return self.is_starved is not before

    def report(self, output: LocalizerOutput, stale_input_s: float) -> LocalizerReport:
        """Return what a tick says; inputs that were silent for longer are a warning."""
        return self._report(output, self._silences(stale_input_s), stale_input_s)

    def news(self, output: LocalizerOutput, stale_input_s: float) -> LocalizerReport:
        """Return the same with a warning of what was lost since the last call."""
        lost = self._losses.follow(self._lost(), _REMEDIES)
        warnings = [*lost, *self._silences(stale_input_s)]
        return self._report(output, warnings, stale_input_s)

    def _report(
        self, output: LocalizerOutput, warnings: list[str], stale_input_s: float
    ) -> LocalizerReport:
        lost = self._lost()
        figures = {
            **self._inputs.ages_s,
            'scan_ms': self._scans.work_ms,
            'scans': float(self._scans.done),
            'dropped_scans': float(lost[_SLOW] + lost[_UNLOCATED] + lost[_PAST]),
            'refused_scans': float(lost[_REFUSED]),
            'lost_scans': float(lost[LOST]),
            'earlier_scans': float(self._inputs.earlier),
        }
        is_starved = self.is_starved and output.status is not Status.NO_PLAN
        if not (is_starved or self._waits_in_vain(output, stale_input_s)):
            return report_of_output(output, figures, ', '.join(warnings))
        since = 'comes any more' if is_starved else 'has come yet'
        reason = f'no scan with a pose {since}: {self._missing()}'
        report = report_of_output(output, figures, ', '.join(warnings) or 'scans have ceased')
        return replace(report, status=Status.WAITING, probability=0.0, reason=reason)

    def _waits_in_vain(self, output: LocalizerOutput, stale_input_s: float) -> bool:
        """Tell whether no scan with a pose ever came, and one of its topics is silent."""
        if self._scan_ns is not None or output.status is not Status.WAITING:
            return False
        silent_s = self._clock.without(self._inputs.silence_s)
        return max(silent_s.values()) > stale_input_s

    def _missing(self) -> str:
        """Return in words what keeps scans with poses from coming."""
        topic, age_s = max(self._inputs.silence_s.items(), key=lambda silent: silent[1])
        if age_s > min(_HEARD_S, _HEARD_SHARE * (time.monotonic() - self._scan_s)):
            return f'nothing on {topic} for {age_s:.1f} s'
        return self._inputs.waits_for or 'see the log'

    def _silences(self, stale_input_s: float) -> list[str]:
        ages_s = {CLOCK_TOPIC: self._clock.age_s, **self._clock.without(self._inputs.ages_s)}
        return [
            f'no {name.removesuffix("_age_s")} for {age_s:.0f} s'
            for name, age_s in ages_s.items()
            if age_s > stale_input_s
        ]

    def _lost(self) -> dict[str, int]:
        """Return how many scans were not used so far, by what is said of them."""
        inputs, scans = self._inputs, self._scans
        return {
            _SLOW: scans.dropped,
            _UNLOCATED: inputs.unlocated,
            _PAST: inputs.past,
            _REFUSED: scans.refused + inputs.refused,
            LOST: inputs.lost,
        }
