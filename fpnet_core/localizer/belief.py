# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What may be claimed: from each look's probabilities to a status; time decides."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Affine2D, Placement, Placements
from fpnet_core.judging import Judge, Look, Verdict, reason_of
from fpnet_core.localizer.search import NEWS_GROWTH
from fpnet_core.pose import MapEvidence, compared_at
from fpnet_core.pose.estimate import DISTINCT_M
from fpnet_core.types import Status

_MIRROR_LOG_ODDS = 6.9  # nats: a prior, one drawing in a thousand is a mirror image; chosen

_MIRROR_WINS = 2  # looks in a row at which the mirror image would have been claimed; chosen


@dataclass(frozen=True, eq=False)
class Belief:
    """
    Status, the placement it rests on (None while searching) and its probability.

    ``reason`` says why, in one sentence; ``is_mirrored`` that it is because what was seen fits the
    plan's mirror image only. ``judged`` are all placements that the status was decided on, with
    their probabilities. ``bend_m`` is how far the drawing had to bend under the best one.
    """

    status: Status
    best: Placement | None
    probability: float
    reason: str
    is_mirrored: bool = False
    judged: Placements = field(default_factory=Placements.empty)
    bend_m: float = 0.0


class HypothesisTracker:
    """
    Turns each tick's verdict into a status; time decides.

    A claim needs the same placement to win ``confirm_ticks`` times in a row with probability
    of at least ``claim_probability``, and a look at the plan's mirror image; it is kept until the
    probability falls below ``release_probability``, so that it neither flickers nor outlives its
    evidence. What a robot sees again from where it stands confirms nothing, however often it
    looks: between two wins that count the submap must have grown, unless the caller knows better.
    """

    def __init__(
        self, config: LocalizerConfig, judge: Judge, distinct_m: float = DISTINCT_M
    ) -> None:
        self._config = config
        self._judge = judge
        self._distinct_m = distinct_m
        self.reset()

    def reset(self) -> None:
        """Forget everything: new plan, new odometry frame."""
        self._leader: Affine2D | None = None
        self._wins = 0
        self._sure_wins = 0
        self._sure_of = np.zeros(2)  # walls [m] and free space [m^2] of the last sure win
        self._probability = 0.0
        self._claimed = False
        self._was_localized = False
        self._mirrored: Verdict | None = None
        self._mirror_wins = 0
        self._ticks_since_mirror = 0

    @property
    def is_settled(self) -> bool:
        """Tell whether a claim stands, and as firmly as it was made."""
        return self._claimed and self._probability >= self._config.claim_probability

    @property
    def wants_mirror(self) -> bool:
        """Tell whether the next tick should look at the plan's mirror image, too."""
        if self._claimed:
            return False
        soon = self._sure_wins + 1 >= self._config.confirm_ticks
        near_claim = soon and self._probability >= self._config.release_probability
        return near_claim or self._ticks_since_mirror + 1 >= self._config.mirror_check_ticks

    def update(
        self,
        verdict: Verdict,
        sub: MapEvidence,
        A_submap_odom: Affine2D,
        mirrored: Verdict | None = None,
        robot_xy: NDArray[np.float64] | None = None,
        needs_news: bool = False,
        scales: tuple[float, float] = (0.0, np.inf),
    ) -> Belief:
        """
        Take one tick's verdict and say what may be claimed.

        ``mirrored`` is that on the plan's mirror image, None where nobody looked;
        ``A_submap_odom`` anchors the submap, so that placements are compared in the odometry frame
        although the submap may have been re-anchored. ``robot_xy (2,)`` is where the robot is in
        the submap; ``needs_news`` asks for a grown submap between the ticks that confirm a claim;
        ``scales`` are the smallest and largest mean scale that a placement might have.
        """
        self._count_mirror(verdict, mirrored)
        # Between two looks the mirror image is as good as it was at the last one.
        if self._mirrored is not None and not self._claimed:
            verdict = self._judge.against_mirror(verdict, self._mirrored, _MIRROR_LOG_ODDS)
        judged, p = verdict.placements, verdict.best
        self._probability = p
        at, claim = compared_at(sub, robot_xy), self._config.claim_probability
        is_mirrored = len(judged) > 0 and self._mirror_wins >= _MIRROR_WINS
        look = Look(sub.wall_length_m, claim, at, scales, is_mirrored=is_mirrored)
        if not judged or is_mirrored or p < verdict.none + verdict.foreign:
            return self._nothing_found(verdict, look)
        best = judged[0]
        points_odom = A_submap_odom.inv().apply(at)
        self._count_win(best.A_plan_submap @ A_submap_odom, points_odom)
        self._count_sure_win(p >= claim, sub, needs_news)
        needed = self._config.confirm_ticks
        if self._claimed:
            self._claimed = self._wins >= needed and p >= self._config.release_probability
        else:
            self._claimed = self._sure_wins >= needed and mirrored is not None
        self._was_localized |= self._claimed
        status = Status.LOCALIZED if self._claimed else Status.AMBIGUOUS
        look = replace(
            look,
            is_claimed=self._claimed,
            sure_looks=self._sure_wins,
            missing_looks=max(needed - self._sure_wins, 0),
            needs_news=needs_news,
        )
        bend_m = float(verdict.evidence.of('bend_m')[0])
        return Belief(status, best, p, reason_of(verdict, look), judged=judged, bend_m=bend_m)

    def _count_mirror(self, verdict: Verdict, mirrored: Verdict | None) -> None:
        """Count how often in a row the mirror image would have been claimed."""
        self._ticks_since_mirror += 1
        if mirrored is None:
            return
        self._ticks_since_mirror, self._mirrored = 0, mirrored
        contest = self._judge.against_mirror(mirrored, verdict, 0.0)
        is_better = contest.best >= self._config.claim_probability
        self._mirror_wins = self._mirror_wins + 1 if is_better else 0

    def _nothing_found(self, verdict: Verdict, look: Look) -> Belief:
        self._claimed = False
        self._leader, self._wins, self._sure_wins = None, 0, 0
        status = Status.LOST if self._was_localized else Status.SEARCHING
        why = reason_of(verdict, look)
        return Belief(status, None, verdict.best, why, look.is_mirrored, verdict.placements)

    def _count_win(self, A_plan_odom: Affine2D, points_odom: NDArray[np.float64]) -> None:
        """Count how often in a row this placement has led, as far as ``points_odom`` tell."""
        is_same = False
        if self._leader is not None:
            apart = A_plan_odom.apply(points_odom) - self._leader.apply(points_odom)
            is_same = bool(np.linalg.norm(apart, axis=1).mean() <= self._distinct_m)
        self._wins = self._wins + 1 if is_same else 1
        self._leader = A_plan_odom

    def _count_sure_win(self, is_sure: bool, sub: MapEvidence, needs_news: bool) -> None:
        """Count how often in a row the leader was sure, each time of more than the last."""
        # A new leader has won once, whatever the one before it did.
        before = self._sure_wins if is_sure and self._wins > 1 else 0
        seen = np.array([sub.wall_length_m, sub.free_area_m2])
        if before and needs_news and (seen < NEWS_GROWTH * self._sure_of).all():
            return
        self._sure_wins, self._sure_of = before + int(is_sure), seen
