# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differentiable assignment by log-domain Sinkhorn with dustbins (paper, section IV-4 and 5)."""

from __future__ import annotations

import torch
from torch import Tensor

from fpnet_core.models.arrays import MASKED


def log_assignment(
    scores: Tensor, dustbin: Tensor, plan_mask: Tensor, sub_mask: Tensor, iterations: int
) -> Tensor:
    """
    Return the logarithm of the soft assignment, ``(B, M+1, N+1)``; dustbins come last.

    Every real node has mass 1. The plan's dustbin has as much mass as the submap has nodes, and
    vice versa. After the last sweep the columns sum to these masses exactly and the rows
    approximately. Padding has no mass: its entries are below ``MASKED / 2``.

    Parameters
    ----------
    scores : (B, M, N) inner products of descriptors
    dustbin : () learned score of unmatched nodes
    plan_mask, sub_mask : (B, M), (B, N) bool
    iterations : number of row and column sweeps
    """
    couplings = _with_dustbins(scores, dustbin, plan_mask, sub_mask)
    log_rows = _log_masses(plan_mask, sub_mask.sum(dim=-1), scores.dtype)
    log_columns = _log_masses(sub_mask, plan_mask.sum(dim=-1), scores.dtype)
    u = torch.zeros_like(log_rows)
    v = torch.zeros_like(log_columns)
    for _ in range(iterations):
        u = log_rows - torch.logsumexp(couplings + v.unsqueeze(-2), dim=-1)
        v = log_columns - torch.logsumexp(couplings + u.unsqueeze(-1), dim=-2)
    return couplings + u.unsqueeze(-1) + v.unsqueeze(-2)


def _with_dustbins(scores: Tensor, dustbin: Tensor, plan_mask: Tensor, sub_mask: Tensor) -> Tensor:
    """Return ``scores`` with a dustbin row and column and with masked padding."""
    batch, rows, columns = scores.shape
    couplings = torch.cat(
        [
            torch.cat([scores, dustbin.expand(batch, rows, 1)], dim=-1),
            dustbin.expand(batch, 1, columns + 1),
        ],
        dim=-2,
    )
    real = _with_dust(plan_mask).unsqueeze(-1) & _with_dust(sub_mask).unsqueeze(-2)
    return couplings.masked_fill(~real, MASKED)


def _with_dust(mask: Tensor) -> Tensor:
    return torch.cat([mask, mask.new_ones(mask.shape[0], 1)], dim=-1)


def _log_masses(mask: Tensor, dust_mass: Tensor, dtype: torch.dtype) -> Tensor:
    """Return log masses ``(B, R+1)``: 0 for real nodes, MASKED for padding, then the dustbin."""
    nodes = (~mask).to(dtype) * MASKED
    # The lower bound replaces log(0) if the other graph is empty.
    dust = dust_mass.to(dtype).clamp_min(torch.finfo(dtype).tiny).log()
    return torch.cat([nodes, dust.unsqueeze(-1)], dim=-1)
