# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Region matchers by name, for the command line and the benchmarks."""

from __future__ import annotations

from collections.abc import Callable

from fpnet_core.baselines.nearest_neighbor import NearestNeighborMatcher
from fpnet_core.config import MatcherConfig
from fpnet_core.matching import RegionMatcher


def _learned(config: MatcherConfig) -> RegionMatcher:
    # Loads torch, which the baselines do without.
    from fpnet_core.matching.learned import LearnedMatcher

    return LearnedMatcher(config)


MATCHERS: dict[str, Callable[[MatcherConfig], RegionMatcher]] = {
    'fpnet': _learned,
    'nearest_neighbor': NearestNeighborMatcher,
}

__all__ = ['MATCHERS', 'NearestNeighborMatcher']
