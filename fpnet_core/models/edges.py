# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The edge function phi that weights self-attention (paper, equation 7).

The paper leaves phi open ("defined by connectivity between nodes and relative spatial positions
jointly", two variants). This module has both, and a third that matches the paper's ablation:

- ``connectivity``: 1 for adjacent nodes and the node itself, 0.7 otherwise.
- ``distance``: the inverse distance for adjacent nodes, 0.5 for others, 20 for the node itself.
  Distances are divided by the node's mean distance to its neighbours, so that phi does not
  depend on the scale of the map, and bounded, so that no neighbour outweighs the node itself.
- ``proximity``: as ``distance``, but treats all nodes as adjacent: no connectivity.
"""

from __future__ import annotations

import torch
from torch import Tensor

from fpnet_core.graphs.layout import POSITION
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.config import EdgeMapping

CONNECTED, UNCONNECTED = 1.0, 0.7
"""Values of the connectivity variant. Chosen."""

SELF_WEIGHT, FAR_WEIGHT, LARGEST_INVERSE_DISTANCE = 20.0, 0.5, 10.0
"""
Values of the distance variant: the node itself, non-adjacent nodes, bound of the rest. Chosen.
"""


def pair_distances(batch: GraphBatch) -> Tensor:
    """Return distances ``(B, R, R)`` between node positions, in ``POSITION_UNIT_M``."""
    position: Tensor = batch.node_feat[..., POSITION]
    offset = position.unsqueeze(-2) - position.unsqueeze(-3)
    return (offset.square().sum(dim=-1) + torch.finfo(offset.dtype).tiny).sqrt()


def connectivity_weights(batch: GraphBatch) -> Tensor:
    """Return phi ``(B, R, R)`` of the connectivity variant."""
    own = torch.eye(batch.adjacency.shape[-1], device=batch.adjacency.device)
    linked = torch.maximum(batch.adjacency, own)
    return UNCONNECTED + (CONNECTED - UNCONNECTED) * linked


def distance_weights(batch: GraphBatch) -> Tensor:
    """Return phi ``(B, R, R)`` of the distance variant; row i weights the inputs of node i."""
    linked = batch.adjacency
    return _with_own(torch.where(linked > 0, _inverse_distances(batch, linked), FAR_WEIGHT))


def proximity_weights(batch: GraphBatch) -> Tensor:
    """Return phi ``(B, R, R)`` of the distance variant without connectivity."""
    real = batch.mask.to(batch.node_feat.dtype)
    others = real.unsqueeze(-1) * real.unsqueeze(-2)
    return _with_own(_inverse_distances(batch, others))


def _inverse_distances(batch: GraphBatch, counted: Tensor) -> Tensor:
    """Return each node's mean distance to ``counted (B, R, R)`` nodes over the pair's distance."""
    distance = pair_distances(batch)
    total = counted.sum(dim=-1, keepdim=True).clamp_min(1.0)
    mean = (distance * counted).sum(dim=-1, keepdim=True) / total
    return (mean / distance.clamp_min(1e-6)).clamp_max(LARGEST_INVERSE_DISTANCE)


def _with_own(weights: Tensor) -> Tensor:
    own = torch.eye(weights.shape[-1], dtype=torch.bool, device=weights.device)
    return torch.where(own, SELF_WEIGHT, weights)


def edge_weights(mapping: EdgeMapping, batch: GraphBatch) -> Tensor | None:
    """Return phi ``(B, 1, R, R)`` for every self-attention layer and head, None for ``none``."""
    match mapping:
        case EdgeMapping.NONE:
            return None
        case EdgeMapping.CONNECTIVITY:
            return connectivity_weights(batch).unsqueeze(1)
        case EdgeMapping.DISTANCE:
            return distance_weights(batch).unsqueeze(1)
        case EdgeMapping.PROXIMITY:
            return proximity_weights(batch).unsqueeze(1)
