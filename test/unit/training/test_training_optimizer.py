# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The optimiser: orthogonal steps for matrices, AdamW for the rest."""

import numpy as np
import pytest
import torch
from torch import nn

from fpnet_lab.training.checkpoint import load_state, save_state
from fpnet_lab.training.config import TrainingConfig, parse_training_config
from fpnet_lab.training.optimizer import Muon, make_optimizer, orthogonalized, rate_at


@pytest.mark.parametrize('shape', [(3, 40, 40), (2, 32, 64), (1, 96, 48)])
def test_directions_have_singular_values_of_about_one(shape):
    matrices = torch.randn(shape, generator=torch.Generator().manual_seed(1))

    values = torch.linalg.svdvals(orthogonalized(matrices))

    assert values.min() > 0.3
    assert values.max() < 1.3


def test_directions_keep_the_singular_vectors():
    matrix = torch.randn((1, 40, 40), generator=torch.Generator().manual_seed(2))
    u, _, vh = torch.linalg.svd(matrix)

    turned = u.mT @ orthogonalized(matrix) @ vh.mT

    off_diagonal = turned - torch.diag_embed(torch.diagonal(turned, dim1=-2, dim2=-1))
    assert off_diagonal.abs().max() < 1e-3


def test_small_parameters_step_as_under_adamw():
    ours, theirs = (nn.Linear(8, 4) for _ in range(2))
    theirs.load_state_dict(ours.state_dict())
    pair = (
        (ours, Muon(ours.parameters(), lr=0.01, weight_decay=0.1)),
        (theirs, torch.optim.AdamW(theirs.parameters(), lr=0.01, weight_decay=0.1)),
    )
    rows = torch.linspace(-1.0, 1.0, 24).reshape(3, 8)
    for _ in range(3):
        for layer, optimizer in pair:
            optimizer.zero_grad()
            layer(rows).square().sum().backward()
            optimizer.step()

    assert torch.equal(ours.weight, theirs.weight)


def test_blocks_of_a_tall_matrix_step_on_their_own():
    layer = nn.Linear(32, 96, bias=False)
    before = layer.weight.detach().clone()
    optimizer = Muon(layer.parameters(), lr=0.1, weight_decay=0.0)
    layer.weight.grad = torch.zeros_like(layer.weight)
    layer.weight.grad[:32] = torch.eye(32)

    optimizer.step()

    moved = (layer.weight.detach() - before).abs().amax(dim=1)
    assert (moved[:32] > 0.0).all()
    assert (moved[32:] == 0.0).all()


def test_a_linear_map_is_learned():
    torch.manual_seed(0)
    truth, learned = torch.randn(32, 32), nn.Linear(32, 32, bias=False)
    optimizer = Muon(learned.parameters(), lr=0.1, weight_decay=0.0)
    rows = torch.randn(256, 32)

    def loss():
        return (learned(rows) - rows @ truth.T).square().mean()

    first = loss().item()
    for _ in range(150):
        optimizer.zero_grad()
        loss().backward()
        optimizer.step()
    assert loss().item() < 0.05 * first


def test_a_saved_state_goes_on_where_it_was(tmp_path):
    def stepped(layer, optimizer, count):
        for _ in range(count):
            optimizer.zero_grad()
            layer(torch.linspace(-1.0, 1.0, 48).reshape(1, 48)).square().sum().backward()
            optimizer.step()

    torch.manual_seed(3)
    whole, parts = nn.Linear(48, 40), nn.Linear(48, 40)
    parts.load_state_dict(whole.state_dict())
    first = Muon(whole.parameters(), lr=0.01, weight_decay=0.1)
    stepped(whole, first, 4)
    second = Muon(parts.parameters(), lr=0.01, weight_decay=0.1)
    stepped(parts, second, 2)
    save_state(tmp_path / 'state.safetensors', parts, second, {'epoch': 1})

    again = nn.Linear(48, 40)
    third = Muon(again.parameters(), lr=0.01, weight_decay=0.1)
    assert load_state(tmp_path / 'state.safetensors', again, third) == {'epoch': 1}
    stepped(again, third, 2)

    assert torch.equal(again.weight, whole.weight)
    assert torch.equal(again.bias, whole.bias)


@pytest.mark.parametrize(('name', 'kind'), [('muon', Muon), ('adamw', torch.optim.AdamW)])
def test_a_run_names_its_optimizer(name, kind):
    config: TrainingConfig = parse_training_config({'optimizer': name})

    optimizer = make_optimizer(nn.Linear(4, 4), config)

    assert type(optimizer) is kind
    assert np.isclose(optimizer.param_groups[0]['lr'], config.learning_rate)


def test_the_rate_rises_and_falls():
    rates = [rate_at(step, 100, 1.0, 0.1) for step in range(101)]
    assert rates[0] == pytest.approx(0.1)
    assert max(rates) == rates[10] == 1.0
    assert rates[55] == pytest.approx(0.5)
    assert rates[100] == pytest.approx(0.0, abs=1e-9)
