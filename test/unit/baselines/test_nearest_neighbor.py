# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.config import MatcherConfig
from fpnet_core.graphs.features import AREA, LABEL, NODE_FEATURES
from fpnet_core.types import Region, RegionGraph, RegionLabel
from fpnet_lab.baselines import NearestNeighborMatcher

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])


def graph(rows, frame='plan'):
    regions = tuple(
        Region(i, RegionLabel.ROOM, SQUARE, np.zeros(2), 1.0) for i in range(len(rows))
    )
    return RegionGraph(regions, np.zeros((0, 2)), rows, np.zeros((0, 3)), frame)


def rows_of(areas, doors=()):
    rows = np.zeros((len(areas), NODE_FEATURES), np.float32)
    rows[:, AREA] = np.array(areas)[:, None]
    rows[:, LABEL] = (0, 1)
    for door in doors:
        rows[door, LABEL] = (1, 0)
    return rows


def test_mutual_nearest_descriptors_are_paired():
    # Submap area 0.9 is nearest to plan 1.0, but 1.05 is nearer to that; 5.2 goes with 5.0.
    matcher = NearestNeighborMatcher(MatcherConfig())
    result = matcher.match(graph(rows_of([1.0, 5.0, 9.0])), graph(rows_of([0.9, 1.05, 5.2])), 1.0)
    assert result.pairs.tolist() == [[0, 1], [1, 2]]
    assert result.scores == pytest.approx([np.exp(-(0.05**2)), np.exp(-(0.2**2))], rel=1e-4)


def test_doors_never_match_rooms():
    matcher = NearestNeighborMatcher(MatcherConfig())
    result = matcher.match(graph(rows_of([1.0, 3.0], doors=[0])), graph(rows_of([1.0])), 1.0)
    assert result.pairs.tolist() == [[1, 0]]
    only_door = graph(rows_of([1.0], doors=[0]))
    assert matcher.match(only_door, graph(rows_of([1.0])), 1.0).pairs.shape == (0, 2)


@pytest.mark.parametrize('sizes', [(0, 2), (2, 0), (0, 0)])
def test_empty_graphs_have_no_matches(sizes):
    plan, sub = (graph(rows_of([1.0] * n).reshape(n, NODE_FEATURES)) for n in sizes)
    result = NearestNeighborMatcher(MatcherConfig()).match(plan, sub, 1.0)
    assert result.pairs.shape == (0, 2)
    assert result.probability.shape == sizes
