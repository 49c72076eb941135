# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What may be claimed: from each look's probabilities to a status; time decides."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logit

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import Affine2D, Placement, Placements
from fpnet_core.judging import Circumstances, Judge, Verdict, reason_of
from fpnet_core.pose import MapEvidence, compared_at
from fpnet_core.pose.estimate import DISTINCT_M
from fpnet_core.submaps.recent import RECENT_M
from fpnet_core.types import Status

_MIRROR_LOG_ODDS = 5.3  # nats: a prior, one drawing in two hundred is a mirror image; chosen

_NEWS_M2 = 5.0
"""
Chosen: a look confirms the last sure one with so much more floor in sight, as much as the smallest
rooms have (``benchmarks/claim_rules.py``). Walls do not count: they fill in as a robot stands.
"""

_MIRROR_WINS = 2  # looks in a row at which the mirror image would have been claimed; chosen


@dataclass(frozen=True, eq=False)
class Belief:
    """
    Status, the placement it rests on (None while searching) and its probability.

    ``reason`` says why, in one sentence; ``is_mirrored`` that it is because what was seen fits the
    plan's mirror image only. ``judged`` are all placements that the status was decided on, with
    their probabilities. ``bend_m`` is how far the drawing had to bend under the best one, and
    ``residual_m`` how far three quarters of the walls lie off drawn ones at most.
    """

    status: Status
    best: Placement | None
    probability: float
    reason: str
    is_mirrored: bool = False
    judged: Placements = field(default_factory=Placements.empty)
    bend_m: float = 0.0
    residual_m: float = 0.0


@dataclass(frozen=True, eq=False)
class Standing:
    """
    Where the ticks so far have led; plain values, from which the next tick goes on.

    Parameters
    ----------
    leader
        ``A_plan_odom`` of the last tick's best placement; None where there was none.
    wins
        Ticks in a row that it has led.
    sure_wins
        Those of them that were sure, each of more than the one before.
    sure_of_m2
        Free space seen at the last one of these.
    probability
        The leader's at the last tick.
    is_claimed, was_localized
        A claim stands; one has stood.
    mirrored
        The last look at the plan's mirror image; None before the first.
    mirror_wins
        Looks in a row at which the mirror image would have been claimed.
    ticks_since_mirror
        Ticks since that look.
    """

    leader: Affine2D | None = None
    wins: int = 0
    sure_wins: int = 0
    sure_of_m2: float = 0.0
    probability: float = 0.0
    is_claimed: bool = False
    was_localized: bool = False
    mirrored: Verdict | None = None
    mirror_wins: int = 0
    ticks_since_mirror: int = 0


@dataclass(frozen=True, eq=False)
class Sight:
    """
    What a verdict is about.

    Parameters
    ----------
    sub
        Evidence of the submap.
    A_submap_odom
        Anchors the submap, so that placements are compared in the odometry frame although the
        submap may have been re-anchored.
    robot_xy : (2,)
        Where the robot is in the submap [m]; None without one.
    floor_m2, driven_m
        Free space seen so far, and the way on which that was.
    unseen_m
        Estimate of the drawn walls that are still to be seen.
    needs_news
        A claim asks for more of it between the ticks that confirm it.
    scales
        Smallest and largest mean scale that a placement might have.
    storey
        The one that the verdict is about, where there are several.
    rival_storey
        The other storey with the most probable placement, the share of the walls that this
        explains, and its probability; None without one.
    unsearched
        Other storeys that have not been searched with what a claim takes.
    """

    sub: MapEvidence
    A_submap_odom: Affine2D
    robot_xy: NDArray[np.float64] | None = None
    floor_m2: float = 0.0
    driven_m: float = 0.0
    unseen_m: float = np.inf
    needs_news: bool = False
    scales: tuple[float, float] = (0.0, np.inf)
    storey: str = ''
    rival_storey: tuple[str, float, float] | None = None
    unsearched: int = 0


