# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The optimiser: orthogonal steps for matrices, AdamW for the rest."""

import torch
from torch import nn

from fpnet_lab.training.checkpoint import load_state, save_state
from fpnet_lab.training.optimizer import Muon


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
