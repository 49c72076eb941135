# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from graph_pairs import toy_pair
import numpy as np
from pydantic import ValidationError
import pytest
import torch

from fpnet_core.models.batch import adjacency_matrix, pad_graphs
from fpnet_core.models.config import EdgeMapping, PaperConfig
from fpnet_core.models.paper import (
    CONNECTED,
    FAR_WEIGHT,
    LARGEST_INVERSE_DISTANCE,
    SELF_WEIGHT,
    UNCONNECTED,
    edge_weights,
    sinkhorn,
)
from fpnet_lab.training.networks.paper import PaperModule
from fpnet_lab.training.networks.tensors import TORCH, tensors_of


def batch_of(positions, edges):
    rows = np.zeros((len(positions), 28), np.float32)
    rows[:, :2] = positions
    return tensors_of(pad_graphs([rows], [np.array(edges, dtype=np.int64).reshape(-1, 2)]))


def phi(mapping, batch):
    return edge_weights(TORCH, mapping, batch)[0, 0]


def test_defaults_are_the_papers():
    network = PaperModule(PaperConfig())
    assert len(network.self_layers) == len(network.cross_layers) == 9
    assert network.config.width == 26
    assert network.config.heads == 2
    assert network.config.sinkhorn_iterations == 20
    encoder = [m for m in network.encoder.position if isinstance(m, torch.nn.Linear)]
    assert [layer.in_features for layer in encoder] == [3, 6, 13, 26]
    assert encoder[-1].out_features == 26
    # At the paper's width descriptors enter as they are.
    assert not list(network.encoder.descriptor.parameters())


@pytest.mark.parametrize('mapping', list(EdgeMapping))
@pytest.mark.parametrize('width', [26, 12])
def test_network_runs_and_trains(mapping, width):
    network = PaperModule(PaperConfig(width=width, blocks=2, edge_mapping=mapping))
    plan, sub, _ = toy_pair(np.random.default_rng(0))
    output = network(network.batch([plan]), network.batch([sub]))
    assert output.shape == (1, len(plan) + 1, len(sub) + 1)
    assert torch.isfinite(output).all()
    output.sum().backward()
    assert all(p.grad is not None and torch.isfinite(p.grad).all() for p in network.parameters())


def test_untrained_propagation_is_the_identity():
    network = PaperModule(PaperConfig(blocks=3))
    plan, sub, _ = toy_pair(np.random.default_rng(1))
    plan, sub = network.batch([plan]), network.batch([sub])
    expected = network.project(network.network.encoded(plan.node_feat))
    torch.testing.assert_close(network.network.describe(plan, sub)[0], expected)


def test_configuration_rejects_heads_that_do_not_divide_the_width():
    with pytest.raises(ValidationError, match='not a multiple of heads 4'):
        PaperConfig(width=26, heads=4)


def test_padding_marks_real_nodes_and_symmetric_edges():
    plan, sub, _ = toy_pair(np.random.default_rng(2), rooms=4, seen=2)
    batch = PaperModule(PaperConfig()).batch([plan, sub])
    assert batch.mask.sum(dim=1).tolist() == [len(plan), len(sub)]
    assert batch.node_feat[1, len(sub) :].abs().max() == 0.0
    assert torch.equal(batch.adjacency, batch.adjacency.transpose(1, 2))
    assert batch.adjacency.sum(dim=(1, 2)).tolist() == [2 * len(plan.edges), 2 * len(sub.edges)]


def test_empty_graphs_make_a_valid_batch():
    batch = tensors_of(pad_graphs([np.zeros((0, 28), np.float32)], [np.zeros((0, 2), np.int64)]))
    assert batch.mask.tolist() == [[False]]
    output = PaperModule(PaperConfig(blocks=1))(batch, batch)
    assert torch.isfinite(output[..., -1, -1]).all()


def test_adjacency_matrix_of_literal_edges():
    matrix = adjacency_matrix(np.array([[0, 2], [1, 2]]), 3)
    assert matrix.tolist() == [[0, 0, 1], [0, 0, 1], [1, 1, 0]]


def test_connectivity_weights_are_the_papers_two_values():
    found = phi(EdgeMapping.CONNECTIVITY, batch_of([[0, 0], [0.1, 0], [0.5, 0]], [[0, 1]]))
    n, c = UNCONNECTED, CONNECTED
    assert found.numpy() == pytest.approx(np.array([[c, c, n], [c, c, n], [n, n, c]]))
    assert (n, c) == (0.7, 1.0)


def test_distance_weights_favour_near_neighbours_and_ignore_scale():
    # Node 0 has neighbours at 0.1 and 0.3 (mean 0.2): weights 2 and 2/3.
    positions, edges = np.array([[0, 0], [0.1, 0], [0, 0.3], [2, 2]]), [[0, 1], [0, 2]]
    found = phi(EdgeMapping.DISTANCE, batch_of(positions, edges))
    assert found[0].tolist() == pytest.approx([SELF_WEIGHT, 2.0, 2.0 / 3.0, FAR_WEIGHT])
    assert found[1].tolist() == pytest.approx([1.0, SELF_WEIGHT, FAR_WEIGHT, FAR_WEIGHT])
    scaled = phi(EdgeMapping.DISTANCE, batch_of(3.7 * positions, edges))
    torch.testing.assert_close(scaled, found)


def test_distance_weights_are_bounded_where_neighbours_coincide():
    found = phi(EdgeMapping.DISTANCE, batch_of([[0, 0], [0, 0], [0, 1.0]], [[0, 1], [0, 2]]))
    assert found[0, 1] == LARGEST_INVERSE_DISTANCE


def messages(mask, phi):
    module = PaperModule(PaperConfig(width=4, heads=2, blocks=1))
    module.self_layers[0].attention.merge.bias.data.zero_()
    generator = torch.Generator().manual_seed(0)
    target, source = (torch.randn((1, n, 4), generator=generator) for n in (3, mask.shape[1]))
    name = 'self_layers.0.attention'
    return [module.network.message(name, target, source, mask, factors) for factors in (None, phi)]


def test_attention_multiplies_phi_after_the_softmax():
    mask = torch.ones((1, 5), dtype=torch.bool)
    plain, doubled = messages(mask, phi=torch.full((1, 1, 3, 5), 2.0))
    torch.testing.assert_close(doubled, 2.0 * plain)


def test_attention_to_an_empty_graph_says_nothing():
    for message in messages(torch.zeros((1, 2)).bool(), phi=None):
        assert message.abs().max() == 0.0


def test_sinkhorn_finds_the_assignment_of_clear_scores():
    scores = torch.tensor([[[9.0, 0.0], [0.0, 0.0], [0.0, 9.0]]])
    masks = (torch.ones((1, 3), dtype=torch.bool), torch.ones((1, 2), dtype=torch.bool))
    x = sinkhorn(TORCH, scores, torch.tensor(2.0), *masks, iterations=50).exp()[0]
    assert x[0, 0] > 0.95
    assert x[2, 1] > 0.95
    assert x[1, -1] > 0.75


def test_a_higher_dustbin_takes_more_mass():
    scores = torch.zeros((1, 3, 3))
    mask = torch.ones((1, 3), dtype=torch.bool)
    low, high = (
        sinkhorn(TORCH, scores, torch.tensor(z), mask, mask, 20).exp()[0, :3, -1].sum()
        for z in (-2.0, 2.0)
    )
    assert high > low
