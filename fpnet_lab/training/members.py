# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Training of ensembles of small networks, each from its own seed."""

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

_SEEDS = 1009  # numerical: keeps the members' seeds of different runs apart


@dataclass(frozen=True)
class MemberTraining:
    """Common training settings of small networks."""

    members: int = 5
    width: int = 32
    epochs: int = 40
    batch_size: int = 256
    learning_rate: float = 2e-3
    weight_decay: float = 1e-3
    dropout: float = 0.1
    seed: int = 0

    def seed_of(self, member: int) -> int:
        """Return the seed of one member."""
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
    Train one network; the same data, settings and member give the same network.

    Parameters
    ----------
    make : returns a network initialized from torch's global random state, which is restored
    loss_of : loss of a network on the samples at indices (B,)
    count : number of samples
    config, member : settings, and number of the network
    generator : shuffles the samples; None: the global state
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
    Return weights (members, ...) by layer; the key of biases is ``LAYER_bias``.

    Layers with one output have no output axis.
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
    """Write networks and manifest: names of their ``inputs``, settings, and facts."""
    network = {'members': config.members, 'width': config.width}
    named = {kind: list(names) for kind, names in inputs.items()}
    manifest = {'network': network | named, 'training': asdict(config), **facts}
    write_weights(path, dict(tensors), schema, manifest)
