# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Subsampling: evenly spaced points, and ranked entries without near-duplicates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]


def first_distinct(
    count: int, is_same: Callable[[int, Indices], NDArray[np.bool_]], limit: int | None = None
) -> Indices:
    """
    Return the indices below ``count`` that duplicate no earlier kept one, at most ``limit``.

    ``is_same(index, others)`` returns which of ``others (N,)`` duplicate entry ``index``.
    """
    left = np.arange(count)
    kept: list[int] = []
    while len(left) and (limit is None or len(kept) < limit):
        first = int(left[0])
        kept.append(first)
        left = left[1:][~is_same(first, left[1:])]
    return np.array(kept, np.int64)


def evenly_drawn(points: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return at most ``count`` evenly spaced ``points (P, D)``, including the first and last."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).astype(np.int64)]
