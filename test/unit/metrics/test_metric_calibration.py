# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_lab.metrics import expected_calibration_error


def test_overconfidence_is_the_distance_from_the_truth():
    right = np.arange(10) < 6
    assert expected_calibration_error(np.full(10, 1.0), right) == pytest.approx(0.4)


def test_parts_count_by_how_many_they_hold():
    probability = np.array([0.05, 0.95, 0.95, 0.95])
    right = np.array([False, True, True, False])
    expected = (0.05 + abs(3 * 0.95 - 2)) / 4
    assert expected_calibration_error(probability, right) == pytest.approx(expected)
