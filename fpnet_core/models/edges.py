# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The edge function phi that weighs self-attention (paper, equation 7).

The paper leaves phi open ("defined by connectivity between nodes and relative spatial positions
jointly", two variants, "also can be a simple projection network"). All three are here:

- ``connectivity``: 1 for adjacent nodes and the node itself, 0.7 otherwise.
- ``distance``: the inverse distance for adjacent nodes, 0.5 for others, 20 for the node itself.
  Distances are divided by the node's mean distance to its neighbours, so that phi does not
  depend on the scale of the map, and bounded, so that no neighbour outweighs the node itself.
- ``learned``: a small network per layer and head on connectivity, distance and their product;
  it sees nothing that a rotation or translation of the map changes.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from fpnet_core.graphs.layout import POSITION
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.config import EdgeMapping

CONNECTED, UNCONNECTED = 1.0, 0.7
"""Values of the connectivity variant."""

SELF_WEIGHT, FAR_WEIGHT, LARGEST_INVERSE_DISTANCE = 20.0, 0.5, 10.0
"""Values of the distance variant: the node itself, non-adjacent nodes, bound of the rest."""

# Ranges at which the learned variant's soft thresholds sit, in POSITION_UNIT_M: 1 to 30 m.
_RANGES = (0.05, 0.15, 0.5, 1.5)
_PAIR_FEATURES = 3 + len(_RANGES)
_HIDDEN = 32


def pair_distances(batch: GraphBatch) -> Tensor:
    """Return distances ``(B, R, R)`` between node positions, in ``POSITION_UNIT_M``."""
    position = batch.node_feat[..., POSITION]
    offset = position.unsqueeze(-2) - position.unsqueeze(-3)
    return (offset.square().sum(dim=-1) + torch.finfo(offset.dtype).tiny).sqrt()


def connectivity_weights(batch: GraphBatch) -> Tensor:
    """Return phi ``(B, R, R)`` of the connectivity variant."""
    own = torch.eye(batch.adjacency.shape[-1], device=batch.adjacency.device)
    linked = torch.maximum(batch.adjacency, own)
    return UNCONNECTED + (CONNECTED - UNCONNECTED) * linked


def distance_weights(batch: GraphBatch) -> Tensor:
    """Return phi ``(B, R, R)`` of the distance variant; row i is what node i gathers by."""
    distance, linked = pair_distances(batch), batch.adjacency
    degree = linked.sum(dim=-1, keepdim=True).clamp_min(1.0)
    mean = (distance * linked).sum(dim=-1, keepdim=True) / degree
    inverse = (mean / distance.clamp_min(1e-6)).clamp_max(LARGEST_INVERSE_DISTANCE)
    weights = torch.where(linked > 0, inverse, FAR_WEIGHT)
    own = torch.eye(linked.shape[-1], dtype=torch.bool, device=linked.device)
    return torch.where(own, SELF_WEIGHT, weights)


class EdgeFunction(nn.Module):
    """phi for all self-attention layers at once, from one batch of graphs."""

    def __init__(self, mapping: EdgeMapping, layers: int, heads: int) -> None:
        super().__init__()
        self.mapping, self.layers, self.heads = mapping, layers, heads
        if mapping is EdgeMapping.LEARNED:
            # Convolutions of size one are linear maps per pair that keep heads contiguous.
            self.project = nn.Sequential(
                nn.Conv2d(_PAIR_FEATURES, _HIDDEN, 1),
                nn.ReLU(),
                nn.Conv2d(_HIDDEN, layers * heads, 1),
            )

    def forward(self, batch: GraphBatch) -> tuple[Tensor | None, ...]:
        """Return one phi per layer, each ``(B, heads or 1, R, R)``, or None for ``none``."""
        match self.mapping:
            case EdgeMapping.NONE:
                return (None,) * self.layers
            case EdgeMapping.CONNECTIVITY:
                return (connectivity_weights(batch).unsqueeze(1),) * self.layers
            case EdgeMapping.DISTANCE:
                return (distance_weights(batch).unsqueeze(1),) * self.layers
            case EdgeMapping.LEARNED:
                # Starts around one, where the network is the one without edges.
                weights: Tensor = 1.0 + self.project(_pair_features(batch))
                return torch.split(weights, self.heads, dim=1)


def _pair_features(batch: GraphBatch) -> Tensor:
    """
    Return invariant features ``(B, 3 + ranges, R, R)`` of every ordered pair of nodes.

    Connected, connected over one node between them (two rooms with a common door), the node
    itself, and one exponential of the distance per range.
    """
    linked = batch.adjacency
    own = torch.eye(linked.shape[-1], device=linked.device, dtype=linked.dtype)
    second = (linked @ linked).clamp_max(1.0) * (1.0 - own)
    ranges = torch.tensor(_RANGES, device=linked.device, dtype=linked.dtype)
    decay = torch.exp(-pair_distances(batch).unsqueeze(1) / ranges[:, None, None])
    return torch.cat([torch.stack([linked, second, own.expand_as(linked)], dim=1), decay], dim=1)
