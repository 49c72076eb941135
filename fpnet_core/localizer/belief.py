# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How sure may one be: from raster agreement to probabilities, over hypotheses and over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Affine2D
from fpnet_core.pose import MapEvidence
from fpnet_core.types import PoseEstimate, Status

_SHORT_M = 20.0  # wall length that ``null_rise`` is stated for
_SHORTEST_M = 5.0  # less wall than this is treated as this much
_PLACES = 1000.0  # square metres times scales that ``null_score`` is stated for


@dataclass(frozen=True, eq=False)
class Belief:
    """Status, the placement it rests on (None while searching) and its probability."""

    status: Status
    best: PoseEstimate | None
    probability: float


def posterior(
    scores: NDArray[np.float64],
    wall_length_m: float,
    places: float,
    config: LocalizerConfig,
    null_slack: float = 0.0,
) -> NDArray[np.float64]:
    """
    Probability of each of ``K`` distinct placements, ``(K,)``; the rest is "none of these".

    Every metre of observed wall is worth ``evidence_per_m`` nats per unit of score, up to
    ``evidence_full_m``: walls of one building are not independent. "None of these" competes
    with the score that a wrong place reaches by chance, less ``null_slack``: ``null_score`` on a
    large submap and ``null_rise`` more on one of 20 m of wall, falling with the root of the
    length. What the best rival reaches on this very plan tells more about chance than any
    constant and weighs ``rival_weight``: a poor score that stands alone is worth more than a good
    one among equals. "None" gains ``null_per_log_place`` nats with every e-fold of ``places``, the
    plan's free area [m^2] times the scales tried: the more places, the better the best wrong one.
    All but ``evidence_full_m`` are fitted by :mod:`fpnet_core.evaluation.calibration`.
    """
    gain = config.evidence_per_m * min(wall_length_m, config.evidence_full_m)
    chance = config.null_score + config.null_rise * np.sqrt(
        _SHORT_M / max(wall_length_m, _SHORTEST_M)
    )
    if len(scores) > 1:
        chance += config.rival_weight * (np.sort(scores)[-2] - chance)
    null = gain * (chance - null_slack)
    null += config.null_per_log_place * np.log(max(places, 1.0) / _PLACES)
    logits = np.append(gain * scores, null)
    weights = np.exp(logits - logits.max())
    return np.asarray(weights[:-1] / weights.sum())


class HypothesisTracker:
    """
    Turns each tick's verified placements into a status; time decides.

    A claim needs the same placement to win ``confirm_ticks`` times in a row with probability
    of at least ``claim_probability``; it is kept until the probability falls below
    ``release_probability``, so that it neither flickers nor outlives its evidence.
    """

    def __init__(self, config: LocalizerConfig, distinct_m: float) -> None:
        self._config = config
        self._distinct_m = distinct_m
        self.reset()

    def reset(self) -> None:
        """Forget everything: new plan, new odometry frame."""
        self._leader: Affine2D | None = None
        self._wins = 0
        self._claimed = False
        self._was_localized = False

    def update(
        self,
        estimates: tuple[PoseEstimate, ...],
        sub: MapEvidence,
        places: float,
        A_submap_odom: Affine2D,
    ) -> Belief:
        """
        Take one tick's placements, best first, and say what may be claimed.

        ``places`` is as in :func:`posterior`; ``A_submap_odom`` anchors the submap, so that
        placements are compared in the odometry frame although the submap may have been
        re-anchored.
        """
        if not estimates:
            return self._nothing_found(0.0)
        best = estimates[0]
        slack = self._config.null_slack if self._claimed else 0.0
        scores = np.array([e.score for e in estimates])
        each = posterior(scores, sub.wall_length_m, places, self._config, slack)
        p = float(each[0])
        if p < 1.0 - each.sum():
            return self._nothing_found(p)
        self._count_win(best.A_plan_submap @ A_submap_odom, sub, A_submap_odom)
        confirmed = self._wins >= self._config.confirm_ticks
        if self._claimed:
            self._claimed = confirmed and p >= self._config.release_probability
        else:
            self._claimed = confirmed and p >= self._config.claim_probability
        self._was_localized |= self._claimed
        return Belief(Status.LOCALIZED if self._claimed else Status.AMBIGUOUS, best, p)

    def _nothing_found(self, p: float) -> Belief:
        self._claimed = False
        self._leader, self._wins = None, 0
        return Belief(Status.LOST if self._was_localized else Status.SEARCHING, None, p)

    def _count_win(self, A_plan_odom: Affine2D, sub: MapEvidence, A_submap_odom: Affine2D) -> None:
        """Count how often in a row this placement has led."""
        same = self._leader is not None and self._agrees(A_plan_odom, sub, A_submap_odom)
        self._wins = self._wins + 1 if same else 1
        self._leader = A_plan_odom

    def _agrees(self, A_plan_odom: Affine2D, sub: MapEvidence, A_submap_odom: Affine2D) -> bool:
        assert self._leader is not None  # the caller has looked
        points = sub.walls if len(sub.walls) else sub.free
        corners = A_submap_odom.inv().apply([points.min(axis=0), points.max(axis=0)])
        moved = np.linalg.norm(A_plan_odom.apply(corners) - self._leader.apply(corners), axis=1)
        return bool(moved.mean() <= self._distinct_m)
