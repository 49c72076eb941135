# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Match messages of two topics that carry the same stamp."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any, Generic, TypeVar

First = TypeVar('First')
Second = TypeVar('Second')


class StampPairing(Generic[First, Second]):
    """
    Hold back messages of two topics until their partner with the equal stamp arrives.

    The partners may come in either order and with messages of other stamps between them, as two
    topics of one publisher do. What finds no partner within ``depth`` messages of its own topic
    is dropped and counted.

    Parameters
    ----------
    depth
        Messages held back per topic.
    """

    def __init__(self, depth: int) -> None:
        if depth < 1:
            raise ValueError(f'depth must be at least 1, got {depth}')
        self._depth = depth
        self._first: OrderedDict[int, First] = OrderedDict()
        self._second: OrderedDict[int, Second] = OrderedDict()
        self.dropped = 0

    def add_first(self, stamp_ns: int, message: First) -> tuple[First, Second] | None:
        """Return the pair that ``message`` completes, or None."""
        if stamp_ns in self._second:
            return message, self._second.pop(stamp_ns)
        self._hold(self._first, stamp_ns, message)
        return None

    def add_second(self, stamp_ns: int, message: Second) -> tuple[First, Second] | None:
        """Return the pair that ``message`` completes, or None."""
        if stamp_ns in self._first:
            return self._first.pop(stamp_ns), message
        self._hold(self._second, stamp_ns, message)
        return None

    def _hold(self, waiting: OrderedDict[int, Any], stamp_ns: int, message: Any) -> None:
        waiting[stamp_ns] = message
        if len(waiting) > self._depth:
            waiting.popitem(last=False)
            self.dropped += 1
