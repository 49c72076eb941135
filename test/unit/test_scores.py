# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scores: how values of each unit are written, and tables of reports with missing values."""

import math

import pytest

from fpnet_lab.scores import (
    Column,
    Score,
    Table,
    Unit,
    Units,
    columns,
    named,
    of,
    share_of,
    together,
)

REPORT = {
    'ours': {'runs': 8, 'right': 7, 'error_m': 0.126, 'error_deg': 0.44, 'share': 0.875},
    'theirs': {'runs': 8, 'right': 0, 'error_m': None, 'error_deg': math.nan, 'share': None},
}
COLUMNS = (
    Column('method', 'name'),
    Column('right', of('right', 'runs')),
    Column('share', share_of('share', 'runs')),
    Column('error', 'error_m', Units.METRES.in_title(2, '-')),
    Column('both', together(('error_m', Units.METRES), ('error_deg', Units.DEGREES))),
    *columns(Units.SHARE.to(0, 'none'), {'share': 'in per cent'}),
)


@pytest.mark.parametrize(
    ('unit', 'value', 'text'),
    [
        (Units.COUNT, 12, '12'), (Units.NUMBER, 0.126, '0.13'), (Units.SHARE, 0.94, '94 %'),
        (Units.FINE_SHARE, 0.9412, '94.1 %'), (Units.METRES, 0.05, '0.05 m'),
        (Units.PATH, 3, '3.0 m'), (Units.DEGREES, 0.44, '0.4 deg'),
        (Units.SECONDS, 1.06, '1.1 s'), (Units.MS, 12.6, '13 ms'),
        (Unit(' times', 1), 2.44, '2.4 times'), (Units.METRES, math.inf, 'inf m'),
        (Units.COUNT, 'not asked', 'not asked'),
    ],
)  # fmt: skip
def test_values_are_written_with_their_unit(unit, value, text):
    assert str(Score('any', value, unit)) == text


@pytest.mark.parametrize('value', [None, math.nan])
def test_what_is_not_known_is_nothing_or_what_the_unit_says(value):
    assert Units.METRES.text(value) == ''
    assert Units.METRES.to(1, 'none').text(value) == 'none'
    assert Units.METRES.in_title(1, '-').text(value) == '-'


@pytest.mark.parametrize(
    ('value', 'aim', 'is_met', 'said'),
    [
        (0.5, 0.5, True, '0.50 m'), (0.51, 0.5, False, '0.50 m, missed'), (9.0, None, True, ''),
        (math.nan, 0.5, False, '0.50 m, missed'), (None, 0.5, False, '0.50 m, missed'),
        (0, 0, True, '0.00 m'),
    ],
)  # fmt: skip
def test_an_aim_is_met_up_to_itself_and_never_by_what_is_unknown(value, aim, is_met, said):
    score = Score('error', value, Units.METRES, aim)
    assert (score.is_met, score.said_aim) == (is_met, said)


def test_a_table_of_a_report_has_a_cell_for_every_score_known_or_not():
    table = Table.of(COLUMNS, named(REPORT, '`{}`'))
    assert table.titles == ['method', 'right', 'share', 'error [m]', 'both', 'in per cent']
    assert table.rows == [
        ['`ours`', '7 of 8', '7 of 8', '0.13', '0.13 m, 0.4 deg', '88 %'],
        ['`theirs`', '0 of 8', '', '-', '', 'none'],
    ]


def test_markdown_marks_empty_cells_and_keeps_the_note_apart():
    table = Table(('a', 'b'), [('1', ''), ('2', '3')], 'Said below.')
    assert table.markdown() == '| a | b |\n| --- | --- |\n| 1 | |\n| 2 | 3 |\n\nSaid below.'
    assert Table.of(COLUMNS[:1], []).markdown() == '| method |\n| --- |'


@pytest.mark.parametrize(
    ('value', 'is_floor', 'is_met'),
    [(0.94, True, True), (0.93, True, False), (0.95, False, False), (0.94, False, True)],
)
def test_an_aim_is_a_ceiling_or_a_floor(value, is_floor, is_met):
    score = Score('doors', value, Units.SHARE, 0.94, is_floor)
    assert score.is_met == is_met
    assert Table.of_aims([score]).rows[0][3] == ('met' if is_met else 'missed')
