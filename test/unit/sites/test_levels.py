# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Levels as the names of drawings say them."""

import pytest

from fpnet_core.sites.levels import levels_of


@pytest.mark.parametrize(
    ('names', 'levels'),
    [
        (['DG', 'EG', 'OG1', 'OG2', 'OG3', 'UG1', 'UG2'], [4, 0, 1, 2, 3, -1, -2]),
        (['1. OG', '2. Obergeschoss', 'Erdgeschoss', 'Keller'], [1, 2, 0, -1]),
        (['1st floor', '2nd_floor', 'basement', 'ground floor', 'roof'], [1, 2, -1, 0, 3]),
        (['B1', 'B2', 'G', 'L1', 'L10', 'L2'], [-1, -2, 0, 1, 10, 2]),
        (['house3_EG', 'house3_OG1_v7', 'house3_UG'], [0, 1, -1]),
        (['0', '1', '-1'], [0, 1, -1]),
        (['level -1', 'level 0', 'level 1'], [-1, 0, 1]),
        (['1er étage', 'RDC', 'sous-sol'], [1, 0, -1]),
        (['piso 2', 'planta 1', 'sotano'], [2, 1, -1]),
        (['first floor', 'second floor'], [1, 2]),
    ],
)
def test_names_say_levels(names, levels, caplog):
    assert levels_of(names) == levels
    assert not caplog.records


def test_names_that_say_none_follow_the_alphabet_above_and_are_named(caplog):
    assert levels_of(['annex', 'EG', 'hall', 'OG1']) == [2, 0, 3, 1]
    (said,) = caplog.messages
    assert 'annex, hall' in said
    assert levels_of(['a', 'b']) == [0, 1]
    assert levels_of(['alone']) == [0]
