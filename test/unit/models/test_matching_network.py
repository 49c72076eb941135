# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from graph_pairs import toy_pair
import numpy as np
from pydantic import ValidationError
import pytest
import torch

from fpnet_core.models.batch import pad_graphs
from fpnet_core.models.config import EdgeMapping, PaperConfig
from fpnet_core.models.edges import (
    CONNECTED,
    FAR_WEIGHT,
    SELF_WEIGHT,
    UNCONNECTED,
    connectivity_weights,
    distance_weights,
)
from fpnet_core.models.paper import PaperNetwork
from fpnet_core.models.sinkhorn import log_assignment
from fpnet_core.models.tensors import tensors_of


def batch_of(positions, edges):
    rows = np.zeros((len(positions), 28), np.float32)
    rows[:, :2] = positions
    return tensors_of(pad_graphs([rows], [np.array(edges, dtype=np.int64).reshape(-1, 2)]))


def test_defaults_are_the_papers():
    network = PaperNetwork(PaperConfig())
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
    network = PaperNetwork(PaperConfig(width=width, blocks=2, edge_mapping=mapping))
    plan, sub, _ = toy_pair(np.random.default_rng(0))
    output = network(network.batch([plan]), network.batch([sub]))
    assert output.shape == (1, len(plan) + 1, len(sub) + 1)
    assert torch.isfinite(output).all()
    output.sum().backward()
    assert all(p.grad is not None and torch.isfinite(p.grad).all() for p in network.parameters())


def test_configuration_rejects_heads_that_do_not_divide_the_width():
    with pytest.raises(ValidationError, match='not a multiple of heads 4'):
        PaperConfig(width=26, heads=4)


def test_connectivity_weights_are_the_papers_two_values():
    phi = connectivity_weights(batch_of([[0, 0], [0.1, 0], [0.5, 0]], [[0, 1]]))[0]
    n, c = UNCONNECTED, CONNECTED
    assert phi.numpy() == pytest.approx(np.array([[c, c, n], [c, c, n], [n, n, c]]))
    assert (n, c) == (0.7, 1.0)


def test_distance_weights_favour_near_neighbours_and_ignore_scale():
    # Node 0 has neighbours at 0.1 and 0.3 (mean 0.2): weights 2 and 2/3.
    positions, edges = np.array([[0, 0], [0.1, 0], [0, 0.3], [2, 2]]), [[0, 1], [0, 2]]
    phi = distance_weights(batch_of(positions, edges))[0]
    assert phi[0].tolist() == pytest.approx([SELF_WEIGHT, 2.0, 2.0 / 3.0, FAR_WEIGHT])
    assert phi[1].tolist() == pytest.approx([1.0, SELF_WEIGHT, FAR_WEIGHT, FAR_WEIGHT])
    torch.testing.assert_close(distance_weights(batch_of(3.7 * positions, edges))[0], phi)


def test_sinkhorn_finds_the_assignment_of_clear_scores():
    scores = torch.tensor([[[9.0, 0.0], [0.0, 0.0], [0.0, 9.0]]])
    masks = (torch.ones((1, 3), dtype=torch.bool), torch.ones((1, 2), dtype=torch.bool))
    x = log_assignment(scores, torch.tensor(2.0), *masks, iterations=50).exp()[0]
    assert x[0, 0] > 0.95
    assert x[2, 1] > 0.95
    assert x[1, -1] > 0.75
