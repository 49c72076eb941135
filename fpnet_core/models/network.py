# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Common interface of the networks: conversion of graphs to inputs, and outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from torch import Tensor, nn

from fpnet_core.graphs.layout import FeatureLayout
from fpnet_core.models.batch import GraphBatch, pad_graphs
from fpnet_core.models.tensors import tensors_of
from fpnet_core.types import RegionGraph


class RegionNetwork(nn.Module, ABC):
    """Network from two batches of graphs to log-assignments ``(B, M+1, N+1)``, dustbins last."""

    layout: ClassVar[FeatureLayout]

    @staticmethod
    @abstractmethod
    def rows(graph: RegionGraph) -> NDArray[np.float32]:
        """Return the node rows ``(R, layout.size)`` that the network takes."""

    def batch(self, graphs: Sequence[RegionGraph]) -> GraphBatch:
        """Return the graphs as one padded batch of tensors."""
        rows = [self.rows(graph) for graph in graphs]
        return tensors_of(pad_graphs(rows, [graph.edges for graph in graphs]))

    def assignments(self, plan: GraphBatch, sub: GraphBatch) -> list[Tensor]:
        """Return every log-assignment that training supervises, the final one last."""
        return [self(plan, sub)]
