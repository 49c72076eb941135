# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pure scoring functions, shared by training, evaluation and tests."""

from fpnet_lab.metrics.averages import mean, share
from fpnet_lab.metrics.calibration import (
    Reliability,
    brier_score,
    expected_calibration_error,
    reliability_bins,
)
from fpnet_lab.metrics.matching import MatchCounts, count_matches, matching_score
from fpnet_lab.metrics.placement import PlacementError, auc, placement_error

__all__ = [
    'MatchCounts',
    'PlacementError',
    'Reliability',
    'auc',
    'brier_score',
    'count_matches',
    'expected_calibration_error',
    'matching_score',
    'mean',
    'placement_error',
    'reliability_bins',
    'share',
]
