# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parallel execution of tasks in worker processes."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
import multiprocessing
from typing import Any, TypeVar

Task = TypeVar('Task')
Result = TypeVar('Result')

START_METHOD = 'spawn'
"""Process start method: the threads of OpenCV and OpenMP do not survive a fork."""

_make: list[Callable[[Any], Any]] = []
"""Function that a worker runs; sent once per worker, not with every task."""


def each_done(
    make: Callable[[Task], Result], tasks: Iterable[Task], workers: int
) -> Iterator[tuple[Task, Result]]:
    """
    Yield every task with its result in order of completion; one worker runs in this process.

    The first error is raised at once. Tasks are cancelled when the caller stops iterating.
    """
    if workers <= 1:
        for task in tasks:
            yield task, make(task)
        return
    pool = ProcessPoolExecutor(
        workers,
        mp_context=multiprocessing.get_context(START_METHOD),
        initializer=_begin,
        initargs=(make,),
    )
    try:
        futures = {pool.submit(_do, task): task for task in tasks}
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(make: Callable[[Any], Any]) -> None:
    _make[:] = [make]


def _do(task: Any) -> Any:
    return _make[0](task)
