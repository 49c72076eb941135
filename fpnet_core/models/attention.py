# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Multi-head attention with an edge function, and the residual update (paper, eqs. 3 to 7)."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from fpnet_core.models.arrays import MASKED


class Attention(nn.Module):
    """Messages from source nodes to target nodes: ``sum_j (alpha_ij * phi_ij) V_j``."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.scale = 1.0 / math.sqrt(width // heads)
        self.query = nn.Linear(width, width)
        self.key_value = nn.Linear(width, 2 * width)
        self.merge = nn.Linear(width, width)

    def forward(
        self, target: Tensor, source: Tensor, source_mask: Tensor, phi: Tensor | None = None
    ) -> Tensor:
        """
        Return messages ``(B, T, width)``.

        Parameters
        ----------
        target : (B, T, width)
        source : (B, S, width)
        source_mask : (B, S) bool; a graph without a True sends zeros
        phi : (B, heads or 1, T, S) factors of the softmaxed weights, or None for ones
        """
        query = self.query(target).unflatten(-1, (self.heads, -1)).transpose(1, 2)
        key, value = (
            part.unflatten(-1, (self.heads, -1)).transpose(1, 2)
            for part in self.key_value(source).chunk(2, dim=-1)
        )
        # Added instead of masked_fill: cheap forward and backward, and exp() of it is zero.
        padding = (~source_mask)[:, None, None, :] * MASKED
        weights = torch.softmax((query * self.scale) @ key.transpose(-1, -2) + padding, dim=-1)
        weights = weights if phi is None else weights * phi
        message: Tensor = self.merge((weights @ value).transpose(1, 2).flatten(-2))
        return message * source_mask.any(dim=-1)[:, None, None]


class Propagation(nn.Module):
    """
    One layer ``h <- h + MLP([h, m])`` (paper, eq. 3).

    The MLP normalises with LayerNorm: batch statistics would mix padding and unrelated buildings
    into a node, and a robot matches one pair at a time. Its last layer starts at zero, so the
    untrained network is the identity and all eighteen layers train from the start.
    """

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.attention = Attention(width, heads)
        last = nn.Linear(2 * width, width)
        nn.init.zeros_(last.weight)
        nn.init.zeros_(last.bias)
        self.update = nn.Sequential(
            nn.Linear(2 * width, 2 * width), nn.LayerNorm(2 * width), nn.ReLU(), last
        )

    def forward(
        self, target: Tensor, source: Tensor, source_mask: Tensor, phi: Tensor | None = None
    ) -> Tensor:
        """Return updated descriptors ``(B, T, width)``; arguments as in :class:`Attention`."""
        message = self.attention(target, source, source_mask, phi)
        updated: Tensor = target + self.update(torch.cat([target, message], dim=-1))
        return updated
