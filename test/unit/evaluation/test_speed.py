# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Durations beside their aims: what is counted, and what a failing command says."""

import itertools
import time

import pytest

from fpnet_core.errors import FpnetError
from fpnet_lab.evaluation.speed import maps, timing


def test_a_figure_is_the_median_over_calls_after_one_that_is_not_counted():
    naps = itertools.chain([0.2], itertools.repeat(0.01))
    counted = []

    def call():
        counted.append(time.sleep(next(naps)))

    figure = timing.median_of('naps', 0.1, [call])
    assert len(counted) == 1 + timing.REPEATS
    assert 0.01 <= figure.value < 0.1
    assert figure.cpu_s < figure.value
    assert figure.is_met
    assert figure.as_json()['of'] == timing.REPEATS


def test_quantiles_of_both_clocks_and_missed_aims():
    times = [(0.001 * k, 0.002 * k) for k in range(101)]
    figure = timing.quantile_of('ticks', 0.09, times, 0.95)
    assert (figure.value, figure.cpu_s) == pytest.approx((0.095, 0.19))
    assert not figure.is_met
    assert timing.quantile_of('ticks', None, times, 0.95).is_met


def test_a_command_that_fails_ends_the_benchmark_with_its_message(tmp_path):
    with pytest.raises(FpnetError, match=r'fpnet match --floorplan none\.png.*failed'):
        timing.shell_figure('match', 1.0, ['match', '--floorplan', 'none.png'], tmp_path)


def test_graphs_have_the_nodes_that_a_row_names():
    graph = maps._grid_graph(31, 'plan', 0.3)
    assert len(graph) == 31
