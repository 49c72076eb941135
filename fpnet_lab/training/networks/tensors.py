# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""PyTorch implementation of the array operations."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from fpnet_core.models.arrays import MASKED, JointBias, Library
from fpnet_core.models.batch import GraphBatch


def tensors_of(batch: GraphBatch) -> GraphBatch:
    """Return a batch of arrays as tensors that share their memory."""
    return GraphBatch(
        torch.from_numpy(batch.node_feat),
        torch.from_numpy(batch.adjacency),
        torch.from_numpy(batch.mask),
    )


def to_device(batch: GraphBatch, device: torch.device) -> GraphBatch:
    """Return a batch of tensors on ``device``."""
    return GraphBatch(
        batch.node_feat.to(device), batch.adjacency.to(device), batch.mask.to(device)
    )


def _mixed(x: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    """Map ``x (B, features, K)``; a batched product saves two transposes."""
    count = len(x)
    return torch.baddbmm(bias[:, None].expand(count, -1, 1), weight.expand(count, -1, -1), x)


def _layer_norm(x: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    return functional.layer_norm(x, weight.shape, weight, bias)


def _attention(query: Tensor, key: Tensor, value: Tensor, bias: JointBias) -> Tensor:
    return functional.scaled_dot_product_attention(query, key, value, attn_mask=_joined(bias))


def _joined(bias: JointBias) -> Tensor:
    """Return the full bias ``(B, heads, M+N, M+N)``."""
    ours, theirs, across = bias.ours, bias.theirs, bias.across[None, :, None, None]
    away = across.expand(*ours.shape[:-1], theirs.shape[-1])
    back = across.expand(*theirs.shape[:-1], ours.shape[-1])
    joint = torch.cat([torch.cat([ours, away], -1), torch.cat([back, theirs], -1)], -2)
    if not bool(bias.mask.all()):
        joint = joint + (~bias.mask * MASKED)[:, None, None, :]
    return joint


def _identity_like(square: Tensor) -> Tensor:
    return torch.eye(square.shape[-1], device=square.device, dtype=square.dtype)


TORCH = Library(
    torch, torch.matmul, functional.linear, _mixed, _layer_norm, functional.gelu, _attention,
    torch.log_softmax, torch.logsumexp, functional.logsigmoid, _identity_like,
)  # fmt: skip
"""PyTorch tensors, with gradients."""
