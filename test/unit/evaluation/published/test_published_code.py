# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Constants varied, damaged files, growth and sizes on disk, as pages show them."""

from benchmark_reports import GROWTH, MADE, READ, STOREY, VARIED, WHEELS, rows, varied
from fuzzing.harness import Outcome
import pytest

from fpnet_core.errors import ConfigError
from fpnet_lab.evaluation.published.makers import joined, published


def constants(*reports):
    """The rows of the table that several runs come to."""
    text = published('constants_varied', joined('constants_varied', reports), MADE)
    return rows(text['constants_varied'])[2:]


def test_constants_are_told_apart_by_what_they_do():
    pose, everything = constants(VARIED)
    assert pose == ['1.2', '`pose`', '4', '1', '1', '1', '1', '1']
    assert everything == ['1.2', 'all', *pose[2:]]


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


def test_every_outcome_of_a_reader_has_a_column():
    titles, _, row = rows(published('readers', {'readers': [READ]}, MADE)['readers'])
    assert titles[2:-2] == [outcome.value for outcome in Outcome]
    assert row[:5] == ['images', '1626', '407', '1218', '1']
    assert row[-2:] == ['0.04', '1']


def test_growth_is_of_the_processor_and_aims_are_by_the_clock():
    figures = published('growth', GROWTH, MADE)
    assert rows(figures['growth'])[3] == ['20,000', '426', '3,173', '1.48 s', '1.05 s', '0.98 GB']
    update, memory = rows(figures['growth.aims'])[2:]
    assert update[1:] == ['1.15 s', '0.50 s', 'missed']
    assert memory[1:] == ['0.98 GB', '1.50 GB', 'met']
    assert rows(figures['growth.stages'])[2:] == [['segment', '0.43'], ['match', '0.09']]
    small = {'growth': [STOREY | {'area_m2': 300.0}]}
    assert set(published('growth', small, MADE)) == {'growth'}


def test_an_extra_is_as_large_as_what_it_adds():
    bare, ros = rows(published('wheels', WHEELS, MADE)['wheels'])[2:]
    assert bare == ['3.11', 'none: what a robot needs', '1610 MB', '94 s']
    assert ros == ['3.11', '`ros`', '170 MB', '31 s']
