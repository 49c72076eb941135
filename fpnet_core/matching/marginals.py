# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Probabilities of region pairs and complete assignments from scored placements."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Similarity2D
from fpnet_core.matches import MatchHypothesis
from fpnet_core.matching.consensus import Assignments
from fpnet_core.matching.geometry import GraphGeometry

Array = NDArray[np.float64]

MAX_HYPOTHESES = 8
"""Numerical: number of complete assignments in a result."""

# Share of correct pairs under a correct placement, by fit: constant and slope. Chosen: estimated
# once from generated buildings; no command reproduces it.
_DOOR_CONFIDENCE, _ROOM_CONFIDENCE = (0.45, 1.1), (0.87, 0.11)


def pair_probability(
    base: Array, assignments: Assignments, posterior: Array, sub: GraphGeometry
) -> Array:
    """
    Return ``(M, N)``: each pair's probability, marginalized over placements and the null.

    Parameters
    ----------
    base : (M, N) probability of each pair if no placement is correct; row and column sums up to 1
    assignments, posterior : ``C`` placements and their probabilities
    sub : distinguishes doors from rooms, whose pairs are correct at different rates
    """
    constant, slope = np.where(sub.is_door[:, None], _DOOR_CONFIDENCE, _ROOM_CONFIDENCE).T
    confidence = np.clip(constant + slope * assignments.fit, 0.0, 1.0)
    probability = base * max(0.0, 1.0 - float(posterior.sum()))
    for partner, sure, share in zip(assignments.partner, confidence, posterior, strict=True):
        matched = np.flatnonzero(partner >= 0)
        probability[partner[matched], matched] += share * sure[matched]
    return probability


def hypotheses_of(
    assignments: Assignments, posterior: Array, plan: GraphGeometry, sub: GraphGeometry
) -> tuple[MatchHypothesis, ...]:
    """Return the most probable assignments, in the graphs' own coordinates."""
    best = assignments.take(np.arange(min(MAX_HYPOTHESES, len(assignments))))
    return tuple(
        _hypothesis(similarity, best.partner[k], posterior[k], plan, sub)
        for k, similarity in enumerate(best.similarity)
    )


def _hypothesis(
    similarity: Array,
    partner: NDArray[np.int64],
    probability: float,
    plan: GraphGeometry,
    sub: GraphGeometry,
) -> MatchHypothesis:
    a, b = similarity[:2] * (plan.unit / sub.unit)
    linear = np.array([[a, -b], [b, a]])
    translation = plan.origin + plan.unit * similarity[2:] - linear @ sub.origin
    matched = np.flatnonzero(partner >= 0)
    pairs = np.stack([partner[matched], matched], axis=1)
    return MatchHypothesis(pairs, float(probability), Similarity2D(linear, translation))
