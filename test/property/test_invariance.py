# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The default preset sees nothing of a map's rotation, place, scale or numbering."""

from dataclasses import replace

from graph_pairs import toy_pair
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
import torch

from fpnet_core.config import MatcherConfig
from fpnet_core.geometry import Similarity2D
from fpnet_core.graphs import edge_features, node_features
from fpnet_core.graphs.invariant import invariant_rows
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.config import InvariantConfig
from fpnet_core.types import RegionGraph
from fpnet_lab.training.networks.invariant import InvariantModule

SIMILARITIES = st.builds(
    lambda scale, yaw, x, y: Similarity2D.from_scale_yaw(scale, yaw, [x, y]),
    st.floats(0.05, 40.0),
    st.floats(-3.1, 3.1),
    st.floats(-500.0, 500.0),
    st.floats(-500.0, 500.0),
)
SEEDS = st.integers(0, 1000)


def moved(graph, S):
    """Return the graph of the same regions after a similarity, with its features anew."""
    regions = tuple(
        replace(
            region,
            polygon=S.apply(region.polygon),
            centroid=S.apply(region.centroid),
            area_m2=region.area_m2 * S.scale**2,
        )
        for region in graph.regions
    )
    widths = np.ones(len(graph.edges))
    return RegionGraph(
        regions,
        graph.edges,
        node_features(regions),
        edge_features(regions, graph.edges, widths),
        graph.frame,
    )


def random_network(seed):
    """Return a network none of whose layers is at its neutral start, in double precision."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = InvariantModule(InvariantConfig(width=16, heads=4, layers=2))
        for parameter in network.parameters():
            torch.nn.init.normal_(parameter, std=0.3)
    return network.double().eval()


def doubled(batch):
    return GraphBatch(batch.node_feat.double(), batch.adjacency.double(), batch.mask)


@given(S=SIMILARITIES, seed=SEEDS)
@settings(max_examples=25, deadline=None)
def test_network_output_is_invariant(S, seed):
    network = random_network(seed)
    plan, sub, _ = toy_pair(np.random.default_rng(seed), rooms=6, seen=3)
    with torch.inference_mode():
        expected = network(doubled(network.batch([plan])), doubled(network.batch([sub])))
        for pair in ((moved(plan, S), sub), (plan, moved(sub, S))):
            output = network(*(doubled(network.batch([graph])) for graph in pair))
            torch.testing.assert_close(output, expected, rtol=2e-3, atol=2e-3)


@given(S=SIMILARITIES, seed=SEEDS)
@settings(max_examples=25, deadline=None)
def test_rows_are_invariant_but_for_position_and_axis(S, seed):
    plan, _, _ = toy_pair(np.random.default_rng(seed), rooms=6, seen=3)
    before, after = invariant_rows(plan), invariant_rows(moved(plan, S))
    assert after[:, 4:] == pytest.approx(before[:, 4:], abs=2e-3)
    assert np.linalg.norm(after[:, :2], axis=1) == pytest.approx(
        np.linalg.norm(before[:, :2], axis=1), abs=1e-3
    )


@given(S=SIMILARITIES, seed=SEEDS)
@settings(max_examples=6, deadline=None, derandomize=True)
def test_matches_of_the_packaged_matcher_are_invariant(S, seed):
    matcher = LearnedMatcher(MatcherConfig())
    plan, sub, _ = toy_pair(np.random.default_rng(seed), rooms=8, seen=5)
    expected = matcher.match(plan, sub, 300.0).probability
    for pair in ((moved(plan, S), sub), (plan, moved(sub, S))):
        found = matcher.match(*pair, 300.0).probability
        assert found == pytest.approx(expected, abs=0.03)


@given(seed=SEEDS)
@settings(max_examples=10, deadline=None)
def test_double_softmax_leaves_room_for_being_unmatched(seed):
    network = random_network(seed)
    plan, sub, _ = toy_pair(np.random.default_rng(seed), rooms=6, seen=3)
    with torch.inference_mode():
        x = network(doubled(network.batch([plan])), doubled(network.batch([sub])))[0].exp()
    pairs = x[:-1, :-1]
    assert float(pairs.sum(dim=0).max()) <= 1.0
    assert float(pairs.sum(dim=1).max()) <= 1.0
    # A node's chance of a partner is at most its matchability.
    assert float((pairs.sum(dim=0) + x[-1, :-1]).max()) <= 1.0 + 1e-9
