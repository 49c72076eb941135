# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Loss terms of the paper's equation (10), all differentiable.

As printed, the topology and spatial terms decrease when errors increase (``1 - error`` and
``-error``) and compare hard assignments, which have no gradient. Here both are expected errors
under the soft assignment ``X`` and are minimized:

- match: negative log-likelihood of the true partner, or of the dustbin for nodes without one;
- topology: for two submap nodes j, l with true partners, the expected adjacency of their images
  ``E_jl = sum_ik X_ij A_ik X_kl`` against the adjacency of the true partners;
- spatial: for a submap node with a true partner, the expected distance of its image from the
  true partner, ``sum_i X_ij |p_i - p_gt(j)|``. The distance of the expected position would be
  zero for mass split between two rooms on opposite sides of the true one.

Mass in the dustbin does not affect the last two terms; the first penalizes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from fpnet_core.matches import UNMATCHED
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.paper import pair_distances
from fpnet_lab.training.config import LossConfig
from fpnet_lab.training.networks.tensors import TORCH

LIKELIHOOD_FLOOR = 1e-6
"""Numerical: small value added to X before the logarithm (the paper's epsilon)."""


@dataclass(frozen=True, eq=False)
class LossTerms:
    """Scalar tensors: the weighted total and its three terms, means over the batch."""

    total: Tensor
    match: Tensor
    topology: Tensor
    spatial: Tensor


def matching_loss(
    log_assignment: Tensor, labels: Tensor, plan: GraphBatch, weights: LossConfig
) -> LossTerms:
    """
    Return the loss of log-assignments ``(B, M+1, N+1)``.

    Parameters
    ----------
    log_assignment : as returned by the network, dustbins last
    labels : (B, N) int64, plan index of each submap node, UNMATCHED, or IGNORE (also padding)
    plan : the plan graphs; their adjacency and positions are the ground truth
    weights : the three weights
    """
    probability = log_assignment.exp()
    match = match_loss(probability, labels, plan.mask)
    assignment = probability[:, :-1, :-1]
    # Terms without a weight are skipped: they cost as much as the network's last layer.
    topology = spatial = match.new_zeros(())
    if weights.topology:
        topology = topology_loss(assignment, labels, plan.adjacency)
    if weights.spatial:
        spatial = spatial_loss(assignment, labels, pair_distances(TORCH, plan))
    total = weights.match * match + weights.topology * topology + weights.spatial * spatial
    return LossTerms(total, match, topology, spatial)


def supervised_loss(
    outputs: Sequence[Tensor], labels: Tensor, plan: GraphBatch, weights: LossConfig
) -> LossTerms:
    """Return the mean :func:`matching_loss` of several layers' log-assignments."""
    terms = [matching_loss(output, labels, plan, weights) for output in outputs]
    return LossTerms(
        total=torch.stack([term.total for term in terms]).mean(),
        match=torch.stack([term.match for term in terms]).mean(),
        topology=torch.stack([term.topology for term in terms]).mean(),
        spatial=torch.stack([term.spatial for term in terms]).mean(),
    )


def match_loss(probability: Tensor, labels: Tensor, plan_mask: Tensor) -> Tensor:
    """
    Return the mean negative log-likelihood of matches plus that of true dustbins.

    Matched nodes, unmatched submap nodes and unmatched plan nodes are each averaged within a pair:
    a plan has many more nodes than a submap, and their dustbins would outweigh the matches.
    ``probability (B, M+1, N+1)``; IGNORE nodes are not counted.
    """
    nll = -(probability + LIKELIHOOD_FLOOR).log()
    matched = labels >= 0
    partner = labels.clamp_min(0)
    of_partner = nll[:, :-1, :-1].gather(1, partner.unsqueeze(1)).squeeze(1)
    node = torch.arange(plan_mask.shape[1], device=labels.device)
    is_partner = (labels.unsqueeze(1) == node[None, :, None]).any(dim=-1)
    matches = _mean_where(of_partner, matched)
    sub_dust = _mean_where(nll[:, -1, :-1], labels == UNMATCHED)
    plan_dust = _mean_where(nll[:, :-1, -1], plan_mask & ~is_partner)
    return (matches + 0.5 * (sub_dust + plan_dust)).mean()


def topology_loss(assignment: Tensor, labels: Tensor, adjacency: Tensor) -> Tensor:
    """
    Return the mean expected adjacency error over ordered pairs of two matched submap nodes.

    ``assignment (B, M, N)`` without dustbins, ``adjacency (B, M, M)`` 0/1. With E in [0, 1] and
    A in {0, 1}, ``|E - A| = A (1 - E) + (1 - A) E``, which is smooth.
    """
    expected = assignment.transpose(-1, -2) @ adjacency @ assignment
    partner = labels.clamp_min(0)
    rows = adjacency.gather(1, partner.unsqueeze(-1).expand(-1, -1, adjacency.shape[-1]))
    truth = rows.gather(2, partner.unsqueeze(1).expand(-1, rows.shape[1], -1))
    error = truth * (1.0 - expected) + (1.0 - truth) * expected
    matched = labels >= 0
    itself = torch.eye(matched.shape[1], dtype=torch.bool, device=labels.device)
    both = (matched.unsqueeze(-1) & matched.unsqueeze(-2) & ~itself).flatten(1)
    return _mean_where(error.flatten(1), both).mean()


def spatial_loss(assignment: Tensor, labels: Tensor, distances: Tensor) -> Tensor:
    """
    Return the mean expected distance from the true partner, in ``POSITION_UNIT_M``.

    ``assignment (B, M, N)`` without dustbins, ``distances (B, M, M)`` between plan nodes.
    """
    index = labels.clamp_min(0).unsqueeze(1).expand(-1, distances.shape[1], -1)
    error = (assignment * distances.gather(2, index)).sum(dim=1)
    return _mean_where(error, labels >= 0).mean()


def _mean_where(values: Tensor, chosen: Tensor) -> Tensor:
    """Return means ``(B,)`` of ``values (B, K)`` where ``chosen``; 0 if nothing is chosen."""
    total = torch.where(chosen, values, 0.0).sum(dim=-1)
    return total / chosen.sum(dim=-1).clamp_min(1)
