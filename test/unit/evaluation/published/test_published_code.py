# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Constants varied, damaged files, growth and sizes on disk, as pages show them."""

from benchmark_reports import GROWTH, MADE, VARIED, rows, varied
import pytest

from fpnet_core.errors import ConfigError
from fpnet_lab.evaluation.published.makers import joined, published


def constants(*reports):
    """The rows of the table that several runs come to."""
    text = published('constants_varied', joined('constants_varied', reports), MADE)
    return rows(text['constants_varied'])[2:]


def test_several_runs_come_to_one_table_and_the_most_of_a_constant_counts():
    again = varied(1.2, A=('nothing', ''), D=('changed', 'x 1.20: pair-9: other place'))
    pose, _ = constants(VARIED, again)
    assert pose[2:] == ['4', '2', '1', '1', '0', '1']
    both = constants(VARIED, varied(4, D=('nothing', '')))
    assert [row[:3] for row in both[2:]] == [['4', '`pose`', '1'], ['4', 'all', '1']]


def test_other_tables_are_of_one_run():
    with pytest.raises(ConfigError, match=r"2 reports of 'growth'"):
        joined('growth', [GROWTH, GROWTH])
    assert joined('growth', [GROWTH]) is GROWTH
