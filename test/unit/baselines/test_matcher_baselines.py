# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from graph_pairs import toy_pair
import numpy as np
import pytest

from fpnet_core.config import MatcherConfig
from fpnet_core.types import RegionGraph, RegionLabel
from fpnet_lab.baselines import MATCHERS

EMPTY = RegionGraph((), np.zeros((0, 2)), np.zeros((0, 28)), np.zeros((0, 3)), 'submap')
NAMES = ('ombb', 'rrwm', 'spectral')


# Right rooms of six seeds: all, but for `spectral` 0.96 of one seed.
@pytest.mark.parametrize('name', NAMES)
def test_baselines_find_the_rooms_of_a_corridor(name):
    rng = np.random.default_rng(2)
    matcher = MATCHERS[name](MatcherConfig())
    right = total = 0
    for _ in range(4):
        plan, sub, labels = toy_pair(rng, rooms=9, seen=6)
        pairs = matcher.match(plan, sub, 200.0).pairs
        rooms = [sub.regions[j].label is RegionLabel.ROOM for j in pairs[:, 1]]
        right += int(np.count_nonzero((labels[pairs[:, 1]] == pairs[:, 0]) & rooms))
        total += sum(region.label is RegionLabel.ROOM for region in sub.regions)
    assert right >= 0.9 * total


@pytest.mark.parametrize('name', NAMES)
def test_an_empty_side_has_no_matches(name):
    plan, _, _ = toy_pair(np.random.default_rng(4), rooms=4, seen=2)
    matcher = MATCHERS[name](MatcherConfig())
    assert len(matcher.match(plan, EMPTY, 0.0).pairs) == 0
    assert len(matcher.match(EMPTY, plan, 0.0).pairs) == 0
