# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Region matcher based on the trained network."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import MatcherConfig
from fpnet_core.io.weights import read_weights
from fpnet_core.matches import MatchHypothesis, MatchResult
from fpnet_core.matching.consensus import EvidenceModel, find_assignments, rank
from fpnet_core.matching.evidence_model import evidence_model
from fpnet_core.matching.geometry import GraphGeometry, graph_geometry
from fpnet_core.matching.marginals import hypotheses_of, pair_probability
from fpnet_core.matching.thresholds import graded_threshold
from fpnet_core.matching.types import mutual_pairs
from fpnet_core.models.inference import inference_of
from fpnet_core.types import FEATURE_SCHEMA, RegionGraph

Probability = NDArray[np.float64]

_PLANS = 16  # numerical: cached plans, a site's storeys and a mirror image, which take turns

FLOOR = 1e-9
"""Numerical: added to a pair's likelihood before the logarithm."""


@dataclass(frozen=True, eq=False)
class _Known:
    """A graph, and what the network and consensus derive from it alone."""

    graph: RegionGraph
    prepared: Any
    geometry: GraphGeometry


class LearnedMatcher:
    """
    Region matcher with the packaged network, or the checkpoint named by ``config.weights``.

    If the checkpoint contains an evidence model, consensus refines the network's likelihoods;
    otherwise, or with ``settle=False``, they are the result. The matcher caches data derived from
    the latest graphs: a localizer matches growing submaps against the same plan objects (its
    storeys and a mirror image), and one submap against several of them. Not thread-safe; use one
    instance per worker.
    """

    def __init__(self, config: MatcherConfig, settle: bool = True) -> None:
        self._config = config
        weights = read_weights(Path(config.weights) if config.weights else None, FEATURE_SCHEMA)
        self._network = inference_of(weights)
        self._model: EvidenceModel | None = evidence_model(weights) if settle else None
        self._plans: list[_Known] = []  # latest first
        self._sub: _Known | None = None

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        """Return mutual best pairs above the graded threshold; scores are probabilities."""
        if not (len(plan) and len(sub)):
            nothing = np.zeros((len(plan), len(sub)), dtype=np.float32)
            return MatchResult(mutual_pairs(nothing, 0.0), np.zeros(0, np.float32), nothing)
        probability = self.likelihood(plan, sub)
        hypotheses: tuple[MatchHypothesis, ...] = ()
        if self._model is not None:
            sides = self._known(plan).geometry, self._known_sub(sub).geometry
            probability, hypotheses = _settled(probability, *sides, self._model)
        threshold = graded_threshold(len(sub), explored_area_m2, self._config)
        pairs = mutual_pairs(probability, threshold)
        scores = probability[pairs[:, 0], pairs[:, 1]].clip(0.0, 1.0)
        return MatchResult(
            pairs, scores.astype(np.float32), probability.astype(np.float32), hypotheses
        )

    def likelihood(self, plan: RegionGraph, sub: RegionGraph) -> Probability:
        """Return the network's own assignment ``(M, N)`` of two graphs that are not empty."""
        return self._network.likelihood(self._known(plan).prepared, self._known_sub(sub).prepared)

    def _known_sub(self, graph: RegionGraph) -> _Known:
        if self._sub is None or self._sub.graph is not graph:
            self._sub = self._derived(graph)
        return self._sub

    def _derived(self, graph: RegionGraph) -> _Known:
        return _Known(graph, self._network.prepared(graph), graph_geometry(graph))

    def _known(self, graph: RegionGraph) -> _Known:
        """Return the cached data of a plan and mark it as the latest."""
        found = next((plan for plan in self._plans if plan.graph is graph), None)
        if found is None:
            found = self._derived(graph)
        others = [plan for plan in self._plans if plan is not found]
        self._plans = [found, *others][:_PLANS]
        return found


def _settled(
    base: Probability, plan: GraphGeometry, sub: GraphGeometry, model: EvidenceModel
) -> tuple[Probability, tuple[MatchHypothesis, ...]]:
    """Return the probabilities after consensus, and the best complete assignments."""
    assignments = find_assignments(plan, sub, np.log(base + FLOOR))
    assignments, posterior = rank(assignments, model)
    probability = pair_probability(base, assignments, posterior, sub)
    return probability, hypotheses_of(assignments, posterior, plan, sub)
