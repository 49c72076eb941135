# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Durations beside their aims: what is counted, and what a failing command says."""

import pytest

from fpnet_core.errors import FpnetError
from fpnet_lab.evaluation.speed import timing


def test_quantiles_of_both_clocks_and_missed_aims():
    times = [(0.001 * k, 0.002 * k) for k in range(101)]
    figure = timing.quantile_of('ticks', 0.09, times, 0.95)
    assert (figure.value, figure.cpu_s) == pytest.approx((0.095, 0.19))
    assert not figure.is_met
    assert timing.quantile_of('ticks', None, times, 0.95).is_met


def test_a_command_that_fails_ends_the_benchmark_with_its_message(tmp_path):
    with pytest.raises(FpnetError, match=r'fpnet match --floorplan none\.png.*failed'):
        timing.shell_figure('match', 1.0, ['match', '--floorplan', 'none.png'], tmp_path)
