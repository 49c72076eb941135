# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fit of the consensus evidence model to placements of pairs with known truth."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import logsumexp

from fpnet_core.config import MatcherConfig
from fpnet_core.geometry import Affine2D, angle_between
from fpnet_core.io.weights import read_weights, write_weights
from fpnet_core.matching.consensus import (
    EVIDENCE,
    Assignments,
    EvidenceModel,
    find_assignments,
)
from fpnet_core.matching.evidence_model import evidence_entry
from fpnet_core.matching.geometry import GraphGeometry, graph_geometry
from fpnet_core.matching.learned import FLOOR, LearnedMatcher
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.sim.pairs.pair import MatchingPair

Array = NDArray[np.float64]

RIGHT_RAD = float(np.deg2rad(8.0))
RIGHT_UNITS = 2.0
RIGHT_LOG_SCALE = 0.12
"""Largest errors of a right placement: refinement converges from there. Chosen."""

_REGULARISATION = 1e-3  # chosen


@dataclass(frozen=True, eq=False)
class PlacementExample:
    """Evidence ``(C, K)`` of one pair's placements, and which are right ``(C,) bool``."""

    evidence: Array
    is_right: NDArray[np.bool_]


def calibrate(
    weights: Path | None,
    pairs: Iterable[MatchingPair],
    out: Path,
    facts: Mapping[str, Any] | None = None,
) -> EvidenceModel:
    """
    Fit the model to held-back ``pairs`` and write it with the network's weights to ``out``.

    Parameters
    ----------
    weights : of the network; None: the packaged ones
    pairs : of buildings that the network was not trained on
    out : weights and manifest; may be ``weights``
    facts : about the pairs, for the manifest's entry ``evidence_data``

    Returns
    -------
    The model. It needs pairs of buildings that the network was not trained on, because the network
    is less confident there, as in use.
    """
    network = read_weights(weights, FEATURE_SCHEMA)
    matcher = LearnedMatcher(MatcherConfig(weights=str(weights or '')), settle=False)
    model = fit_evidence_model([_example(matcher, pair) for pair in pairs])
    replaced = {'sha256', 'schema', 'tensors', 'evidence', 'evidence_data'}
    said = {key: value for key, value in network.manifest.items() if key not in replaced}
    said['evidence'] = evidence_entry(model)
    if facts is not None:
        said['evidence_data'] = dict(facts)
    write_weights(out, network.tensors, FEATURE_SCHEMA, said)
    return model


def _example(matcher: LearnedMatcher, pair: MatchingPair) -> PlacementExample:
    likelihood = matcher.likelihood(pair.plan_graph, pair.sub_graph)
    plan, sub = graph_geometry(pair.plan_graph), graph_geometry(pair.sub_graph)
    assignments = find_assignments(plan, sub, np.log(likelihood + FLOOR))
    return PlacementExample(
        assignments.evidence, score_assignments(assignments, plan, sub, pair.A_plan_submap)
    )


def score_assignments(
    assignments: Assignments, plan: GraphGeometry, sub: GraphGeometry, A_plan_submap: Affine2D
) -> NDArray[np.bool_]:
    """Return ``(C,)``: whether placements agree with the true transform at the submap's centre."""
    a, b = assignments.similarity[:, 0], assignments.similarity[:, 1]
    linear = A_plan_submap.linear * (sub.unit / plan.unit)
    middle = (A_plan_submap.apply(sub.origin) - plan.origin) / plan.unit
    turn = angle_between(np.arctan2(b, a), A_plan_submap.heading)
    log_scale = 0.5 * np.log((a**2 + b**2) / abs(np.linalg.det(linear)))
    moved = np.linalg.norm(assignments.similarity[:, 2:] - middle, axis=1)
    near = (turn < RIGHT_RAD) & (np.abs(log_scale) < RIGHT_LOG_SCALE)
    return np.asarray(near & (moved < RIGHT_UNITS))


def fit_evidence_model(examples: Sequence[PlacementExample]) -> EvidenceModel:
    """
    Return the weights that maximize the likelihood of right placements, or of their absence.

    This is a conditional logit: the softmax over a pair's placements and "none" is its posterior.
    Its likelihood is concave in the weights if one alternative is right. Pairs without placements
    are ignored. The signs of the weights are not constrained.
    """
    used = [example for example in examples if len(example.is_right)]
    spread = np.concatenate([e.evidence for e in used]).std(axis=0) + 1e-6

    def objective(parameters: Array) -> tuple[float, Array]:
        loss = _REGULARISATION * float(parameters @ parameters)
        gradient = 2.0 * _REGULARISATION * parameters
        for example in used:
            part, slope = negative_log_likelihood(example, parameters, spread)
            loss += part / len(used)
            gradient += slope / len(used)
        return loss, gradient

    result = minimize(objective, np.zeros(len(EVIDENCE) + 1), jac=True, method='L-BFGS-B')
    return EvidenceModel(result.x[:-1] / spread, float(result.x[-1]))


def negative_log_likelihood(
    example: PlacementExample, parameters: Array, spread: Array
) -> tuple[float, Array]:
    """Return loss and gradient of one pair; the last alternative is "none"."""
    features = np.zeros((len(example.is_right) + 1, len(parameters)))
    features[:-1, :-1] = example.evidence / spread
    features[-1, -1] = 1.0
    right = np.append(example.is_right, not example.is_right.any())
    scores = features @ parameters
    loss = float(logsumexp(scores) - logsumexp(scores[right]))
    share = np.exp(scores - logsumexp(scores))
    share_right = np.where(right, np.exp(scores - logsumexp(scores[right])), 0.0)
    gradient: Array = (share - share_right) @ features
    return loss, gradient
