# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Graded match thresholds (paper, section IV-5)."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from fpnet_core.config import MatcherConfig


def graded_threshold(
    num_sub_regions: int, explored_area_m2: float, config: MatcherConfig
) -> float:
    """
    Return the probability that a pair must exceed, given the content of the submap.

    Each bound in ``grade_regions`` and ``grade_area_m2`` that the submap reaches raises one grade;
    the lower of the two grades selects the entry of ``grade_thresholds``. A large hall is a single
    region and as uninformative as three cupboards, so both measures must pass.

    With few regions there is little context: several rooms of the plan explain each of them, and
    even the true pair's probability is shared among these. A high threshold would leave an early
    submap without hypotheses; raster verification rejects the wrong pairs that a low one admits,
    at little cost while there are few. A large submap has context: its true pairs score high. Low
    scores then mark regions that are split, merged or new, and admitting them would multiply
    hypotheses. The paper describes the grading without numbers; its experiments used 0.3, halved
    for graphs of at most three nodes, meaning the submap's nodes.
    """
    grade = min(
        _grade(num_sub_regions, config.grade_regions),
        _grade(explored_area_m2, config.grade_area_m2),
    )
    return config.grade_thresholds[grade]


def _grade(value: float, bounds: Sequence[float]) -> int:
    """Count the ascending ``bounds`` that ``value`` reaches."""
    return bisect_right(bounds, value)
