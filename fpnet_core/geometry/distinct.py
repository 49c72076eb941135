# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Few of many: points evenly drawn, and what is not nearly the same as a better one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]


def first_distinct(
    count: int, is_same: Callable[[int, Indices], NDArray[np.bool_]], limit: int | None = None
) -> Indices:
    """
    Return which of ``count`` are the same as none that was kept before, at most ``limit`` of them.

    ``is_same`` tells which of others, given by their numbers (N,), are the same as one.
    """
    left = np.arange(count)
    kept: list[int] = []
    while len(left) and (limit is None or len(kept) < limit):
        first = int(left[0])
        kept.append(first)
        left = left[1:][~is_same(first, left[1:])]
    return np.array(kept, np.int64)


def evenly_drawn(points: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return at most ``count`` of ``points (P, D)``, the first and the last one among them."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).astype(np.int64)]
