# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The trained network as a region matcher; importing this module loads torch."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
import torch

from fpnet_core.config import MatcherConfig
from fpnet_core.io.weights import read_weights
from fpnet_core.matches import MatchHypothesis, MatchResult
from fpnet_core.matching.consensus import EvidenceModel, find_assignments, rank
from fpnet_core.matching.evidence_model import evidence_model
from fpnet_core.matching.geometry import GraphGeometry, graph_geometry
from fpnet_core.matching.marginals import hypotheses_of, pair_probability
from fpnet_core.matching.thresholds import graded_threshold
from fpnet_core.matching.types import mutual_pairs
from fpnet_core.models import GraphBatch, load_network
from fpnet_core.types import FEATURE_SCHEMA, RegionGraph

Probability = NDArray[np.float64]

FLOOR = 1e-9
"""Numerical: added to a pair's likelihood before the logarithm."""


class LearnedMatcher:
    """
    Region matcher on the packaged network, or on the checkpoint that ``config.weights`` names.

    Where the checkpoint brings a model of geometric evidence, the network's likelihoods are
    settled by consensus; else, or with ``settle=False``, they are the answer. Keeps what it
    derived from the latest plan graph: a localizer matches growing submaps against the same plan
    object. Not thread-safe; one instance per worker.
    """

    def __init__(self, config: MatcherConfig, settle: bool = True) -> None:
        self._config = config
        weights = read_weights(Path(config.weights) if config.weights else None, FEATURE_SCHEMA)
        self._network = load_network(weights)
        self._model: EvidenceModel | None = evidence_model(weights) if settle else None
        self._plan: RegionGraph | None = None
        self._plan_batch: GraphBatch | None = None
        self._plan_geometry: GraphGeometry | None = None

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        """Return mutual best pairs above the graded threshold, scores are probabilities."""
        if not (len(plan) and len(sub)):
            nothing = np.zeros((len(plan), len(sub)), dtype=np.float32)
            return MatchResult(mutual_pairs(nothing, 0.0), np.zeros(0, np.float32), nothing)
        probability = self.likelihood(plan, sub)
        hypotheses: tuple[MatchHypothesis, ...] = ()
        if self._model is not None:
            probability, hypotheses = self._settled(probability, sub, self._model)
        threshold = graded_threshold(len(sub), explored_area_m2, self._config)
        pairs = mutual_pairs(probability, threshold)
        scores = probability[pairs[:, 0], pairs[:, 1]].clip(0.0, 1.0)
        return MatchResult(
            pairs, scores.astype(np.float32), probability.astype(np.float32), hypotheses
        )

    def likelihood(self, plan: RegionGraph, sub: RegionGraph) -> Probability:
        """Return the network's own assignment ``(M, N)`` of two graphs that are not empty."""
        with _one_thread(), torch.inference_mode():
            plan_batch = self._batch_of(plan)
            log_assignment = self._network(plan_batch, self._network.batch([sub]))
            probability: Probability = log_assignment[0, :-1, :-1].double().exp().numpy()
        return probability

    def _batch_of(self, plan: RegionGraph) -> GraphBatch:
        if self._plan is not plan or self._plan_batch is None:
            self._plan_batch = self._network.prepared(self._network.batch([plan]))
            self._plan = plan
            self._plan_geometry = graph_geometry(plan)
        return self._plan_batch

    def _settled(
        self, base: Probability, sub: RegionGraph, model: EvidenceModel
    ) -> tuple[Probability, tuple[MatchHypothesis, ...]]:
        """Return the probabilities after consensus, and the best complete assignments."""
        assert self._plan_geometry is not None
        plan_side, sub_side = self._plan_geometry, graph_geometry(sub)
        log_p = np.log(base + FLOOR)
        assignments = find_assignments(plan_side, sub_side, log_p)
        assignments, posterior = rank(assignments, model)
        probability = pair_probability(base, assignments, posterior, sub_side)
        return probability, hypotheses_of(assignments, posterior, plan_side, sub_side)


@contextmanager
def _one_thread() -> Iterator[None]:
    """
    Let tensor operations run on the calling thread.

    The graphs are too small to gain from more, and a team of threads waits at every operation for
    its last one: beside other busy programs a match took many times as long.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
