# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The trained network as a region matcher; importing this module loads torch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
import torch

from fpnet_core.config import MatcherConfig
from fpnet_core.io.weights import read_weights
from fpnet_core.matching.thresholds import graded_threshold
from fpnet_core.matching.types import mutual_pairs
from fpnet_core.models import GraphBatch, batch_graphs, load_network
from fpnet_core.types import FEATURE_SCHEMA, MatchResult, RegionGraph


class LearnedMatcher:
    """
    Region matcher on the packaged network, or on the checkpoint that ``config.weights`` names.

    Keeps the tensors of the latest plan graph: a localizer matches growing submaps against the
    same plan object. Not thread-safe; one instance per worker.
    """

    def __init__(self, config: MatcherConfig) -> None:
        self._config = config
        path = Path(config.weights) if config.weights else None
        self._network = load_network(read_weights(path, FEATURE_SCHEMA))
        self._plan: RegionGraph | None = None
        self._plan_batch: GraphBatch | None = None

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        """Return mutual best pairs above the graded threshold, scores are probabilities."""
        probability = self._probability(plan, sub)
        threshold = graded_threshold(len(sub), explored_area_m2, self._config)
        pairs = mutual_pairs(probability, threshold)
        scores = probability[pairs[:, 0], pairs[:, 1]]
        return MatchResult(pairs, scores.clip(0.0, 1.0), probability)

    def _probability(self, plan: RegionGraph, sub: RegionGraph) -> NDArray[np.float32]:
        if not (len(plan) and len(sub)):
            return np.zeros((len(plan), len(sub)), dtype=np.float32)
        if self._plan is not plan or self._plan_batch is None:
            self._plan, self._plan_batch = plan, batch_graphs([plan])
        with torch.inference_mode():
            log_assignment = self._network(self._plan_batch, batch_graphs([sub]))
            probability: NDArray[np.float32] = log_assignment[0, :-1, :-1].exp().numpy()
        return probability