@dataclass(frozen=True, eq=False)
class HypothesisTracker:
    """
    Turns each tick's verdict into a status; time decides.

    A claim needs the same placement to win ``confirm_ticks`` times in a row with probability
    of at least ``claim_probability``, and a look at the plan's mirror image and at every other
    storey of the site; it is kept until the
    probability falls below ``release_probability``, so that it neither flickers nor outlives its
    evidence. What a robot sees again from where it stands confirms nothing, however often it
    looks: between two wins that count the submap must have grown, unless the caller knows better,
    or it has driven and the odds are those of as many independent sure looks: floor that was seen
    before counts.
    """

    config: LocalizerConfig
    judge: Judge

    def is_settled(self, standing: Standing) -> bool:
        """Tell whether a claim stands, and as firmly as it was made."""
        return standing.is_claimed and standing.probability >= self.config.claim_probability

    def wants_mirror(self, standing: Standing) -> bool:
        """Tell whether the next tick should look at the plan's mirror image, too."""
        if standing.is_claimed:
            return False
        soon = standing.sure_wins + 1 >= self.config.confirm_ticks
        near_claim = soon and standing.probability >= self.config.release_probability
        return near_claim or standing.ticks_since_mirror + 1 >= self.config.mirror_check_ticks

    def update(
        self, standing: Standing, verdict: Verdict, sight: Sight, mirrored: Verdict | None = None
    ) -> tuple[Standing, Belief]:
        """
        Return where one tick's verdict leads, and what may be claimed.

        ``mirrored`` is that on the plan's mirror image, None where nobody looked.
        """
        standing = self._mirror_counted(standing, verdict, mirrored)
        # Between two looks the mirror image is as good as it was at the last one.
        if standing.mirrored is not None and not standing.is_claimed:
            verdict = self.judge.against_mirror(verdict, standing.mirrored, _MIRROR_LOG_ODDS)
        standing = replace(standing, probability=verdict.best)
        is_mirrored = len(verdict.placements) > 0 and standing.mirror_wins >= _MIRROR_WINS
        look = Circumstances(
            sight.sub.wall_length_m,
            self.config.claim_probability,
            compared_at(sight.sub, sight.robot_xy),
            sight.scales,
            is_mirrored=is_mirrored,
            storey=sight.storey,
            rival_storey=sight.rival_storey,
            unsearched=sight.unsearched,
            unseen_m=sight.unseen_m,
        )
        is_beaten = verdict.best + verdict.elsewhere < verdict.none + verdict.foreign
        if not verdict.placements or is_mirrored or is_beaten:
            return _nothing_found(standing, verdict, look)
        standing = self._win_counted(standing, verdict, sight, look.at)
        has_seen_all = mirrored is not None and not sight.unsearched
        standing = self._claim_decided(standing, verdict.best, has_seen_all)
        return standing, self._belief(standing, verdict, sight, look)

    def _claim_decided(
        self, standing: Standing, probability: float, has_seen_all: bool
    ) -> Standing:
        """Return whether a claim stands after a tick that has counted."""
        needed = self.config.confirm_ticks
        if standing.is_claimed:
            is_kept = probability >= self.config.release_probability
            is_claimed = standing.wins >= needed and is_kept
        else:
            is_claimed = standing.sure_wins >= needed and has_seen_all
        was_localized = standing.was_localized or is_claimed
        return replace(standing, is_claimed=is_claimed, was_localized=was_localized)

    def _belief(
        self, standing: Standing, verdict: Verdict, sight: Sight, look: Circumstances
    ) -> Belief:
        look = replace(
            look,
            is_claimed=standing.is_claimed,
            sure_looks=standing.sure_wins,
            missing_looks=max(self.config.confirm_ticks - standing.sure_wins, 0),
            needs_news=sight.needs_news,
        )
        return Belief(
            Status.LOCALIZED if standing.is_claimed else Status.AMBIGUOUS,
            verdict.placements[0],
            verdict.best,
            reason_of(verdict, look),
            judged=verdict.placements,
            bend_m=float(verdict.evidence.of('bend_m')[0]),
            residual_m=float(verdict.evidence.of('residual_75')[0]),
        )

    def _mirror_counted(
        self, standing: Standing, verdict: Verdict, mirrored: Verdict | None
    ) -> Standing:
        """Count how often in a row the mirror image would have been claimed."""
        if mirrored is None:
            return replace(standing, ticks_since_mirror=standing.ticks_since_mirror + 1)
        contest = self.judge.against_mirror(mirrored, verdict, 0.0)
        is_better = contest.best >= self.config.claim_probability
        wins = standing.mirror_wins + 1 if is_better else 0
        return replace(standing, mirrored=mirrored, mirror_wins=wins, ticks_since_mirror=0)

    def _win_counted(
        self, standing: Standing, verdict: Verdict, sight: Sight, at: NDArray[np.float64]
    ) -> Standing:
        """Count how often in a row the best placement has led, as far as points ``at`` tell."""
        A_plan_odom = verdict.placements[0].A_plan_submap @ sight.A_submap_odom
        points_odom = sight.A_submap_odom.inv().apply(at)
        is_same = False
        if standing.leader is not None:
            apart = A_plan_odom.apply(points_odom) - standing.leader.apply(points_odom)
            is_same = bool(np.linalg.norm(apart, axis=1).mean() <= DISTINCT_M)
        standing = replace(standing, leader=A_plan_odom, wins=standing.wins + 1 if is_same else 1)
        return self._sure_win_counted(standing, verdict.best, sight)

    def _sure_win_counted(self, standing: Standing, probability: float, sight: Sight) -> Standing:
        """Count how often in a row the leader was sure, each time of more than the last."""
        is_sure = probability >= self.config.claim_probability
        # A new leader has won once, whatever the one before it did.
        before = standing.sure_wins if is_sure and standing.wins > 1 else 0
        is_old = sight.floor_m2 < standing.sure_of_m2 + _NEWS_M2
        # As sure as all of them together, from more than one place: seen before, it counts.
        together = self.config.confirm_ticks * logit(self.config.claim_probability)
        counts = sight.driven_m > RECENT_M and logit(probability) >= together
        if before and sight.needs_news and is_old and not counts:
            return standing
        return replace(standing, sure_wins=before + int(is_sure), sure_of_m2=sight.floor_m2)


def _nothing_found(
    standing: Standing, verdict: Verdict, look: Circumstances
) -> tuple[Standing, Belief]:
    standing = replace(standing, is_claimed=False, leader=None, wins=0, sure_wins=0)
    status = Status.LOST if standing.was_localized else Status.SEARCHING
    why = reason_of(verdict, look)
    belief = Belief(status, None, verdict.best, why, look.is_mirrored, verdict.placements)
    return standing, belief
