# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What names, levels, heights and leaving a storey say of the storeys."""

import numpy as np
import pytest

from fpnet_core.errors import HintError
from fpnet_core.sites import Link, LinkKind, Site, Storey
from fpnet_core.sites.levels import levels_of
from fpnet_core.sites.storey_plans import (
    weights_after_leaving,
    weights_of_elevation,
    weights_of_level,
)

NAMES = ('north/L1', 'north/L2', 'north/L3', 'south/L1')
AT = {'north/L1': np.array([1.0, 2.0]), 'north/L3': np.array([3.0, 4.0])}
LIFT = Link('A', LinkKind.LIFT, AT)


def site(links=(LIFT,), heights=(0.0, 3.5, 7.0, 0.0)):
    storeys = (
        Storey(name, None, level=level, elevation_m=height)
        for name, level, height in zip(NAMES, (0, 1, 2, 5), heights, strict=True)
    )
    return Site('s', tuple(storeys), links)


@pytest.mark.parametrize('said', ['north/L2', 'L2', ' L2 ', '1'])
def test_a_level_is_a_name_or_a_number(said):
    weights = weights_of_level(site(), said)
    assert max(weights, key=weights.get) == 'north/L2'
    assert sum(weights.values()) == pytest.approx(1.0)


@pytest.mark.parametrize(('said', 'named'), [('L9', 'no storey is'), ('L1', '2 storeys are')])
def test_a_level_that_is_none_or_several_is_refused(said, named):
    with pytest.raises(HintError, match=named):
        weights_of_level(site(), said)


def test_a_height_speaks_for_the_storeys_there():
    weights = weights_of_elevation(site(), 6.4)
    assert max(weights, key=weights.get) == 'north/L3'
    assert weights['north/L2'] < 0.05
    with pytest.raises(HintError, match="'north/L3' has no elevation"):
        weights_of_elevation(site(heights=(0.0, 3.0, None, 0.0)), 3.0)


def test_who_leaves_takes_a_lift_that_is_near():
    weights = weights_after_leaving(site(), 'north/L1', np.array([1.5, 2.0]))
    assert weights['north/L3'] == pytest.approx(weights['north/L1'])  # nobody may have got out
    assert weights['north/L3'] > 10 * weights['north/L2'] > 0.0
    assert sum(weights.values()) == pytest.approx(1.0)


def test_of_two_lifts_the_nearer_one_says_more():
    at = {'north/L1': np.array([41.0, 2.0]), 'north/L2': np.zeros(2)}
    both = site((LIFT, Link('B', LinkKind.LIFT, at)))
    weights = weights_after_leaving(both, 'north/L1', np.array([1.5, 2.0]))
    assert weights['north/L3'] > 5 * weights['north/L2']
    unknown = weights_after_leaving(both, 'north/L1')
    assert unknown['north/L3'] == pytest.approx(unknown['north/L2'])


def test_stairs_lead_away_and_heights_tell_where():
    at = {name: np.zeros(2) for name in NAMES[:3]}
    stairs = site((Link('A', LinkKind.STAIRS, at),))
    weights = weights_after_leaving(stairs, 'north/L1')
    assert weights['north/L2'] == pytest.approx(weights['north/L3'])
    assert weights['north/L1'] < 0.1 * weights['north/L2']
    risen = weights_after_leaving(stairs, 'north/L1', rise_m=3.4)
    assert max(risen, key=risen.get) == 'north/L2'
    assert risen['north/L2'] > 50 * risen['north/L3']


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
