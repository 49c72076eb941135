# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Compare region matchers on the same pairs of graphs, in two stages.

``predict`` runs a method and keeps its predictions; ``score`` computes every figure from them, so
that a new figure needs no new run. A transform is a similarity by RANSAC over the centroids of the
matched regions, as in the paper, unless a method returns its own placements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
import time

import numpy as np

from fpnet_core.geometry import Affine2D
from fpnet_core.matches import IGNORE, MatchResult
from fpnet_core.matching import RegionMatcher
from fpnet_core.types import RegionGraph
from fpnet_lab.baselines.answer import Answer
from fpnet_lab.baselines.matcher_ransac import place_by_ransac
from fpnet_lab.metrics import (
    MatchCounts,
    PlacementError,
    auc,
    count_matches,
    expected_calibration_error,
    matching_score,
    placement_error,
    share,
)
from fpnet_lab.metrics.placement import AUC_DEGREES
from fpnet_lab.sim.pairs.pair import MatchingPair

# Smallest probability of an accepted placement. Chosen.
_CLAIMED = 0.5
# Numerical: untimed calls that fill caches and compile kernels.
_WARM_UP = 3


@dataclass(frozen=True)
class Prediction:
    """Prediction of one method: matches [plan, submap], scores, matrix ``(3, 3)``, time."""

    pairs: list[list[int]]
    scores: list[float]
    matrix: list[list[float]] | None
    is_accepted: bool
    milliseconds: float

    @property
    def placement(self) -> Affine2D | None:
        """Transform from the submap to the plan; None without one."""
        return None if self.matrix is None else Affine2D.from_matrix(np.array(self.matrix))


def predict(
    pairs: Iterable[MatchingPair],
    matchers: Mapping[str, RegionMatcher],
    on_pairs: Callable[[float], None] = lambda count: None,
) -> dict[str, list[Prediction]]:
    """Run every matcher on every pair; return one list per matcher in the order of pairs."""
    said: dict[str, list[Prediction]] = {name: [] for name in matchers}
    for index, pair in enumerate(pairs):
        for name, matcher in matchers.items():
            if index == 0:
                for _ in range(_WARM_UP):
                    matcher.match(pair.plan_graph, pair.sub_graph, pair.explored_area_m2)
            said[name].append(
                predict_one(matcher, pair.plan_graph, pair.sub_graph, pair.explored_area_m2)
            )
        on_pairs(1.0)
    return said


def predict_one(
    matcher: RegionMatcher, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float
) -> Prediction:
    """Return the prediction of ``matcher`` for two graphs; only the match is timed."""
    start = time.perf_counter()
    result = matcher.match(plan, sub, explored_area_m2)
    elapsed_ms = 1e3 * (time.perf_counter() - start)
    placed = _placement(plan, sub, result)
    return Prediction(
        pairs=result.pairs.tolist(),
        scores=result.scores.tolist(),
        matrix=None if placed is None else placed.A_plan_submap.matrix.tolist(),
        is_accepted=placed is not None and placed.is_accepted,
        milliseconds=elapsed_ms,
    )


def _placement(plan: RegionGraph, sub: RegionGraph, result: MatchResult) -> Answer | None:
    if not result.hypotheses:
        return place_by_ransac(plan, sub, result)
    best = result.hypotheses[0]
    return Answer(best.S_plan_sub, best.probability, is_accepted=best.probability >= _CLAIMED)


def score(
    pairs: Sequence[MatchingPair], said: Mapping[str, Sequence[Prediction]]
) -> dict[str, dict[str, float]]:
    """
    Return the figures of every method.

    Fractions in [0, 1]: ``auc1``, ``auc10``, ``auc20``, ``ms`` and ``ts`` as in the paper;
    ``match_precision``, ``match_recall`` and ``match_f1`` pooled over all regions; ``match_ece``,
    the calibration error of match scores; ``recall_1m_10deg`` and ``recall_05m_5deg`` in plan
    metres. ``ms_per_pair`` is the median time of one match in milliseconds.
    """
    return {name: _figures(pairs, items) for name, items in said.items()}


def _figures(pairs: Sequence[MatchingPair], said: Sequence[Prediction]) -> dict[str, float]:
    both = list(zip(pairs, said, strict=True))
    counts = [
        count_matches(np.array(item.pairs, dtype=np.int64).reshape(-1, 2), pair.sub_labels)
        for pair, item in both
    ]
    errors = [
        placement_error(item.placement, pair.A_plan_submap, _middle(pair)) for pair, item in both
    ]
    pooled = sum(counts, MatchCounts(0, 0, 0))
    return {
        **{f'auc{limit}': auc(errors, limit) for limit in AUC_DEGREES},
        'ms': matching_score(counts),
        'ts': share(error.is_transform_right for error in errors) or 0.0,
        'match_precision': pooled.precision,
        'match_recall': pooled.recall,
        'match_f1': pooled.f1,
        'match_ece': _calibration_error(both),
        'recall_1m_10deg': _recall(errors, 1.0, 10.0),
        'recall_05m_5deg': _recall(errors, 0.5, 5.0),
        'ms_per_pair': float(np.median([item.milliseconds for item in said])) if said else 0.0,
    }


def _calibration_error(both: Sequence[tuple[MatchingPair, Prediction]]) -> float:
    """Return the expected calibration error of the match scores."""
    score, right = [], []
    for pair, item in both:
        for (plan, sub), value in zip(item.pairs, item.scores, strict=True):
            if pair.sub_labels[sub] != IGNORE:
                score.append(value)
                right.append(pair.sub_labels[sub] == plan)
    return expected_calibration_error(np.array(score), np.array(right, dtype=np.bool_))


def _recall(errors: Sequence[PlacementError], distance_m: float, rotation_deg: float) -> float:
    return share(error.is_within(distance_m, rotation_deg) for error in errors) or 0.0


def _middle(pair: MatchingPair) -> tuple[float, float]:
    x, y = np.mean([region.centroid for region in pair.sub_graph.regions], axis=0).tolist()
    return x, y
