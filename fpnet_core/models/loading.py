# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Loading of checked weights into a network of tensors."""

from __future__ import annotations

import torch

from fpnet_core.io.weights import Weights, check_shapes
from fpnet_core.models.config import NetworkConfig, PaperConfig, network_config
from fpnet_core.models.invariant import InvariantNetwork
from fpnet_core.models.network import RegionNetwork
from fpnet_core.models.paper import PaperNetwork


def make_network(config: NetworkConfig) -> RegionNetwork:
    """Return the network of ``config`` with random weights."""
    return PaperNetwork(config) if isinstance(config, PaperConfig) else InvariantNetwork(config)


def network_type(config: NetworkConfig) -> type[RegionNetwork]:
    """Return the network class of ``config``, which defines its node rows."""
    return PaperNetwork if isinstance(config, PaperConfig) else InvariantNetwork


def load_network(weights: Weights) -> RegionNetwork:
    """
    Return the network that ``weights`` describe, ready for inference.

    Raises
    ------
    WeightsError
        If the manifest's network is unknown or its tensors do not fit the network.
    """
    network = make_network(network_config(weights))
    load_tensors(network, weights)
    return network.eval().requires_grad_(False)


def load_tensors(network: RegionNetwork, weights: Weights) -> None:
    """Copy the tensors into ``network``; WeightsError if one does not fit."""
    expected = {key: tuple(value.shape) for key, value in network.state_dict().items()}
    check_shapes('weights', weights.tensors, expected)
    network.load_state_dict({key: torch.from_numpy(v) for key, v in weights.tensors.items()})
