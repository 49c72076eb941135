# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
from pydantic import ValidationError
import pytest

from fpnet_core.config import MatcherConfig
from fpnet_core.matching import graded_threshold, mutual_pairs

CONFIG = MatcherConfig(
    grade_regions=(4, 10), grade_area_m2=(30.0, 120.0), grade_thresholds=(0.15, 0.2, 0.3)
)


@pytest.mark.parametrize(
    ('regions', 'area_m2', 'expected'),
    [
        (0, 0.0, 0.15),
        (3, 500.0, 0.15),  # few regions, however large
        (50, 29.9, 0.15),  # many regions, but little seen
        (4, 30.0, 0.2),
        (10, 119.0, 0.2),
        (9, 500.0, 0.2),
        (10, 120.0, 0.3),
        (200, 5000.0, 0.3),
    ],
)
def test_threshold_needs_both_regions_and_area_to_rise(regions, area_m2, expected):
    assert graded_threshold(regions, area_m2, CONFIG) == expected


def test_early_and_late_submaps_are_treated_differently_by_default():
    config = MatcherConfig()
    early, late = (graded_threshold(n, a, config) for n, a in ((2, 15.0), (40, 600.0)))
    # The paper's experiments halve 0.3 for graphs of at most three nodes.
    assert (early, late) == (0.15, 0.3)


@pytest.mark.parametrize(
    'bad',
    [
        {'grade_regions': (4,)},
        {'grade_area_m2': (120.0, 30.0)},
        {'grade_thresholds': (0.1, 0.2, 1.5)},
    ],
)
def test_bad_grades_are_rejected(bad):
    with pytest.raises(ValidationError, match='grade'):
        MatcherConfig(**bad)


def test_mutual_pairs_need_both_sides_and_the_threshold():
    scores = np.array([[0.8, 0.1, 0.0], [0.7, 0.05, 0.19], [0.0, 0.1, 0.3]])
    assert mutual_pairs(scores, 0.2).tolist() == [[0, 0], [2, 2]]
    assert mutual_pairs(scores, 0.5).tolist() == [[0, 0]]
