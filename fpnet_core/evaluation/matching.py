# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compare region matchers on the same stored pairs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
import time
from typing import Any

import numpy as np

from fpnet_core.matching import RegionMatcher
from fpnet_core.metrics import MatchCounts, count_matches, matching_score
from fpnet_core.sim.pairs import MatchingPair

# Calls that warm caches and lazily built kernels before time is taken.
_WARM_UP = 3


def bench_matching(
    pairs: Iterable[MatchingPair],
    matchers: Mapping[str, RegionMatcher],
    on_pairs: Callable[[float], None] = lambda count: None,
) -> dict[str, Any]:
    """
    Run every matcher on every pair.

    Returns
    -------
    ``{'methods': {name: {'ms', 'match_precision', 'match_recall', 'match_f1', 'ms_per_pair'}},
    'pairs': n}``; fractions in [0, 1], ``ms`` the paper's matching score (mean over pairs),
    precision and recall pooled over all regions, ``ms_per_pair`` the median in milliseconds.
    """
    counts: dict[str, list[MatchCounts]] = {name: [] for name in matchers}
    seconds: dict[str, list[float]] = {name: [] for name in matchers}
    for index, pair in enumerate(pairs):
        for name, matcher in matchers.items():
            for _ in range(_WARM_UP if index == 0 else 0):
                matcher.match(pair.plan_graph, pair.sub_graph, pair.explored_area_m2)
            start = time.perf_counter()
            result = matcher.match(pair.plan_graph, pair.sub_graph, pair.explored_area_m2)
            seconds[name].append(time.perf_counter() - start)
            counts[name].append(count_matches(result.pairs, pair.sub_labels))
        on_pairs(1.0)
    methods = {name: _figures(counts[name], seconds[name]) for name in matchers}
    return {'methods': methods, 'pairs': len(next(iter(counts.values()), []))}


def _figures(counts: list[MatchCounts], seconds: list[float]) -> dict[str, float]:
    pooled = sum(counts, MatchCounts(0, 0, 0))
    return {
        'ms': matching_score(counts),
        'match_precision': pooled.precision,
        'match_recall': pooled.recall,
        'match_f1': pooled.f1,
        'ms_per_pair': float(np.median(seconds)) * 1e3 if seconds else 0.0,
    }
