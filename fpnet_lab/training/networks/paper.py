# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trainable parameters of the paper's network, and their initialisation."""

from __future__ import annotations

import itertools

import torch
from torch import nn

from fpnet_core.models.config import PaperConfig
from fpnet_core.models.paper import DESCRIPTOR_FEATURES, POSE_FEATURES
from fpnet_lab.training.networks.modules import RegionModule


class PaperModule(RegionModule):
    """Parameters of :class:`~fpnet_core.models.paper.PaperNetwork`."""

    config: PaperConfig

    def __init__(self, config: PaperConfig) -> None:
        super().__init__()
        self.config = config
        self.encoder = _GraphEncoder(config)
        self.self_layers, self.cross_layers = (
            nn.ModuleList(_Propagation(config.width) for _ in range(config.blocks))
            for _ in range(2)
        )
        self.project = nn.Linear(config.width, config.width)
        self.dustbin = nn.Parameter(torch.ones(()))


class _GraphEncoder(nn.Module):
    def __init__(self, config: PaperConfig) -> None:
        super().__init__()
        widths = [POSE_FEATURES, *config.position_widths]
        layers: list[nn.Module] = []
        for before, after in itertools.pairwise(widths):
            layers += [nn.Linear(before, after), nn.LayerNorm(after), nn.ReLU()]
        layers.append(nn.Linear(widths[-1], config.width))
        self.position = nn.Sequential(*layers)
        is_direct = config.width == DESCRIPTOR_FEATURES
        self.descriptor = (
            nn.Identity() if is_direct else nn.Linear(DESCRIPTOR_FEATURES, config.width)
        )


class _Attention(nn.Module):
    def __init__(self, width: int) -> None:
        super().__init__()
        self.query = nn.Linear(width, width)
        self.key_value = nn.Linear(width, 2 * width)
        self.merge = nn.Linear(width, width)


class _Propagation(nn.Module):
    """One layer; the last map starts at zero: all layers of an identity train from the start."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.attention = _Attention(width)
        last = nn.Linear(2 * width, width)
        nn.init.zeros_(last.weight)
        nn.init.zeros_(last.bias)
        self.update = nn.Sequential(
            nn.Linear(2 * width, 2 * width), nn.LayerNorm(2 * width), nn.ReLU(), last
        )
