# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting small networks that vote: one after another, each from a seed of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
import torch
from torch import Tensor, nn

from fpnet_core.io.weights import write_weights

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


def stacked_layers(networks: Sequence[nn.Module]) -> dict[str, NDArray[Any]]:
    """
    Return weights (members, ...) by layer, and biases by ``LAYER_bias``.

    Layers with one output have no axis for it.
    """
    layers: dict[str, NDArray[Any]] = {}
    for name in dict(networks[0].named_parameters()):
        each = [network.get_parameter(name).detach().numpy() for network in networks]
        stacked = np.stack([values[0] if len(values) == 1 else values for values in each])
        layers[name.replace('.weight', '').replace('.bias', '_bias')] = stacked
    return layers


def write_members(
    path: Path,
    tensors: Mapping[str, NDArray[Any]],
    schema: int,
    config: MemberTraining,
    facts: Mapping[str, Any],
    **inputs: Sequence[str],
) -> None:
    """Write networks with their manifest: the names of their ``inputs``, settings, and facts."""
    network = {'members': config.members, 'width': config.width}
    named = {kind: list(names) for kind, names in inputs.items()}
    manifest = {'network': network | named, 'training': asdict(config), **facts}
    write_weights(path, dict(tensors), schema, manifest)
