# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Averages of something, and of nothing."""

import pytest

from fpnet.accuracy import quantile
from fpnet_lab.metrics import mean, share


def test_of_something():
    assert mean(value for value in (1.0, 2.0, 6.0)) == 3.0
    assert share(value > 1.0 for value in (1.0, 2.0, 6.0, 7.0)) == 0.75
    assert quantile([1.0, 2.0, 6.0], 0.75) == 4.0


@pytest.mark.parametrize('nothing', [mean(()), share(()), quantile([], 0.5)])
def test_nothing_is_known_of_nothing(nothing):
    assert nothing is None
