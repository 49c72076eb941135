# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inference with checked weights; the packaged network does not need torch."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import WeightsError
from fpnet_core.graphs.invariant import invariant_rows
from fpnet_core.io.weights import Weights, check_shapes
from fpnet_core.models.arrays import NUMPY
from fpnet_core.models.batch import PreparedBatch, pad_graphs
from fpnet_core.models.config import PaperConfig, network_config
from fpnet_core.models.joint_attention import JointAttention, shapes
from fpnet_core.types import RegionGraph


class Inference(Protocol):
    """Network that assigns regions of two graphs to each other."""

    def prepared(self, graph: RegionGraph) -> Any:
        """Return the part of the computation that depends on one graph only."""

    def likelihood(self, plan: Any, sub: Any) -> NDArray[np.float64]:
        """Return the assignment ``(M, N)`` of prepared graphs; neither is empty."""


@dataclass(frozen=True, eq=False)
class _OnArrays:
    network: JointAttention

    def prepared(self, graph: RegionGraph) -> PreparedBatch:
        return self.network.prepared(pad_graphs([invariant_rows(graph)], [graph.edges]))

    def likelihood(self, plan: PreparedBatch, sub: PreparedBatch) -> NDArray[np.float64]:
        log_assignment = self.network.log_assignment(plan, sub)
        return np.asarray(np.exp(log_assignment[0, :-1, :-1].astype(np.float64)))


def inference_of(weights: Weights) -> Inference:
    """
    Return the network that ``weights`` describe; only the paper's imports torch.

    Raises
    ------
    WeightsError
        If the manifest's network is unknown, its tensors do not fit the network or it needs
        PyTorch, which is not installed.
    """
    config = network_config(weights)
    if isinstance(config, PaperConfig):
        if find_spec('torch') is None:
            raise WeightsError("the paper's network needs torch: pip install 'fpnet_ros[train]'")
        from fpnet_core.models.loading import load_network
        from fpnet_core.models.tensor_inference import OnTensors

        return OnTensors(load_network(weights))
    check_shapes('weights', weights.tensors, shapes(config))
    # Column-major weights reduce the time of products with few rows to a third.
    tensors = {name: np.asfortranarray(value) for name, value in weights.tensors.items()}
    return _OnArrays(JointAttention(config, NUMPY, tensors))
