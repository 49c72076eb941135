# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from graph_pairs import graph_of, rectangle, toy_pair
import numpy as np
import pytest

from fpnet_core.config import MatcherConfig
from fpnet_core.geometry import SE2
from fpnet_core.types import RegionGraph, RegionLabel
from fpnet_lab.baselines import MATCHERS

EMPTY = RegionGraph((), np.zeros((0, 2)), np.zeros((0, 28)), np.zeros((0, 3)), 'submap')
ANGLES = np.arange(3) * 2.0 * np.pi / 3.0
TURNED = (1, 2, 0)
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


@pytest.mark.parametrize('name', ['rrwm', 'spectral'])
def test_rooms_that_are_equally_far_apart_are_told_by_their_shapes(name):
    middles = 10.0 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    polygons = [
        rectangle(x - width / 2, y - depth / 2, width, depth)
        for (x, y), (width, depth) in zip(middles, [(2, 2), (2, 9), (7, 8)], strict=True)
    ]
    plan, _ = graph_of(polygons, [], {0, 1, 2}, 'plan', SE2.identity())
    sub, _ = graph_of([polygons[i] for i in TURNED], [], {0, 1, 2}, 'submap', SE2.identity())
    pairs = MATCHERS[name](MatcherConfig()).match(plan, sub, 200.0).pairs
    assert dict(pairs[:, ::-1].tolist()) == dict(enumerate(TURNED))


@pytest.mark.parametrize('name', NAMES)
def test_matches_join_equal_labels_and_stay_below_one(name):
    plan, sub, _ = toy_pair(np.random.default_rng(3), rooms=7, seen=4)
    result = MATCHERS[name](MatcherConfig()).match(plan, sub, 200.0)
    assert len(result.pairs) >= 3
    for i, j in result.pairs:
        assert plan.regions[i].label is sub.regions[j].label
    assert result.probability.shape == (len(plan), len(sub))
    assert ((result.scores >= 0.0) & (result.scores <= 1.0)).all()


@pytest.mark.parametrize('name', NAMES)
def test_an_empty_side_has_no_matches(name):
    plan, _, _ = toy_pair(np.random.default_rng(4), rooms=4, seen=2)
    matcher = MATCHERS[name](MatcherConfig())
    assert len(matcher.match(plan, EMPTY, 0.0).pairs) == 0
    assert len(matcher.match(EMPTY, plan, 0.0).pairs) == 0
