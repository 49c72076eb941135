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
from fpnet_core.pose import MapEvidence, compared_at
from fpnet_core.pose.estimate import DISTINCT_M
from fpnet_core.scoring import Circumstances, PlacementScorer, Posterior, reason_of
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
class LocalizationState:
    """
    Status, the placement it rests on (None while searching) and its probability.

    ``reason`` says why, in one sentence; ``is_mirrored`` that it is because what was seen fits the
    plan's mirror image only. ``scored`` are all placements that the status rests on, with their
    probabilities. ``deformation_m`` is how far the drawing is deformed under the best one, and
    ``residual_m`` how far three quarters of the walls lie off drawn ones at most.
    """

    status: Status
    best: Placement | None
    probability: float
    reason: str
    is_mirrored: bool = False
    scored: Placements = field(default_factory=Placements.empty)
    deformation_m: float = 0.0
    residual_m: float = 0.0


@dataclass(frozen=True, eq=False)
class TrackState:
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
    is_accepted: bool = False
    was_localized: bool = False
    mirrored: Posterior | None = None
    mirror_wins: int = 0
    updates_since_mirror: int = 0


@dataclass(frozen=True, eq=False)
class UpdateContext:
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

    A claim needs the same placement to win ``confirm_updates`` times in a row with probability
    of at least ``accept_probability``, and a look at the plan's mirror image and at every other
    storey of the site; it is kept until the
    probability falls below ``release_probability``, so that it neither flickers nor outlives its
    evidence. What a robot sees again from where it stands confirms nothing, however often it
    looks: between two wins that count the submap must have grown, unless the caller knows better,
    or it has driven and the odds are those of as many independent sure looks: floor that was seen
    before counts.
    """

    config: LocalizerConfig
    scorer: PlacementScorer

    def is_settled(self, track: TrackState) -> bool:
        """Tell whether a claim stands, and as firmly as it was made."""
        return track.is_accepted and track.probability >= self.config.accept_probability

    def wants_mirror(self, track: TrackState) -> bool:
        """Tell whether the next tick should look at the plan's mirror image, too."""
        if track.is_accepted:
            return False
        soon = track.sure_wins + 1 >= self.config.confirm_updates
        near_claim = soon and track.probability >= self.config.release_probability
        return near_claim or track.updates_since_mirror + 1 >= self.config.mirror_check_updates

    def update(
        self,
        track: TrackState,
        posterior: Posterior,
        context: UpdateContext,
        mirrored: Posterior | None = None,
    ) -> tuple[TrackState, LocalizationState]:
        """
        Return where one tick's verdict leads, and what may be claimed.

        ``mirrored`` is that on the plan's mirror image, None where nobody looked.
        """
        track = self._mirror_counted(track, posterior, mirrored)
        # Between two looks the mirror image is as good as it was at the last one.
        if track.mirrored is not None and not track.is_accepted:
            posterior = self.scorer.against_mirror(posterior, track.mirrored, _MIRROR_LOG_ODDS)
        track = replace(track, probability=posterior.best)
        is_mirrored = len(posterior.placements) > 0 and track.mirror_wins >= _MIRROR_WINS
        look = Circumstances(
            context.sub.wall_length_m,
            self.config.accept_probability,
            compared_at(context.sub, context.robot_xy),
            context.scales,
            is_mirrored=is_mirrored,
            storey=context.storey,
            rival_storey=context.rival_storey,
            unsearched=context.unsearched,
            unseen_m=context.unseen_m,
        )
        is_beaten = posterior.best + posterior.elsewhere < posterior.none + posterior.foreign
        if not posterior.placements or is_mirrored or is_beaten:
            return _nothing_found(track, posterior, look)
        track = self._win_counted(track, posterior, context, look.at)
        has_seen_all = mirrored is not None and not context.unsearched
        track = self._claim_decided(track, posterior.best, has_seen_all)
        return track, self._belief(track, posterior, context, look)

    def _claim_decided(
        self, track: TrackState, probability: float, has_seen_all: bool
    ) -> TrackState:
        """Return whether a claim stands after a tick that has counted."""
        needed = self.config.confirm_updates
        if track.is_accepted:
            is_kept = probability >= self.config.release_probability
            is_accepted = track.wins >= needed and is_kept
        else:
            is_accepted = track.sure_wins >= needed and has_seen_all
        was_localized = track.was_localized or is_accepted
        return replace(track, is_accepted=is_accepted, was_localized=was_localized)

    def _belief(
        self, track: TrackState, posterior: Posterior, context: UpdateContext, look: Circumstances
    ) -> LocalizationState:
        look = replace(
            look,
            is_accepted=track.is_accepted,
            sure_looks=track.sure_wins,
            missing_looks=max(self.config.confirm_updates - track.sure_wins, 0),
            needs_news=context.needs_news,
        )
        return LocalizationState(
            Status.LOCALIZED if track.is_accepted else Status.AMBIGUOUS,
            posterior.placements[0],
            posterior.best,
            reason_of(posterior, look),
            scored=posterior.placements,
            deformation_m=float(posterior.evidence.of('bend_m')[0]),
            residual_m=float(posterior.evidence.of('residual_75')[0]),
        )

    def _mirror_counted(
        self, track: TrackState, posterior: Posterior, mirrored: Posterior | None
    ) -> TrackState:
        """Count how often in a row the mirror image would have been claimed."""
        if mirrored is None:
            return replace(track, updates_since_mirror=track.updates_since_mirror + 1)
        contest = self.scorer.against_mirror(mirrored, posterior, 0.0)
        is_better = contest.best >= self.config.accept_probability
        wins = track.mirror_wins + 1 if is_better else 0
        return replace(track, mirrored=mirrored, mirror_wins=wins, updates_since_mirror=0)

    def _win_counted(
        self,
        track: TrackState,
        posterior: Posterior,
        context: UpdateContext,
        at: NDArray[np.float64],
    ) -> TrackState:
        """Count how often in a row the best placement has led, as far as points ``at`` tell."""
        A_plan_odom = posterior.placements[0].A_plan_submap @ context.A_submap_odom
        points_odom = context.A_submap_odom.inv().apply(at)
        is_same = False
        if track.leader is not None:
            apart = A_plan_odom.apply(points_odom) - track.leader.apply(points_odom)
            is_same = bool(np.linalg.norm(apart, axis=1).mean() <= DISTINCT_M)
        track = replace(track, leader=A_plan_odom, wins=track.wins + 1 if is_same else 1)
        return self._sure_win_counted(track, posterior.best, context)

    def _sure_win_counted(
        self, track: TrackState, probability: float, context: UpdateContext
    ) -> TrackState:
        """Count how often in a row the leader was sure, each time of more than the last."""
        is_sure = probability >= self.config.accept_probability
        # A new leader has won once, whatever the one before it did.
        before = track.sure_wins if is_sure and track.wins > 1 else 0
        is_old = context.floor_m2 < track.sure_of_m2 + _NEWS_M2
        # As sure as all of them together, from more than one place: seen before, it counts.
        together = self.config.confirm_updates * logit(self.config.accept_probability)
        counts = context.driven_m > RECENT_M and logit(probability) >= together
        if before and context.needs_news and is_old and not counts:
            return track
        return replace(track, sure_wins=before + int(is_sure), sure_of_m2=context.floor_m2)


def _nothing_found(
    track: TrackState, posterior: Posterior, look: Circumstances
) -> tuple[TrackState, LocalizationState]:
    track = replace(track, is_accepted=False, leader=None, wins=0, sure_wins=0)
    status = Status.LOST if track.was_localized else Status.SEARCHING
    why = reason_of(posterior, look)
    estimate = LocalizationState(
        status, None, posterior.best, why, look.is_mirrored, posterior.placements
    )
    return track, estimate
