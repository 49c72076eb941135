# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When scans from the past are disorder, and when a clock that went back."""

import pytest

from fpnet_core.errors import OdometryError
from fpnet_core.stamps import NS_PER_S, ClockGuard


def test_a_clock_that_goes_on_is_no_news():
    guard = ClockGuard(3)
    assert [guard.back_s(now, now - 1) for now in (1, 5, 9)] == [None, None, None]


def test_a_few_old_scans_are_dropped_and_many_are_a_clock_that_went_back():
    guard = ClockGuard(3)
    for _ in range(2):
        with pytest.raises(OdometryError, match='not newer than the last one'):
            guard.back_s(NS_PER_S, 2 * NS_PER_S)
    assert guard.back_s(NS_PER_S, 2 * NS_PER_S) == pytest.approx(1.0)
    with pytest.raises(OdometryError):  # it counts anew
        guard.back_s(NS_PER_S, NS_PER_S)


def test_a_new_scan_in_between_ends_the_count():
    guard = ClockGuard(2)
    with pytest.raises(OdometryError):
        guard.back_s(1, 1)
    assert guard.back_s(2, 1) is None
    with pytest.raises(OdometryError):
        guard.back_s(2, 2)
