# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The matching network (paper, section IV), written from the paper's equations."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray
import torch
from torch import Tensor, nn

from fpnet_core.graphs.features import CONFIDENCE, NODE_FEATURES, PAPER_LAYOUT
from fpnet_core.graphs.layout import POSITION
from fpnet_core.models.attention import Propagation
from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.config import PaperConfig
from fpnet_core.models.edges import edge_weights
from fpnet_core.models.network import RegionNetwork
from fpnet_core.models.sinkhorn import log_assignment
from fpnet_core.types import RegionGraph

_POSE_FEATURES = CONFIDENCE.stop
_DESCRIPTOR_FEATURES = NODE_FEATURES - POSITION.stop


class GraphEncoder(nn.Module):
    """
    Initial node states ``h = MLP(p) + d`` (paper, eq. 2).

    ``p`` is (x, y, confidence), ``d`` the 26 features that are not position. Confidence is in
    both, which makes the paper's 28 features consistent with its width of 26. Another width needs
    a linear map of ``d``; the paper's own width does not.
    """

    def __init__(self, config: PaperConfig) -> None:
        super().__init__()
        widths = [_POSE_FEATURES, *config.position_widths]
        layers: list[nn.Module] = []
        for before, after in itertools.pairwise(widths):
            layers += [nn.Linear(before, after), nn.LayerNorm(after), nn.ReLU()]
        layers.append(nn.Linear(widths[-1], config.width))
        self.position = nn.Sequential(*layers)
        self.descriptor = (
            nn.Identity()
            if config.width == _DESCRIPTOR_FEATURES
            else nn.Linear(_DESCRIPTOR_FEATURES, config.width)
        )

    def forward(self, node_feat: Tensor) -> Tensor:
        """Encode ``(B, R, 28)`` to ``(B, R, width)``."""
        state: Tensor = self.position(node_feat[..., :_POSE_FEATURES]) + self.descriptor(
            node_feat[..., POSITION.stop :]
        )
        return state


class PaperNetwork(RegionNetwork):
    """The paper's network; without an edge function it is the backbone that the paper extends."""

    layout = PAPER_LAYOUT

    @staticmethod
    def rows(graph: RegionGraph) -> NDArray[np.float32]:
        """Return the graph's own 28 features."""
        return graph.node_feat

    def __init__(self, config: PaperConfig) -> None:
        super().__init__()
        self.config = config
        self.encoder = GraphEncoder(config)
        self.self_layers = nn.ModuleList(
            Propagation(config.width, config.heads) for _ in range(config.blocks)
        )
        self.cross_layers = nn.ModuleList(
            Propagation(config.width, config.heads) for _ in range(config.blocks)
        )
        self.project = nn.Linear(config.width, config.width)
        self.dustbin = nn.Parameter(torch.ones(()))

    def forward(self, plan: GraphBatch, sub: GraphBatch) -> Tensor:
        """
        Return the log-assignment ``(B, M+1, N+1)`` (see :func:`log_assignment`).

        Equivariant to permutations of the nodes of either side.
        """
        plan_state, sub_state = self.describe(plan, sub)
        # Scaled so that scores start at about unit variance for any width.
        scores = plan_state @ sub_state.transpose(-1, -2) / math.sqrt(self.config.width)
        return log_assignment(
            scores, self.dustbin, plan.mask, sub.mask, self.config.sinkhorn_iterations
        )

    def describe(self, plan: GraphBatch, sub: GraphBatch) -> tuple[Tensor, Tensor]:
        """Return matching descriptors ``(B, M, width)`` and ``(B, N, width)`` (paper, eq. 8)."""
        plan_state, sub_state = self.encoder(plan.node_feat), self.encoder(sub.node_feat)
        plan_phi = edge_weights(self.config.edge_mapping, plan)
        sub_phi = edge_weights(self.config.edge_mapping, sub)
        for within, across in zip(self.self_layers, self.cross_layers, strict=True):
            plan_state = within(plan_state, plan_state, plan.mask, plan_phi)
            sub_state = within(sub_state, sub_state, sub.mask, sub_phi)
            plan_state, sub_state = (
                across(plan_state, sub_state, sub.mask),
                across(sub_state, plan_state, plan.mask),
            )
        return self.project(plan_state), self.project(sub_state)
