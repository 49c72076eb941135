# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Few of many: points evenly drawn, and point sets that are not nearly the same as a better."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray


@numba.njit(cache=True, nogil=True)
def first_distinct(
    placed: NDArray[np.float64], distance_m: float, limit: int
) -> NDArray[np.int64]:
    """
    Greedy choice among point sets ``(C, P, 2)`` [m], at most ``limit`` of them.

    Each is farther than ``distance_m`` from all kept before it, on the mean of its points.
    """
    kept = np.empty(min(limit, len(placed)), dtype=np.int64)
    count = 0
    for index in range(len(placed)):
        is_new = True
        for k in kept[:count]:
            moved = 0.0
            for corner in range(placed.shape[1]):
                dx = placed[k, corner, 0] - placed[index, corner, 0]
                dy = placed[k, corner, 1] - placed[index, corner, 1]
                moved += np.sqrt(dx * dx + dy * dy)
            if moved <= distance_m * placed.shape[1]:
                is_new = False
                break
        if is_new:
            kept[count] = index
            count += 1
            if count == limit:
                break
    return kept[:count]


def evenly_drawn(points: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return at most ``count`` of ``points (P, D)``, the first and the last one among them."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).astype(np.int64)]
