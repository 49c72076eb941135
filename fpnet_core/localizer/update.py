# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Update of the localizer: from state and observation to the next state and the output.

It is a pure function. The caller keeps the state and may discard a result; the same state
and submap give the same result again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from fpnet_core.geometry import Affine2D
from fpnet_core.localizer.cached_search import CachedSearch
from fpnet_core.localizer.diagnosis import causes_of_look, causes_of_waiting
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.global_localizer import Candidates, GlobalLocalizer, MatchQuery
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.kidnap import KidnapDetector
from fpnet_core.localizer.prepared_maps import RobotXY, StageTimer, prepare_submap
from fpnet_core.localizer.scale import ScaleSearch
from fpnet_core.localizer.storeys import (
    OtherStorey,
    StoreyLook,
    floor_posterior,
    probabilities,
    strongest,
    unsearched,
)
from fpnet_core.localizer.tracking import (
    HypothesisTracker,
    LocalizationState,
    TrackState,
    UpdateContext,
)
from fpnet_core.localizer.update_state import Observation, UpdateState
from fpnet_core.pose import PreparedMap
from fpnet_core.pose.uncertainty import (
    Misfit,
    heading_residual_of,
    packaged_uncertainty,
    wall_information,
)
from fpnet_core.pose_covariance import PoseCovariance, PoseFeatures
from fpnet_core.scoring import Posterior
from fpnet_core.scoring.findings import Sensed
from fpnet_core.scoring.reasons import NO_PLAN, UPSIDE_DOWN, waiting
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import path_length
from fpnet_core.types import LocalizerOutput, Status, Submap


def update(
    state: UpdateState,
    observation: Observation,
    global_localizer: GlobalLocalizer,
    timer: StageTimer,
) -> tuple[UpdateState, LocalizerOutput]:
    """
    Segment, match, verify and decide; return the next state and the output.

    Changes neither ``state`` nor ``observation`` and never raises on sensor data; the absence of a
    pose is a status.

    Parameters
    ----------
    state : result of the last update, or the initial state
    observation : the submap and the robot's pose in it
    global_localizer : matcher, placement scorer and configuration
    timer : measures the stages; the output contains its durations, nothing depends on them
    """
    plan, submap = state.plan, observation.submap
    if plan is None:
        return state, LocalizerOutput(
            observation.now_ns, Status.NO_PLAN, submap=submap, reason=NO_PLAN
        )
    if submap is None or submap.free_area_m2 < global_localizer.config.localizer.min_explored_m2:
        return state, _waiting(observation, global_localizer)
    with timer.stage('total'):
        hangs = observation.is_upside_down
        return _Update(
            state, plan, submap, observation.robot_xy, global_localizer, timer, hangs
        ).run()


def _waiting(observation: Observation, global_localizer: GlobalLocalizer) -> LocalizerOutput:
    """Return the output of an update with too few observations to match."""
    seen_m2 = 0.0 if observation.submap is None else observation.submap.free_area_m2
    return LocalizerOutput(
        observation.now_ns,
        Status.WAITING,
        submap=observation.submap,
        reason=waiting(seen_m2, global_localizer.config.localizer.min_explored_m2),
        causes=causes_of_waiting(
            observation.submap, global_localizer.config, observation.T_odom_sensor is not None
        ),
    )


@dataclass(frozen=True, eq=False)
class _Found:
    """Result of a search, or of tracking the last one."""

    segmenter: SubmapSegmenter
    searched: CachedSearch
    candidates: Candidates


@dataclass(frozen=True, eq=False)
class _Weighed:
    """
    All hypotheses of an update, weighed against each other.

    ``posterior`` is over the placements on ``plan`` at all scales, its mirror image and the
    storeys ``others``, of which those ``is_fresh`` were compared in this update. ``mirrored`` is
    the posterior on the mirror image, None if it was not searched; ``hint`` is what remains of
    the hint.
    """

    query: MatchQuery
    candidates: Candidates
    posterior: Posterior
    plan: Floorplan
    mirrored: Posterior | None
    hint: PoseHint | None
    others: tuple[OtherStorey, ...]
    is_fresh: list[bool]


