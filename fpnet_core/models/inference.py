# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inference with checked weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnet_core.graphs.layout import FeatureLayout
from fpnet_core.io.weights import Weights, check_shapes
from fpnet_core.models.arrays import NUMPY, Array, Library
from fpnet_core.models.batch import GraphBatch, pad_graphs
from fpnet_core.models.config import NetworkConfig, PaperConfig, network_config
from fpnet_core.models.joint_attention import JointAttention
from fpnet_core.models.paper import PaperNetwork
from fpnet_core.types import RegionGraph


class RegionNetwork(Protocol):
    """Network that assigns the regions of two graphs, on arrays or tensors."""

    layout: ClassVar[FeatureLayout]

    @staticmethod
    def rows(graph: RegionGraph) -> NDArray[np.float32]:
        """Return the node rows ``(R, layout.size)`` that the network takes."""

    def prepared(self, batch: GraphBatch) -> Any:
        """Return the part of the computation that depends on one batch only."""

    def log_assignment(self, plan: Any, sub: Any) -> Array:
        """Return the log-assignment ``(B, M+1, N+1)`` of prepared batches, dustbins last."""

    def assignments(self, plan: Any, sub: Any) -> list[Array]:
        """Return every log-assignment that training supervises, the final one last."""


def network_type(config: NetworkConfig) -> type[RegionNetwork]:
    """Return the type of the network of ``config``."""
    return PaperNetwork if isinstance(config, PaperConfig) else JointAttention


def network_of(
    config: NetworkConfig, library: Library, parameters: Mapping[str, Array]
) -> RegionNetwork:
    """Return the network of ``config`` on arrays of ``library``."""
    if isinstance(config, PaperConfig):
        return PaperNetwork(config, library, parameters)
    return JointAttention(config, library, parameters)


def parameter_shapes(config: NetworkConfig) -> dict[str, tuple[int, ...]]:
    """Return the shape of every parameter of the network of ``config``."""
    if isinstance(config, PaperConfig):
        return PaperNetwork.shapes(config)
    return JointAttention.shapes(config)


@dataclass(frozen=True, eq=False)
class Inference:
    """Network that assigns regions of two graphs to each other."""

    network: RegionNetwork

    def prepared(self, graph: RegionGraph) -> Any:
        """Return the part of the computation that depends on one graph only."""
        return self.network.prepared(pad_graphs([self.network.rows(graph)], [graph.edges]))

    def likelihood(self, plan: Any, sub: Any) -> NDArray[np.float64]:
        """Return the assignment ``(M, N)`` of prepared graphs; neither is empty."""
        log_assignment = self.network.log_assignment(plan, sub)
        return np.asarray(np.exp(log_assignment[0, :-1, :-1].astype(np.float64)))


def inference_of(weights: Weights) -> Inference:
    """
    Return the network that ``weights`` describe.

    Raises
    ------
    WeightsError
        If the manifest's network is unknown or its tensors do not fit the network.
    """
    config = network_config(weights)
    check_shapes('weights', weights.tensors, parameter_shapes(config))
    # Column-major weights reduce the time of products with few rows to a third.
    tensors = {name: np.asfortranarray(value) for name, value in weights.tensors.items()}
    return Inference(network_of(config, NUMPY, tensors))
