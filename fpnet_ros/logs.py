# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Log of a node: a line for each event, not for each message; imports no ROS."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
import math
from pathlib import Path
import re
import time
import traceback
from typing import Any

from fpnet_core.errors import FpnetError
from fpnet_core.printable import printable
from msg_adapters.diagnostics import LocalizerReport

# Chosen: least time between two lines about the same bad input, and without losses of a kind until
# its next one is logged.
_ERROR_PERIOD_S, _QUIET_S = 5.0, 60.0


class NodeLog:
    """
    Logs changes, failures and losses of a node without repetitions.

    ``is_alive`` tells whether the node goes on: errors of one that shuts down are no defects.
    """

    def __init__(
        self,
        logger: Any,
        is_alive: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._logger, self._is_alive, self._clock = logger, is_alive, clock
        self._states: dict[str, Any] = {}
        self._failures: set[tuple[str, str]] = set()
        self._logged_s: dict[str, float] = {}
        self._withheld: Counter[str] = Counter()
        self._counts: dict[str, int] = {}
        self._lost_s: dict[str, float] = {}

    def report(self, error: BaseException) -> None:
        """
        Log an error of a message or a task; bad input (FpnetError) at most every few seconds.

        Messages that differ only in numbers are of one kind, which is logged with the number of
        lines left out since its last one.
        """
        if not isinstance(error, FpnetError):
            if self._is_alive():
                self._logger.error(described(error))
            return
        kind, now_s = re.sub(r'\d+', '', one_line(error)), self._clock()
        if now_s - self._logged_s.get(kind, -math.inf) < _ERROR_PERIOD_S:
            self._withheld[kind] += 1
            return
        self._logged_s[kind] = now_s
        withheld = self._withheld.pop(kind, 0)
        suffix = f' ({withheld} more since the last report)' if withheld else ''
        self._logger.error(one_line(error) + suffix)

    def fail(self, task: str, error: FpnetError, kind: str = '') -> None:
        """Report each ``kind`` of failure of a task once, until it succeeds."""
        if (task, kind) not in self._failures:
            self._failures.add((task, kind))
            self.report(error)

    def succeed(self, task: str) -> None:
        """Note that a task has succeeded."""
        self._failures = {each for each in self._failures if each[0] != task}

    def change(self, what: str, state: Any, line: str, is_trouble: bool) -> bool:
        """Log a line if the state of something, at first False, changed; return whether it did."""
        if self._states.get(what, False) == state:
            return False
        self._states[what] = state
        if is_trouble:  # rclpy allows only one level at a line of code
            self._logger.warning(line)
        else:
            self._logger.info(line)
        return True

    def status(self, report: LocalizerReport) -> None:
        """Log a change of the localizer's status, as a warning if it needs attention."""
        self.change('', (report.status, report.is_mirrored), report.said, report.is_trouble)

    def silences(self, ages_s: Mapping[str, float], limit_s: float) -> bool:
        """
        Log topics that have stopped, or never started, and those that are back.

        Takes the age of each topic's last message [s]; returns whether a line was logged.
        """
        news = False
        for topic, age_s in ages_s.items():
            is_silent = age_s > limit_s
            said = f'no message on {topic} for {age_s:.0f} s: is it published?'
            said = said if is_silent else f'{topic} is received again'
            news |= self.change(topic, is_silent, said, is_silent)
        return news

    def losses(self, counts: Mapping[str, int], remedies: Mapping[str, str]) -> list[str]:
        """
        Return the reasons for scans lost since the last call; log new ones with their remedies.

        Takes the scans lost so far by reason; reasons without a remedy are logged elsewhere.
        """
        news = [what for what, count in counts.items() if count > self._counts.get(what, 0)]
        self._counts, now_s = dict(counts), self._clock()
        for what in news:
            if now_s - self._lost_s.get(what, -math.inf) > _QUIET_S and what in remedies:
                self._logger.warning(f'{what}; {remedies[what]}')
            self._lost_s[what] = now_s
        return news


def one_line(error: BaseException) -> str:
    """Return the message of an error without line breaks and control characters."""
    return printable(' '.join(str(error).split()))


def described(error: BaseException) -> str:
    """Return an error in one line; that of a defect has type, location and cause."""
    if isinstance(error, FpnetError):
        return one_line(error)
    where = traceback.extract_tb(error.__traceback__)[-1:]
    place = ''.join(f' in {Path(at.filename).name}:{at.lineno} ({at.name})' for at in where)
    before = error.__cause__ or error.__context__
    cause = '' if before is None else f'; caused by: {_typed(before)}'
    return f'internal error, please report it: {_typed(error)}{place}{cause}'


def _typed(error: BaseException) -> str:
    return f'{type(error).__name__}: {one_line(error)}'