@dataclass(frozen=True, eq=False)
class _Update:
    """One update with a floorplan and enough observations; a method for each step."""

    state: UpdateState
    plan: Floorplan
    submap: Submap
    robot_xy: RobotXY
    global_localizer: GlobalLocalizer
    timer: StageTimer
    is_upside_down: bool

    def run(self) -> tuple[UpdateState, LocalizerOutput]:
        """Search, weigh the hypotheses, track them, check around the robot, and report."""
        state, submap, config = self.state, self.submap, self.global_localizer.config.localizer
        found = self._placed()
        weighed = self._weighed(found)
        sub, detector = found.searched.sub, KidnapDetector(config)
        context = self._context(sub, weighed.hint, weighed.others)
        track, estimate = self._tracker.update(
            state.track, weighed.posterior, context, weighed.mirrored
        )
        plan = weighed.plan.after(estimate, sub.evidence.walls)
        kidnap_state, checked, A = detector.update(
            state.kidnap_state, plan.working.evidence, submap, estimate, self.robot_xy
        )
        after = UpdateState(
            plan=plan,
            segmenter=found.segmenter,
            track=track,
            kidnap_state=kidnap_state,
            tracked=estimate.scored @ submap.T_odom_submap.inv(),
            searched=found.searched if self._tracker.is_settled(track) else None,
            hint=weighed.hint,
            covariance=self._covariance(checked, A),
            is_elsewhere=detector.is_elsewhere(kidnap_state),
            others=weighed.others,
        )
        output = self._output(after, found, weighed, checked, A)
        return self._on_strongest_storey(after, found, weighed), output

    @property
    def _tracker(self) -> HypothesisTracker:
        config = self.global_localizer.config.localizer
        return HypothesisTracker(config, self.global_localizer.scorer)

    def _weighed(self, found: _Found) -> _Weighed:
        """Weigh the placements found against other scales, other storeys, and the mirror image."""
        state, submap, sub = self.state, self.submap, found.searched.sub
        look = StoreyLook(submap, sub, self.global_localizer, self.robot_xy)
        others, is_fresh = look.looked_at(
            state.others,
            self._tracker.is_settled(state.track),
            not found.searched.updates,
            self.timer,
        )
        # Searches of other storeys that block acceptance come before the tests of this one.
        has_searched = not unsearched(others, submap.free_area_m2)
        doubts = has_searched and self._tracker.wants_mirror(state.track)
        search = self.plan.scale.search if doubts else self.plan.scale.search.as_stated
        query = self._query(sub, search)
        candidates = self.global_localizer.with_wide_scales(query, found.candidates, self.timer)
        posterior, hint = self._hinted(candidates.posterior)
        posterior, others = floor_posterior(
            self.global_localizer.scorer, posterior, self.plan, others, is_fresh
        )
        plan, mirrored = self.plan, None
        if doubts:
            plan, mirrored = self._mirrored(candidates, sub, search)
        return _Weighed(query, candidates, posterior, plan, mirrored, hint, others, is_fresh)

    def _on_strongest_storey(
        self, after: UpdateState, found: _Found, weighed: _Weighed
    ) -> UpdateState:
        """Return the next state, about another storey where that is more probable by now."""
        hint, posterior, best = weighed.hint, weighed.posterior, strongest(weighed.others)
        is_hinted = hint is not None and not hint.is_doubted
        if best is None or best.best <= posterior.best or is_hinted or after.is_elsewhere:
            return after
        assert after.plan is not None  # this update's
        left = OtherStorey(after.plan, after.tracked, posterior, found.searched.free_area_m2)
        track = TrackState(was_localized=after.track.was_localized)
        # The other storey was updated just now, so this counts as its first win.
        if best.posterior is not None and weighed.is_fresh[weighed.others.index(best)]:
            context = self._context(found.searched.sub, None, weighed.others)
            track, _ = self._tracker.update(track, best.posterior, context)
        return replace(after.about(best.plan.name, left), track=track)

    def _placed(self) -> _Found:
        """Search the whole plan, or track the results of the last search if it still holds."""
        state, submap = self.state, self.submap
        search, last = self.plan.scale.search.as_stated, state.searched
        if last is not None and last.holds(submap, self.global_localizer.config.localizer):
            query = self._query(last.sub, search)
            searched, candidates = last.followed(self.global_localizer, query, submap, self.timer)
            return _Found(state.segmenter, searched, candidates)
        sub, segmenter = prepare_submap(submap, state.segmenter, self.timer)
        candidates = self.global_localizer.find(self._query(sub, search), self.timer)
        searched = CachedSearch(sub, candidates.match, submap.free_area_m2)
        return _Found(segmenter, searched, candidates)

    def _query(self, sub: PreparedMap, search: ScaleSearch) -> MatchQuery:
        """Return the match query for the submap, with the last update's placements."""
        tracked = self.state.tracked @ self.submap.T_odom_submap
        area_m2 = self.submap.free_area_m2
        return MatchQuery(self.plan.working, sub, area_m2, search, tracked, self.robot_xy)

    def _mirrored(
        self, candidates: Candidates, sub: PreparedMap, search: ScaleSearch
    ) -> tuple[Floorplan, Posterior]:
        """Return the plan with its mirror image computed, and the posterior on that."""
        scale = candidates.estimates.take(slice(1)).scale
        # The wide scale prior applies to the mirror image only if the plan itself needs it.
        alike = search.as_stated if search.is_within(scale).all() else search
        with self.timer.stage('mirror'):
            plan = self.plan.with_mirror()
            assert plan.mirror is not None  # by with_mirror()
            # The mirror image's stages are not part of the plan's timings.
            area_m2 = self.submap.free_area_m2
            query = MatchQuery(plan.mirror, sub, area_m2, alike)
            mirrored = self.global_localizer.find(query, StageTimer())
        return plan, mirrored.posterior

    def _hinted(self, posterior: Posterior) -> tuple[Posterior, PoseHint | None]:
        """Return the posterior given the hint, unless walls outweigh it, and the updated hint."""
        hint = self.state.hint
        if hint is None or not posterior.placements:
            return posterior, hint
        A_submap_odom = self.submap.T_odom_submap.inv()
        agrees = hint.agreeing(posterior.placements, A_submap_odom)
        hinted = self.global_localizer.scorer.with_hint(posterior, agrees, hint.log_odds)
        is_heeded = bool(hint.agreeing(hinted.placements.take(slice(1)), A_submap_odom)[0])
        return (hinted if is_heeded else posterior), hint.after(is_heeded)

    def _context(
        self, sub: PreparedMap, hint: PoseHint | None, others: tuple[OtherStorey, ...]
    ) -> UpdateContext:
        area_m2, runner_up = self.submap.free_area_m2, strongest(others)
        is_little = area_m2 < self.plan.half_area_m2
        return UpdateContext(
            sub.evidence,
            self.submap.T_odom_submap.inv(),
            self.robot_xy,
            floor_m2=area_m2,
            driven_m=path_length(self.submap.path_xy),
            unseen_m=self.plan.working.evidence.unseen_wall_m(area_m2),
            needs_news=is_little and (hint is None or hint.is_doubted),
            scales=self.plan.scale.tolerated,
            storey=self.plan.name if others else '',
            runner_up_storey=None if runner_up is None else runner_up.said,
            unsearched=unsearched(others, area_m2),
        )

    def _output(
        self,
        after: UpdateState,
        found: _Found,
        weighed: _Weighed,
        estimate: LocalizationState,
        A_working_odom: Affine2D | None,
    ) -> LocalizerOutput:
        plan, covariance = after.plan, after.covariance
        assert plan is not None  # this update's
        is_hung = estimate.is_mirrored and self.is_upside_down
        return LocalizerOutput(
            stamp_ns=self.submap.stamp_ns,
            status=estimate.status,
            A_plan_odom=None if A_working_odom is None else plan.to_nominal(A_working_odom),
            covariance=None if covariance is None else plan.nominal_covariance(covariance),
            probability=estimate.probability,
            estimates=plan.nominal_estimates(estimate.scored),
            match=weighed.candidates.match,
            segmentation=found.searched.sub.segmentation,
            graph=found.searched.sub.graph,
            submap=self.submap,
            timings_ms=self.timer.timings_ms,
            scale=plan.nominal_scale(),
            reason=UPSIDE_DOWN if is_hung else estimate.reason,
            is_mirrored=estimate.is_mirrored,
            causes=causes_of_look(
                weighed.query, weighed.posterior, self.submap, estimate.status,
                estimate.is_mirrored, self.plan.scale_conflict, Sensed(is_hung),
            ),
            storey=plan.name,
            storeys=probabilities(plan, weighed.posterior, weighed.others),
        )  # fmt: skip

    def _covariance(
        self, estimate: LocalizationState, A_plan_odom: Affine2D | None
    ) -> PoseCovariance | None:
        """Return the covariance of the accepted pose, working metres."""
        if A_plan_odom is None:
            return None
        plan, submap, last = self.plan.working.evidence, self.submap, self.state.covariance
        assert self.robot_xy is not None  # localized implies scans with poses
        recent, newest, xy_odom = (
            submap.T_odom_submap.apply(xy)
            for xy in (submap.recent_xy, submap.newest_xy, self.robot_xy)
        )
        before = (0.0, 0.0)
        if last is not None:
            before = (
                last.features.heading_residual_rad,
                (submap.stamp_ns - last.stamp_ns) / NS_PER_S,
            )
        heading_residual_rad = heading_residual_of(plan, newest, A_plan_odom, xy_odom, before)
        figures = Misfit(estimate.deformation_m, estimate.residual_m, heading_residual_rad).figures
        information = wall_information(plan, recent, A_plan_odom, xy_odom)
        features = PoseFeatures(information, figures, heading_residual_rad)
        return packaged_uncertainty().covariance(features, xy_odom, submap.stamp_ns)
