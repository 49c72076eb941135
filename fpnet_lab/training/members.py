# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting small networks that vote: one after another, each from a seed of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import torch
from torch import Tensor, nn

Network = TypeVar('Network', bound=nn.Module)

_SEEDS = 1009  # numerical: members' seeds of two runs are not the same


@dataclass(frozen=True)
class MemberTraining:
    """Settings of a fit that small networks have in common."""

    members: int = 5
    width: int = 32
    epochs: int = 40
    batch_size: int = 256
    learning_rate: float = 2e-3
    weight_decay: float = 1e-3
    dropout: float = 0.1
    seed: int = 0

    def seed_of(self, member: int) -> int:
        """Return the seed of one network."""
        return self.seed * _SEEDS + member


def fit_member(
    make: Callable[[], Network],
    loss_of: Callable[[Network, Tensor], Tensor],
    count: int,
    config: MemberTraining,
    member: int,
    generator: torch.Generator | None = None,
) -> Network:
    """
    Fit one network; the same data, settings and number give the same network.

    Parameters
    ----------
    make : a network with random weights, from torch's global state, which is put back
    loss_of : of a network on the samples at these indices (B,)
    count : how many samples there are
    config, member : the settings, and which of the networks
    generator : shuffles the samples; None takes the global state
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed_of(member))
        network = make()
        optimizer = torch.optim.AdamW(
            network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay
        )
        batches = -(-count // config.batch_size)
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimizer, config.learning_rate, total_steps=config.epochs * batches
        )
        for _ in range(config.epochs):
            order = torch.randperm(count, generator=generator)
            for chosen in torch.split(order, config.batch_size):
                optimizer.zero_grad()
                loss_of(network, chosen).backward()  # type: ignore[no-untyped-call]
                optimizer.step()
                schedule.step()
    return network.eval()
