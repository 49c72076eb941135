# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Work beside the executor's thread; imports no ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Condition, Thread
import time
from typing import Generic, TypeVar

Item = TypeVar('Item')


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
            except Exception as error:  # a defect must not end the thread in silence
                self._on_error(error)
            self.work_ms = 1e3 * (time.monotonic() - started_s)
            self.done += 1
