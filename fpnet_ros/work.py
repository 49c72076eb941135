# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Counts of lost messages, and worker threads; imports no ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Condition, Thread
import time
from typing import Any, Generic, TypeVar

Item = TypeVar('Item')

_NUMBER, _FIRST, _NO_NUMBER = 'publication_sequence_number', 1, 2**64 - 1  # given
_MOST_LOST = 1000  # a larger gap means that two publishers alternate; chosen


class Numbering:
    """
    Counts lost messages by the sequence numbers of their publisher.

    ``lost`` counts messages that did not arrive: queues overflowed, or fragments went missing.
    ``earlier`` counts messages that were sent before the first received one: none after complete
    discovery, thousands if a driver has been running.
    """

    def __init__(self) -> None:
        self._last: int | None = None
        self.lost = self.earlier = 0

    @property
    def newest(self) -> int:
        """Number of the newest message, 0 if the middleware does not number them."""
        return self._last or 0

    def follow(self, info: Mapping[str, Any]) -> bool:
        """Count a message by its information; return whether a new publisher took over."""
        number = int(info.get(_NUMBER, _NO_NUMBER))
        if number == _NO_NUMBER:  # the middleware does not number messages
            return False
        last, self._last = self._last, number
        if last is None:
            self.earlier = max(0, number - _FIRST)
            return False
        missing = number - last - 1
        if 0 < missing < _MOST_LOST:
            self.lost += missing
        return number < last


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
    """
    A thread that runs all submitted work in order.

    Parameters
    ----------
    name
        Name of the thread.
    on_error
        Called with an exception of the work; the worker goes on.
    """

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


class DroppingWorker(Generic[Item]):
    """
    A thread that processes items in order, and drops the oldest waiting ones if it is too slow.

    It is never more than ``limit`` items behind, at any sensor rate.

    Parameters
    ----------
    work
        Processes one item, in the worker's thread.
    limit
        Items that may wait.
    on_error
        Called with an exception of ``work``; the worker goes on.
    """

    def __init__(
        self,
        work: Callable[[Item], None],
        limit: int,
        on_error: Callable[[Exception], None],
        name: str = 'scans',
    ) -> None:
        self._work = work
        self._limit = limit
        self._on_error = on_error
        self._waiting: deque[Item] = deque()
        self._changed = Condition()
        self._is_closed = False
        self.dropped = 0
        self.refused = 0  # items that ``work`` raised for
        self.done = 0
        self.work_ms = 0.0  # duration of the last item
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, item: Item) -> None:
        """Queue an item."""
        with self._changed:
            self._waiting.append(item)
            if len(self._waiting) > self._limit:
                self._waiting.popleft()
                self.dropped += 1
            self._changed.notify()

    def close(self) -> None:
        """Finish the current item and end the thread; queued items are dropped."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._is_closed)
                if self._is_closed:
                    return
                item = self._waiting.popleft()
            started_s = time.monotonic()
            try:
                self._work(item)
                self.done += 1
            except Exception as error:  # a defect must not end the thread silently
                self.refused += 1
                self._on_error(error)
            self.work_ms = 1e3 * (time.monotonic() - started_s)
