# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Symmetries of both networks that hold for any weights."""

from dataclasses import replace
from functools import partial

from graph_pairs import toy_pair
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
import torch

from fpnet_core.graphs.layout import POSITION
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.config import EdgeMapping, InvariantConfig, PaperConfig
from fpnet_core.models.paper import edge_weights, sinkhorn
from fpnet_lab.training.networks.invariant import InvariantModule
from fpnet_lab.training.networks.paper import PaperModule
from fpnet_lab.training.networks.tensors import TORCH

SMALL = {'width': 8, 'heads': 2, 'blocks': 2, 'position_widths': (6,)}
NETWORKS = {
    'invariant': lambda: InvariantModule(InvariantConfig(width=16, heads=4, layers=2)),
    **{m.value: partial(PaperModule, PaperConfig(edge_mapping=m, **SMALL)) for m in EdgeMapping},
}


def random_network(name, seed):
    """Return a network none of whose layers is at its neutral start, in double precision."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = NETWORKS[name]()
        for parameter in network.parameters():
            torch.nn.init.normal_(parameter, std=0.3)
    return network.double().eval()


def batch(network, graphs):
    made = network.batch(graphs)
    return GraphBatch(made.node_feat.double(), made.adjacency.double(), made.mask)


@pytest.mark.parametrize('name', NETWORKS)
@given(seed=st.integers(0, 10_000))
@settings(max_examples=10, deadline=None)
def test_permuting_regions_permutes_the_assignment(name, seed):
    network = random_network(name, seed)
    plan, sub, _ = toy_pair(np.random.default_rng(seed), rooms=7, seen=3)
    sides = [batch(network, [side]) for side in (plan, sub)]
    generator = torch.Generator().manual_seed(seed)
    orders = [torch.randperm(side.mask.shape[1], generator=generator) for side in sides]
    shuffled = [
        GraphBatch(s.node_feat[:, o], s.adjacency[:, o][:, :, o], s.mask[:, o])
        for s, o in zip(sides, orders, strict=True)
    ]
    with torch.inference_mode():
        before, after = network(*sides), network(*shuffled)
    rows, columns = (torch.cat([o, torch.tensor([len(o)])]) for o in orders)
    torch.testing.assert_close(after, before[:, rows][:, :, columns], rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize('name', NETWORKS)
@given(seed=st.integers(0, 10_000))
@settings(max_examples=5, deadline=None)
def test_padding_and_batch_neighbours_change_nothing(name, seed):
    network = random_network(name, seed)
    rng = np.random.default_rng(seed)
    pairs = [toy_pair(rng, rooms, seen)[:2] for rooms, seen in ((5, 2), (9, 6))]
    with torch.inference_mode():
        together = network(*(batch(network, [pair[i] for pair in pairs]) for i in (0, 1)))
        for index, (plan, sub) in enumerate(pairs):
            alone = network(batch(network, [plan]), batch(network, [sub]))[0]
            inside = together[index, : len(plan), : len(sub)]
            torch.testing.assert_close(inside, alone[:-1, :-1], rtol=1e-8, atol=1e-8)
            dust = together[index, -1, : len(sub)]
            torch.testing.assert_close(dust, alone[-1, :-1], rtol=1e-8, atol=1e-8)


@given(
    rows=st.integers(1, 12),
    columns=st.integers(1, 12),
    padding=st.integers(0, 3),
    seed=st.integers(0, 10_000),
)
@settings(max_examples=40, deadline=None)
def test_sinkhorn_marginals(rows, columns, padding, seed):
    generator = torch.Generator().manual_seed(seed)
    shape = (1, rows + padding, columns + padding)
    scores = 3.0 * torch.randn(shape, generator=generator, dtype=torch.float64)
    plan_mask = torch.arange(shape[1])[None] < rows
    sub_mask = torch.arange(shape[2])[None] < columns
    dustbin = torch.tensor(0.7, dtype=torch.float64)
    log_x = sinkhorn(TORCH, scores, dustbin, plan_mask, sub_mask, iterations=2000)
    x = log_x.exp()[0]
    assert x[:rows].sum(dim=1).numpy() == pytest.approx(np.ones(rows), abs=1e-5)
    assert x[:, :columns].sum(dim=0).numpy() == pytest.approx(np.ones(columns), abs=1e-9)
    assert float(x[-1].sum()) == pytest.approx(columns, abs=1e-3)
    assert float(x[:, -1].sum()) == pytest.approx(rows, abs=1e-9)
    assert float(x[rows:-1].sum() + x[:, columns:-1].sum()) == 0.0


def test_paper_iterations_nearly_reach_the_marginals():
    scores = torch.randn((1, 20, 8), generator=torch.Generator().manual_seed(3))
    masks = (torch.ones((1, 20), dtype=torch.bool), torch.ones((1, 8), dtype=torch.bool))
    x = sinkhorn(TORCH, scores, torch.ones(()), *masks, iterations=20).exp()[0]
    assert x[:20].sum(dim=1).numpy() == pytest.approx(np.ones(20), abs=1e-3)
    assert x[:, :8].sum(dim=0).numpy() == pytest.approx(np.ones(8), abs=1e-5)


@pytest.mark.parametrize('mapping', list(EdgeMapping))
@given(yaw=st.floats(-3.0, 3.0), seed=st.integers(0, 1000))
@settings(max_examples=10, deadline=None)
def test_edge_functions_ignore_rotation_and_translation(mapping, yaw, seed):
    graph, _, _ = toy_pair(np.random.default_rng(seed), rooms=7, seen=3)
    plan = batch(PaperModule(PaperConfig()), [graph])
    turn = torch.tensor([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    moved = plan.node_feat.clone()
    moved[..., POSITION] = moved[..., POSITION] @ turn.T + torch.tensor([0.7, -0.2])
    one = edge_weights(TORCH, mapping, plan)
    other = edge_weights(TORCH, mapping, replace(plan, node_feat=moved))
    assert (one is None) == (mapping is EdgeMapping.NONE)
    if one is not None:
        torch.testing.assert_close(one, other, rtol=1e-6, atol=1e-6)
