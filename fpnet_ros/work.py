# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Worker threads; imports no ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Lock, Thread
import time
from typing import Any, Generic, TypeVar

Item = TypeVar('Item')


def in_background(work: Callable[[], Any]) -> Future[Any]:
    """Return the future of work in a daemon thread, which does not keep the process alive."""
    future: Future[Any] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:  # the owner of the future gets it
            future.set_exception(error)

    Thread(target=run, name='background', daemon=True).start()
    return future


class Worker:
    """A thread that runs all submitted work in order; ``on_error`` gets its exceptions."""

    def __init__(self, name: str, on_error: Callable[[BaseException], None]) -> None:
        self._on_error = on_error
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix=name)

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Queue work and return the future of its result."""
        future = self._pool.submit(work, *arguments)
        future.add_done_callback(self._report)
        return future

    def close(self) -> None:
        """Finish the current work and end the thread; queued work is dropped."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _report(self, future: Future[Any]) -> None:
        if not future.cancelled() and (error := future.exception()) is not None:
            self._on_error(error)


class DroppingWorker(Worker, Generic[Item]):
    """
    A thread that processes items in order, and drops the oldest of more than ``limit`` waiting.

    ``work`` processes one item. ``done``, ``dropped`` and ``refused`` count items, the last those
    that ``work`` raised for; ``work_ms`` is the duration of the last one.
    """

    def __init__(
        self,
        work: Callable[[Item], None],
        limit: int,
        on_error: Callable[[BaseException], None],
        name: str = 'scans',
    ) -> None:
        super().__init__(name, on_error)
        self._work, self._limit = work, limit
        self._waiting: deque[Item] = deque()
        self._lock = Lock()
        self.done = self.dropped = self.refused = 0
        self.work_ms = 0.0

    def put(self, item: Item) -> None:
        """Queue an item."""
        with self._lock:
            self._waiting.append(item)
            is_full = len(self._waiting) > self._limit
            if is_full:
                self._waiting.popleft()
                self.dropped += 1
        if not is_full:  # otherwise the work that waits takes the next item instead
            self.submit(self._next)

    def _next(self) -> None:
        with self._lock:
            item = self._waiting.popleft()
        started_s = time.monotonic()
        try:
            self._work(item)
            self.done += 1
        except Exception:
            self.refused += 1
            raise
        finally:
            self.work_ms = 1e3 * (time.monotonic() - started_s)
