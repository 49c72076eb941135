# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Progress bars and live status: on the terminal, or a line a second in logs and pipes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import sys
import time
from typing import TYPE_CHECKING, TypeVar

import typer

from fpnet_core.printable import printable

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

Item = TypeVar('Item')

_PERIOD_S = 1.0  # given: time between two lines of status where there is no terminal


class Advance:
    """Advances a progress bar by steps, and shows a status; without a bar it has no steps."""

    def __init__(self, bar: Progress | None = None, task: TaskID | None = None) -> None:
        self._bar, self._task = bar, task
        self._next_s = time.monotonic() + _PERIOD_S

    def __call__(self, steps: float) -> None:
        """Advance the bar."""
        if self._bar is not None and self._task is not None:
            self._bar.advance(self._task, steps)

    def status(self, short: str, line: str) -> None:
        """Show ``short`` beside the bar or, without one, write ``line``, at most one a second."""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, description=short)
        elif time.monotonic() >= self._next_s:
            typer.echo(printable(line), err=True)
            self._next_s = time.monotonic() + _PERIOD_S


@contextmanager
def progress(description: str, total: float | None = None) -> Iterator[Advance]:
    """
    Show a progress bar on stderr and yield what advances it by a number of steps.

    The bar is shown only if stdout and stderr are terminals, so that logs and pipes stay clean.
    """
    if not (sys.stdout.isatty() and sys.stderr.isatty()):
        yield Advance()
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = [SpinnerColumn(), TextColumn('{task.description}')]
    if total is not None:
        columns += [BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()]
    columns.append(TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        yield Advance(bar, bar.add_task(description, total=total))


def track(items: Sequence[Item], description: str) -> Iterator[Item]:
    """Yield the items and show a progress bar."""
    with progress(description, total=len(items)) as advance:
        for item in items:
            yield item
            advance(1.0)
