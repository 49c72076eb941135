# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.geometry import Affine2D, Similarity2D
from fpnet_lab.metrics import PlacementError, auc, placement_error

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
