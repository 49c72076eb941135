# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Metrics of planted outcomes."""

import numpy as np
import pytest

from fpnet_core.geometry import Affine2D, Similarity2D
from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_lab.metrics import (
    MatchCounts,
    PlacementError,
    auc,
    count_matches,
    expected_calibration_error,
    matching_score,
    placement_error,
)


def test_counts_of_a_literal_case():
    labels = np.array([4, 2, UNMATCHED, IGNORE, 7])
    # Right; wrong partner; partner of an unmatched region; on an ignored region (not judged).
    pairs = np.array([[4, 0], [3, 1], [2, 2], [5, 3]])
    counts = count_matches(pairs, labels)
    assert counts == MatchCounts(correct=1, predicted=3, true=3)
    assert counts.precision == pytest.approx(1 / 3)
    assert counts.recall == pytest.approx(1 / 3)
    assert counts.f1 == pytest.approx(1 / 3)


def test_nothing_predicted_and_nothing_there():
    none = count_matches(np.zeros((0, 2), np.int64), np.array([UNMATCHED, IGNORE]))
    assert none == MatchCounts(0, 0, 0)
    assert (none.precision, none.recall, none.f1) == (0.0, 1.0, 1.0)


def test_pooling_adds_and_the_matching_score_averages_pairs():
    one, other = MatchCounts(1, 1, 4), MatchCounts(0, 3, 2)
    pooled = one + other
    assert pooled == MatchCounts(1, 4, 6)
    assert pooled.precision == 0.25
    assert matching_score([one, other]) == 0.5
    # A pair that claims nothing although partners exist scores 0; one without both is left out.
    assert matching_score([one, MatchCounts(0, 0, 3), MatchCounts(0, 0, 0)]) == 0.5
    assert matching_score([]) == 0.0


def test_overconfidence_is_the_distance_from_the_truth():
    right = np.arange(10) < 6
    assert expected_calibration_error(np.full(10, 1.0), right) == pytest.approx(0.4)


def test_parts_count_by_how_many_they_hold():
    probability = np.array([0.05, 0.95, 0.95, 0.95])
    right = np.array([False, True, True, False])
    expected = (0.05 + abs(3 * 0.95 - 2)) / 4
    assert expected_calibration_error(probability, right) == pytest.approx(expected)


TRUTH = Similarity2D.from_scale_yaw(1.2, 0.7, [10.0, 4.0])


def test_the_truth_has_no_error():
    error = placement_error(TRUTH, TRUTH, (3.0, -2.0))
    assert vars(error) == pytest.approx(
        {'rotation_deg': 0.0, 'scale': 0.0, 'direction_deg': 0.0, 'distance_m': 0.0}, abs=1e-6
    )
    assert error.is_transform_right
    assert error.is_within(0.5, 5.0)


def test_errors_are_those_of_a_planted_difference():
    estimate = Similarity2D.from_scale_yaw(1.26, 0.7 + np.deg2rad(4.0), [4.0, 10.0])
    error = placement_error(estimate, TRUTH, (0.0, 0.0))
    assert error.rotation_deg == pytest.approx(4.0)
    assert error.scale == pytest.approx(0.05)
    # Both vectors lie 21.80 degrees from an axis, on either side of the diagonal.
    assert error.direction_deg == pytest.approx(90.0 - 2.0 * 21.8014, abs=1e-3)
    assert error.distance_m == pytest.approx(np.hypot(6.0, 6.0))
    assert not error.is_transform_right


@pytest.mark.parametrize(
    ('error', 'right'),
    [
        (PlacementError(3.1, 0.06, 19.0, 99.0), True),
        (PlacementError(3.4, 0.0, 0.0, 0.0), False),  # 0.08 is 3.24 degrees
        (PlacementError(0.0, 0.08, 0.0, 0.0), False),
        (PlacementError(0.0, 0.0, 21.0, 0.0), False),
        (PlacementError(180.0, 0.0, 0.0, 0.0), False),
        (PlacementError(), False),
    ],
)
def test_transform_score_needs_all_three(error, right):
    assert error.is_transform_right == right


def test_opposite_translations_fold_onto_each_other():
    mirrored = Affine2D(TRUTH.linear, -TRUTH.translation)
    assert placement_error(mirrored, TRUTH, (0.0, 0.0)).direction_deg == pytest.approx(0.0)


def test_area_under_the_curve_counts_failures_as_infinite():
    errors = [PlacementError(2.0, 0.0, 1.0, 0.0), PlacementError(0.0, 0.0, 5.0, 0.0)]
    assert auc([*errors, PlacementError()], 10.0) == pytest.approx((0.8 + 0.5 + 0.0) / 3)
    assert auc(errors, 1.0) == 0.0
    assert auc([], 10.0) == 0.0
