# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Matcher interface, and selection of matches from a soft assignment."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnet_core.matches import MatchResult
from fpnet_core.types import RegionGraph


class RegionMatcher(Protocol):
    """Matcher that finds corresponding regions; learned matchers and baselines alike."""

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        """
        Return region pairs of two graphs.

        An empty graph on either side gives no pairs. ``explored_area_m2`` is the free area seen in
        the submap; it grades the threshold.
        """


def mutual_pairs(scores: NDArray[Any], threshold: float) -> NDArray[np.int64]:
    """
    Return index pairs ``(K, 2)`` that are each other's best and score above ``threshold``.

    ``scores (M, N)``; pairs are in the order of their column (the submap's regions).
    """
    if scores.size == 0:
        return np.zeros((0, 2), dtype=np.int64)
    best_row = scores.argmax(axis=0)
    columns = np.arange(scores.shape[1])
    mutual = scores.argmax(axis=1)[best_row] == columns
    chosen = columns[mutual & (scores[best_row, columns] > threshold)]
    return np.stack([best_row[chosen], chosen], axis=1).astype(np.int64)
