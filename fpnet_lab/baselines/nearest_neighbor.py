# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Nearest-neighbour matching of region descriptors, the paper's first baseline."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.special import softmax

from fpnet_core.config import MatcherConfig
from fpnet_core.graphs.features import LABEL
from fpnet_core.graphs.layout import POSITION
from fpnet_core.matches import MatchResult
from fpnet_core.matching import mutual_pairs
from fpnet_core.types import RegionGraph

# Squared descriptor distance at which the likelihood decays to 1/e; descriptors have unit range.
# Chosen.
_TEMPERATURE = 1.0
# Numerical: added to the squared distance between a door and a room, so that they never match.
_LABEL_PENALTY = 1e4


class NearestNeighborMatcher:
    """
    Matcher of mutual nearest neighbours in descriptor space.

    It compares shape, area, label and confidence, not positions, which are in unrelated frames.
    It returns every mutual pair and ignores the configured threshold, which applies to
    probabilities and not to descriptor distances.
    """

    def __init__(self, config: MatcherConfig) -> None:
        del config  # unused: all matcher factories share one signature

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        """Return mutual nearest pairs; the score decreases with the descriptor distance."""
        del explored_area_m2
        distance = _squared_distances(plan.node_feat, sub.node_feat)
        pairs = mutual_pairs(-distance, -_LABEL_PENALTY)
        similarity = -distance / _TEMPERATURE
        scores = np.exp(similarity[pairs[:, 0], pairs[:, 1]]).astype(np.float32)
        return MatchResult(pairs, scores, _normalised(similarity))


def _normalised(similarity: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the product of both softmaxes ``(M, N)``: row and column sums are at most one."""
    if similarity.size == 0:
        return similarity.astype(np.float32)
    product = softmax(similarity, axis=0) * softmax(similarity, axis=1)
    return np.asarray(product, dtype=np.float32)


def _squared_distances(plan: NDArray[np.float32], sub: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return squared descriptor distances ``(M, N)``, with a penalty between door and room."""
    distance: NDArray[np.float64] = cdist(
        plan[:, POSITION.stop :], sub[:, POSITION.stop :], 'sqeuclidean'
    )
    same = (plan[:, LABEL] @ sub[:, LABEL].T) > 0.0
    return np.where(same, distance, distance + _LABEL_PENALTY)
