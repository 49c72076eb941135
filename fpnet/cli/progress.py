# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Progress bars on the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
import sys
from typing import TypeVar

Item = TypeVar('Item')


@contextmanager
def progress(description: str, total: float | None = None) -> Iterator[Callable[[float], None]]:
    """
    Show a progress bar on stderr and yield a function that advances it by a number of steps.

    The bar is shown only if stdout and stderr are terminals, so that logs and pipes stay clean.
    """
    if not (sys.stdout.isatty() and sys.stderr.isatty()):
        yield lambda _: None
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
        task = bar.add_task(description, total=total)

        def advance(steps: float) -> None:
            bar.advance(task, steps)

        yield advance


def track(items: Sequence[Item], description: str) -> Iterator[Item]:
    """Yield the items and show a progress bar."""
    with progress(description, total=len(items)) as advance:
        for item in items:
            yield item
            advance(1.0)
