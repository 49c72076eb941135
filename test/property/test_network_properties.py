# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Symmetries of the network that hold for any weights."""

from dataclasses import replace

from graph_pairs import toy_pair
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
import torch

from fpnet_core.graphs.layout import POSITION
from fpnet_core.models.batch import GraphBatch, pad_graphs
from fpnet_core.models.config import EdgeMapping, PaperConfig
from fpnet_core.models.paper import edge_weights, sinkhorn
from fpnet_lab.training.networks.paper import PaperModule
from fpnet_lab.training.networks.tensors import TORCH, tensors_of

SMALL = {'width': 8, 'heads': 2, 'blocks': 2, 'position_widths': (6,)}


def random_network(mapping=EdgeMapping.DISTANCE, seed=0, **sizes):
    """Return a network none of whose layers is at its neutral start."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = PaperModule(PaperConfig(edge_mapping=mapping, **(SMALL | sizes)))
        for parameter in network.parameters():
            torch.nn.init.normal_(parameter, std=0.4)
    return network.double().eval()


def doubled(batch):
    return GraphBatch(batch.node_feat.double(), batch.adjacency.double(), batch.mask)


def graphs(seed):
    plan, sub, _ = toy_pair(np.random.default_rng(seed), rooms=7, seen=3)
    return doubled(PaperModule(PaperConfig()).batch([plan])), doubled(
        PaperModule(PaperConfig()).batch([sub])
    )


def permuted(batch, order):
    return GraphBatch(
        batch.node_feat[:, order], batch.adjacency[:, order][:, :, order], batch.mask[:, order]
    )


@pytest.mark.parametrize('mapping', list(EdgeMapping))
@given(seed=st.integers(0, 10_000))
@settings(max_examples=10, deadline=None)
def test_permuting_regions_permutes_the_assignment(mapping, seed):
    network = random_network(mapping, seed)
    plan, sub = graphs(seed)
    generator = torch.Generator().manual_seed(seed)
    rows = torch.randperm(plan.mask.shape[1], generator=generator)
    columns = torch.randperm(sub.mask.shape[1], generator=generator)
    with torch.inference_mode():
        before = network(plan, sub)
        after = network(permuted(plan, rows), permuted(sub, columns))
    with_dust = [torch.cat([order, torch.tensor([len(order)])]) for order in (rows, columns)]
    expected = before[:, with_dust[0]][:, :, with_dust[1]]
    torch.testing.assert_close(after, expected, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize('mapping', list(EdgeMapping))
@given(seed=st.integers(0, 10_000))
@settings(max_examples=5, deadline=None)
def test_padding_and_batch_neighbours_change_nothing(mapping, seed):
    network = random_network(mapping, seed)
    rng = np.random.default_rng(seed)
    pairs = [toy_pair(rng, rooms, seen)[:2] for rooms, seen in ((5, 2), (9, 6))]
    together_plan, together_sub = (
        doubled(
            tensors_of(pad_graphs([p[i].node_feat for p in pairs], [p[i].edges for p in pairs]))
        )
        for i in (0, 1)
    )
    with torch.inference_mode():
        together = network(together_plan, together_sub)
        for index, (plan, sub) in enumerate(pairs):
            alone = network(
                doubled(PaperModule(PaperConfig()).batch([plan])),
                doubled(PaperModule(PaperConfig()).batch([sub])),
            )[0]
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
    plan, _ = graphs(seed)
    turn = torch.tensor([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    moved = plan.node_feat.clone()
    moved[..., POSITION] = moved[..., POSITION] @ turn.T + torch.tensor([0.7, -0.2])
    one = edge_weights(TORCH, mapping, plan)
    other = edge_weights(TORCH, mapping, replace(plan, node_feat=moved))
    assert (one is None) == (mapping is EdgeMapping.NONE)
    if one is not None:
        torch.testing.assert_close(one, other, rtol=1e-6, atol=1e-6)
