# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From checked weights to what a matcher asks; of the packaged network without torch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnet_core.graphs.invariant import invariant_rows
from fpnet_core.io.weights import Weights, check_shapes
from fpnet_core.models.arrays import NUMPY
from fpnet_core.models.batch import PreparedBatch, pad_graphs
from fpnet_core.models.config import PaperConfig, network_config
from fpnet_core.models.joint_attention import JointAttention, shapes
from fpnet_core.types import RegionGraph


class Inference(Protocol):
    """A network that says which regions of two graphs are the same."""

    def prepared(self, graph: RegionGraph) -> Any:
        """Return what can be computed of one graph before the other is known."""

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
    Return the network that ``weights`` describe; only the paper's loads torch.

    Raises
    ------
    WeightsError
        If the manifest's network is unknown or its tensors do not fit the network.
    """
    config = network_config(weights)
    if isinstance(config, PaperConfig):
        from fpnet_core.models.loading import load_network
        from fpnet_core.models.tensor_inference import OnTensors

        return OnTensors(load_network(weights))
    check_shapes('weights', weights.tensors, shapes(config))
    # Laid out as products go through them: of small rows they take a third of the time.
    tensors = {name: np.asfortranarray(value) for name, value in weights.tensors.items()}
    return _OnArrays(JointAttention(config, NUMPY, tensors))
