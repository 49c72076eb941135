# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Networks as PyTorch modules: parameters with gradients for the networks of the core."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from fpnet_core.io.weights import Weights, check_shapes
from fpnet_core.models.batch import GraphBatch, pad_graphs
from fpnet_core.models.config import NetworkConfig
from fpnet_core.models.inference import RegionNetwork, network_of
from fpnet_core.types import RegionGraph
from fpnet_lab.training.networks.tensors import TORCH, tensors_of


class RegionModule(nn.Module):
    """Module from two batches of graphs to log-assignments ``(B, M+1, N+1)``, dustbins last."""

    config: NetworkConfig

    @property
    def network(self) -> RegionNetwork:
        """The network on this module's parameters, with gradients."""
        return network_of(self.config, TORCH, dict(self.named_parameters()))

    def forward(self, plan: GraphBatch, sub: GraphBatch) -> Tensor:
        """Return the log-assignment ``(B, M+1, N+1)``, dustbins last."""
        found: Tensor = self.network.log_assignment(plan, sub)
        return found

    def assignments(self, plan: GraphBatch, sub: GraphBatch) -> list[Tensor]:
        """Return every log-assignment that training supervises, the final one last."""
        return self.network.assignments(plan, sub)

    def batch(self, graphs: Sequence[RegionGraph]) -> GraphBatch:
        """Return the graphs as one padded batch of tensors."""
        rows = [self.network.rows(graph) for graph in graphs]
        return tensors_of(pad_graphs(rows, [graph.edges for graph in graphs]))


def load_tensors(module: RegionModule, weights: Weights) -> None:
    """Copy the tensors into ``module``; WeightsError if one does not fit."""
    expected = {key: tuple(value.shape) for key, value in module.state_dict().items()}
    check_shapes('weights', weights.tensors, expected)
    module.load_state_dict({key: torch.from_numpy(v) for key, v in weights.tensors.items()})
