# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_lab.metrics import expected_calibration_error


def test_probabilities_that_come_true_have_no_error():
    right = np.repeat([True, False, True, False], [8, 2, 2, 8])
    assert expected_calibration_error(np.repeat([0.8, 0.2], 10), right) == pytest.approx(0.0)


def test_overconfidence_is_the_distance_from_the_truth():
    right = np.arange(10) < 6
    assert expected_calibration_error(np.full(10, 1.0), right) == pytest.approx(0.4)


def test_parts_count_by_how_many_they_hold():
    probability = np.array([0.05, 0.95, 0.95, 0.95])
    right = np.array([False, True, True, False])
    expected = (0.05 + abs(3 * 0.95 - 2)) / 4
    assert expected_calibration_error(probability, right) == pytest.approx(expected)


def test_nothing_said_is_no_error():
    assert expected_calibration_error(np.zeros(0), np.zeros(0, dtype=bool)) == 0.0
