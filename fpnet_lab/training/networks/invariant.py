# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trainable parameters of the ``fpnet`` preset's network, and their initialisation."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from fpnet_core.models.config import InvariantConfig
from fpnet_core.models.joint_attention import NODE_FEATURES, RELATION_WIDTH, RELATIONS
from fpnet_lab.training.networks.modules import RegionModule

# Chosen, not measured:
_FOCUS = ((3, 4.0), (4, 4.0), (0, -1.5))  # relation and initial weight of successive heads
_ACROSS = 3.0  # initial logit of the other graph's nodes, for heads that attend to it


class InvariantModule(RegionModule):
    """Parameters of :class:`~fpnet_core.models.joint_attention.JointAttention`."""

    config: InvariantConfig

    def __init__(self, config: InvariantConfig) -> None:
        super().__init__()
        self.config = config
        width = config.width
        self.encoder = nn.Sequential(
            nn.Linear(NODE_FEATURES, 2 * width), nn.Identity(), nn.Linear(2 * width, width)
        )
        self.relation_bias = _relation_bias(config.layers, config.heads)
        self.layers = nn.ModuleList(_JointLayer(width) for _ in range(config.layers))
        self.across = nn.Parameter(_first_across(config.layers, config.heads))
        self.normalise = nn.LayerNorm(width)
        self.project = nn.Linear(width, width + 1)


def _relation_bias(layers: int, heads: int) -> nn.ModuleDict:
    hidden = nn.Linear(RELATIONS, RELATION_WIDTH)
    out = nn.Linear(RELATION_WIDTH + RELATIONS, layers * heads)
    with torch.no_grad():
        out.weight[:, RELATION_WIDTH:] = _first_focus(layers, heads)
    return nn.ModuleDict({'hidden': hidden, 'out': out})


class _JointLayer(nn.Module):
    """One layer, initialised as the identity."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.normalise = nn.LayerNorm(width)
        self.qkv = nn.Linear(width, 3 * width)
        self.update = nn.Linear(2 * width, 2 * width)
        self.out = nn.Linear(2 * width, width)
        nn.init.zeros_(self.out.weight)
        nn.init.zeros_(self.out.bias)


def _first_focus(layers: int, heads: int) -> Tensor:
    """
    Return initial weights ``(layers * heads, 12)`` of the relations: heads start as graph filters.

    In turn, heads attend to connected regions, to regions one door away, and to near ones. From
    uniform attention over a hundred regions, training would have to learn all of this.
    """
    focus = torch.zeros(layers, heads, RELATIONS)
    for head in range(heads):
        turn = head % (len(_FOCUS) + 1)
        if turn < len(_FOCUS):
            relation, weight = _FOCUS[turn]
            focus[:, head, relation] = weight
    return focus.flatten(0, 1)


def _first_across(layers: int, heads: int) -> Tensor:
    """Return initial logits across the graphs: every fourth head attends there, no other."""
    away = torch.arange(heads) % (len(_FOCUS) + 1) == len(_FOCUS)
    return torch.where(away, _ACROSS, -_ACROSS).expand(layers, -1).clone()
