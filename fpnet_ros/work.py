# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages in order, and work beside the executor's thread; imports no ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Condition, Thread
import time
from typing import Any, Generic, TypeVar

Item = TypeVar('Item')

_NUMBER, _FIRST, _NO_NUMBER = 'publication_sequence_number', 1, 2**64 - 1  # given
_MOST_LOST = 1000  # a larger gap is between two publishers that take turns; chosen


class Numbering:
    """
    Follows how a publisher numbers its messages.

    ``lost`` counts those that did not arrive: queues overflowed, or fragments went missing.
    ``earlier`` counts those that were sent before the first one that was heard: none where
    everybody waited for everybody, thousands where a driver has been running.
    """

    def __init__(self) -> None:
        self._last: int | None = None
        self.lost = self.earlier = 0

    @property
    def newest(self) -> int:
        """Number of the newest message, 0 where nobody counts."""
        return self._last or 0

    def follow(self, info: Mapping[str, Any]) -> bool:
        """Take a message's information; True where another process publishes from now on."""
        number = int(info.get(_NUMBER, _NO_NUMBER))
        if number == _NO_NUMBER:  # a middleware that does not count
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
    """Return the result of work that a thread of its own does; the process may end before it."""
    future: Future[Any] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:  # the future's owner is told
            future.set_exception(error)

    Thread(target=run, name='background', daemon=True).start()
    return future


class Worker:
    """
    A thread that does one thing after the other, all that it is told.

    Parameters
    ----------
    name
        Of the thread.
    on_error
        Takes what a piece of work raised; the worker goes on.
    """

    def __init__(self, name: str, on_error: Callable[[BaseException], None]) -> None:
        self._on_error = on_error
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix=name)

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Queue a piece of work; the future has its result."""
        future = self._pool.submit(work, *arguments)
        future.add_done_callback(self._report)
        return future

    def close(self) -> None:
        """Finish the work at hand and end the thread; what waits is dropped."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _report(self, future: Future[Any]) -> None:
        if not future.cancelled() and (error := future.exception()) is not None:
            self._on_error(error)


class DroppingWorker(Generic[Item]):
    """
    A thread that works off items in order, and drops the oldest waiting ones where it is too slow.

    So it is never further behind than ``limit`` items, whatever the sensor sends.

    Parameters
    ----------
    work
        Takes one item, in the worker's thread.
    limit
        Items that may wait.
    on_error
        Takes what ``work`` raised; the worker goes on.
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
        """Finish the item at work and end the thread; what waits is dropped."""
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
            except Exception as error:  # a defect must not end the thread in silence
                self.refused += 1
                self._on_error(error)
            self.work_ms = 1e3 * (time.monotonic() - started_s)
