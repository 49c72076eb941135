# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hypothesis tracking over time: from the posteriors of updates to a status."""

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

MIRROR_LOG_ODDS = 5.3  # nats, prior: one drawing in two hundred is mirrored; chosen

_NEWS_M2 = 5.0
"""
Chosen: floor that must be new for an update to confirm the last one, the size of the smallest
rooms (``benchmarks/claim_rules.py``). Walls do not count, as they fill in while a robot stands.
"""

_MIRROR_WINS = 2  # consecutive checks in which the mirror image would be accepted; chosen


@dataclass(frozen=True, eq=False)
class LocalizationState:
    """
    Status, its placement (None while searching) and the probability of that.

    ``reason`` explains it in one sentence; ``is_mirrored``: the observations fit the
    plan's mirror image only. ``scored`` are all placements behind the status, with their
    probabilities. ``deformation_m`` is the deformation of the drawing under the best one, and
    ``residual_m`` the 75th percentile of the distances of walls from drawn ones.
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
    Result of all updates so far; plain values, input of the next update.

    Parameters
    ----------
    leader
        ``A_plan_odom`` of the last update's best placement; None if there was none.
    wins
        Consecutive updates that it has won.
    sure_wins
        Those of them with sufficient probability, each with new observations.
    sure_of_m2
        Free area observed at the last of these.
    probability
        The leader's at the last update.
    is_accepted, was_localized
        A placement is accepted; one was accepted before.
    mirrored
        Last posterior on the plan's mirror image; None before the first check.
    mirror_wins
        Consecutive checks in which the mirror image would be accepted.
    updates_since_mirror
        Updates since the last check.
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
    Context of a posterior.

    Parameters
    ----------
    sub
        Evidence of the submap.
    A_submap_odom
        Pose of ``odom`` in the submap. Placements are compared in the odometry frame, because the
        submap's frame may have changed.
    robot_xy : (2,)
        Position of the robot in the submap [m]; None without one.
    floor_m2, driven_m
        Free area observed so far, and length of the path.
    unseen_m
        Estimated length of plan walls not observed yet.
    needs_news
        Acceptance requires new observations between the updates that confirm it.
    scales
        Smallest and largest mean scale allowed for a placement.
    storey
        The one of the posterior, if there are several.
    runner_up_storey
        Other storey with the most probable placement, the share of walls explained by this
        placement, and its probability; None without one.
    unsearched
        Number of other storeys whose missing search blocks acceptance.
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
    runner_up_storey: tuple[str, float, float] | None = None
    unsearched: int = 0


@dataclass(frozen=True, eq=False)
class HypothesisTracker:
    """
    Derives the status from the posteriors of consecutive updates.

    Acceptance requires that the same placement wins ``confirm_updates`` updates in a row with a
    probability of at least ``accept_probability``, and a check of the plan's mirror image and of
    every other storey of the site. The placement is kept until its probability falls below
    ``release_probability``; this hysteresis avoids flicker and still releases a placement without
    evidence. Repeated observations from one place confirm nothing:
    between two wins that count the submap must have grown, unless ``needs_news`` is off,
    or the robot has moved and the odds equal those of as many independent wins: then known floor
    counts as well.
    """

    config: LocalizerConfig
    scorer: PlacementScorer

    def is_settled(self, track: TrackState) -> bool:
        """Return whether a placement is accepted with sufficient probability."""
        return track.is_accepted and track.probability >= self.config.accept_probability

    def wants_mirror(self, track: TrackState) -> bool:
        """Return whether the next update should check the plan's mirror image."""
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
        Return the track and the localization state after one update.

        ``mirrored`` is the posterior on the plan's mirror image; None if not checked.
        """
        track = self._mirror_counted(track, posterior, mirrored)
        # Between checks of the mirror image, its last posterior is used.
        if track.mirrored is not None and not track.is_accepted:
            posterior = self.scorer.against_mirror(posterior, track.mirrored, MIRROR_LOG_ODDS)
        track = replace(track, probability=posterior.best)
        is_mirrored = len(posterior.placements) > 0 and track.mirror_wins >= _MIRROR_WINS
        facts = Circumstances(
            context.sub.wall_length_m,
            self.config.accept_probability,
            compared_at(context.sub, context.robot_xy),
            context.scales,
            is_mirrored=is_mirrored,
            storey=context.storey,
            runner_up_storey=context.runner_up_storey,
            unsearched=context.unsearched,
            unseen_m=context.unseen_m,
        )
        is_beaten = posterior.best + posterior.elsewhere < posterior.none + posterior.foreign
        if not posterior.placements or is_mirrored or is_beaten:
            return _nothing_found(track, posterior, facts)
        track = self._win_counted(track, posterior, context, facts.at)
        has_seen_all = mirrored is not None and not context.unsearched
        track = self._with_acceptance(track, posterior.best, has_seen_all)
        return track, self._localization_state(track, posterior, context, facts)

    def _with_acceptance(
        self, track: TrackState, probability: float, has_seen_all: bool
    ) -> TrackState:
        """Return the track with the decision on acceptance."""
        needed = self.config.confirm_updates
        if track.is_accepted:
            is_kept = probability >= self.config.release_probability
            is_accepted = track.wins >= needed and is_kept
        else:
            is_accepted = track.sure_wins >= needed and has_seen_all
        was_localized = track.was_localized or is_accepted
        return replace(track, is_accepted=is_accepted, was_localized=was_localized)

    def _localization_state(
        self, track: TrackState, posterior: Posterior, context: UpdateContext, facts: Circumstances
    ) -> LocalizationState:
        facts = replace(
            facts,
            is_accepted=track.is_accepted,
            sure_looks=track.sure_wins,
            missing_looks=max(self.config.confirm_updates - track.sure_wins, 0),
            needs_news=context.needs_news,
        )
        return LocalizationState(
            Status.LOCALIZED if track.is_accepted else Status.AMBIGUOUS,
            posterior.placements[0],
            posterior.best,
            reason_of(posterior, facts),
            scored=posterior.placements,
            deformation_m=float(posterior.evidence.of('bend_m')[0]),
            residual_m=float(posterior.evidence.of('residual_75')[0]),
        )

    def _mirror_counted(
        self, track: TrackState, posterior: Posterior, mirrored: Posterior | None
    ) -> TrackState:
        """Count the consecutive checks in which the mirror image would be accepted."""
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
        """Count the consecutive wins of the best placement, compared at the points ``at``."""
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
        """Count the consecutive wins with sufficient probability and new observations."""
        is_sure = probability >= self.config.accept_probability
        # A new leader starts at one win.
        before = track.sure_wins if is_sure and track.wins > 1 else 0
        is_old = context.floor_m2 < track.sure_of_m2 + _NEWS_M2
        # Probability of that many independent wins, after some motion: known floor counts too.
        together = self.config.confirm_updates * logit(self.config.accept_probability)
        counts = context.driven_m > RECENT_M and logit(probability) >= together
        if before and context.needs_news and is_old and not counts:
            return track
        return replace(track, sure_wins=before + int(is_sure), sure_of_m2=context.floor_m2)


def _nothing_found(
    track: TrackState, posterior: Posterior, facts: Circumstances
) -> tuple[TrackState, LocalizationState]:
    track = replace(track, is_accepted=False, leader=None, wins=0, sure_wins=0)
    status = Status.LOST if track.was_localized else Status.SEARCHING
    why = reason_of(posterior, facts)
    estimate = LocalizationState(
        status, None, posterior.best, why, facts.is_mirrored, posterior.placements
    )
    return track, estimate
