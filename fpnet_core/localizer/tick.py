# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The tick: from what was known and what is seen to what is known now and what may be claimed.

A function of values. Who calls it keeps the state, and may throw a result away: the same state
and the same submap give the same answer again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.judging import Verdict
from fpnet_core.judging.findings import Sensed
from fpnet_core.judging.reasons import NO_PLAN, UPSIDE_DOWN, waiting
from fpnet_core.localizer.belief import Belief, HypothesisTracker, Sight, Standing
from fpnet_core.localizer.diagnosis import causes_of_look, causes_of_waiting
from fpnet_core.localizer.finder import Comparison, Finder, Question
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.scale import ScaleSearch
from fpnet_core.localizer.search import Searched
from fpnet_core.localizer.sides import RobotXY, StageTimer, prepare_submap
from fpnet_core.localizer.storeys import (
    OtherStorey,
    StoreyLook,
    in_contest,
    probabilities,
    strongest,
    unsearched,
)
from fpnet_core.localizer.surroundings import Surroundings
from fpnet_core.localizer.tick_state import Seen, TickState
from fpnet_core.pose import MapSide
from fpnet_core.pose.uncertainty import (
    Misfit,
    packaged_uncertainty,
    unrest_of,
    wall_information,
)
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.spread import PoseSpread, Signs
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import path_length
from fpnet_core.types import LocalizerOutput, Status, Submap


def tick(
    state: TickState, seen: Seen, finder: Finder, timer: StageTimer
) -> tuple[TickState, LocalizerOutput]:
    """
    Segment, match, verify and decide: return the next state and what may be said.

    Changes neither ``state`` nor ``seen``, and never raises on what sensors send; "no answer" is a
    status.

    Parameters
    ----------
    state : what the last tick left, or a beginning
    seen : the submap and where the robot is in it
    finder : matcher, judge and configuration
    timer : measures the stages; the output has its durations, and nothing else hangs on them
    """
    plan, submap = state.plan, seen.submap
    if plan is None:
        return state, LocalizerOutput(seen.now_ns, Status.NO_PLAN, submap=submap, reason=NO_PLAN)
    if submap is None or submap.free_area_m2 < finder.config.localizer.min_explored_m2:
        return state, _waiting(seen, finder)
    with timer.stage('total'):
        hangs = seen.is_upside_down
        return _Tick(state, plan, submap, seen.robot_xy, finder, timer, hangs).run()


def _waiting(seen: Seen, finder: Finder) -> LocalizerOutput:
    """Return the output of a tick that has seen too little to compare."""
    seen_m2 = 0.0 if seen.submap is None else seen.submap.free_area_m2
    return LocalizerOutput(
        seen.now_ns,
        Status.WAITING,
        submap=seen.submap,
        reason=waiting(seen_m2, finder.config.localizer.min_explored_m2),
        causes=causes_of_waiting(seen.submap, finder.config, seen.T_odom_sensor is not None),
    )


@dataclass(frozen=True, eq=False)
class _Found:
    """What the search, or the following of the last one, has led to."""

    segmenter: SubmapSegmenter
    searched: Searched
    comparison: Comparison


@dataclass(frozen=True, eq=False)
class _Tick:
    """One tick with a floorplan and enough to compare it with; a method for each step."""

    state: TickState
    plan: Floorplan
    submap: Submap
    robot_xy: RobotXY
    finder: Finder
    timer: StageTimer
    is_upside_down: bool

    def run(self) -> tuple[TickState, LocalizerOutput]:
        """Return the next state and the output."""
        state, submap, config = self.state, self.submap, self.finder.config.localizer
        tracker = HypothesisTracker(config, self.finder.judge)
        found = self._placed()
        look = StoreyLook(submap, found.searched.sub, self.finder, self.robot_xy)
        others, is_fresh = look.looked_at(
            state.others, tracker.is_settled(state.standing), not found.searched.ticks, self.timer
        )
        # Storeys that keep a claim from being made come before doubts about this one.
        has_searched = not unsearched(others, submap.free_area_m2)
        doubts = has_searched and tracker.wants_mirror(state.standing)
        search = self.plan.scale.search if doubts else self.plan.scale.search.as_stated
        sub = found.searched.sub
        asked = self._question(sub, search)
        comparison = self.finder.doubted(asked, found.comparison, self.timer)
        found = replace(found, comparison=comparison)
        verdict, hint = self._told(found.comparison.verdict)
        verdict, others = in_contest(self.finder.judge, verdict, self.plan, others, is_fresh)
        plan, mirrored = self._mirrored(found, search) if doubts else (self.plan, None)
        standing, belief = tracker.update(
            state.standing, verdict, self._sight(sub, hint, others), mirrored
        )
        plan = plan.after(belief, sub.evidence.walls)
        vicinity, told, A = Surroundings(config).judge(
            state.vicinity, plan.working.evidence, submap, belief, self.robot_xy
        )
        spread = self._spread(told, A)
        after = TickState(
            plan=plan,
            segmenter=found.segmenter,
            standing=standing,
            vicinity=vicinity,
            tracked=belief.judged @ submap.T_odom_submap.inv(),
            searched=found.searched if tracker.is_settled(standing) else None,
            hint=hint,
            spread=spread,
            is_elsewhere=Surroundings(config).is_elsewhere(vicinity),
            others=others,
        )
        causes = causes_of_look(
            asked, verdict, submap, told.status, told.is_mirrored, self.plan.denial,
            Sensed(self.is_upside_down and told.is_mirrored),
        )  # fmt: skip
        output = self._output(plan, found, belief.judged, told, A, spread)
        storeys = probabilities(plan, verdict, others)
        named = replace(output, causes=causes, storey=plan.name, storeys=storeys)
        best = strongest(others)
        is_told = hint is not None and not hint.is_doubted
        if best is None or best.best <= verdict.best or is_told or after.is_elsewhere:
            return after, named
        left = OtherStorey(plan, after.tracked, verdict, found.searched.free_area_m2)
        begun = Standing(was_localized=standing.was_localized)
        # It has been looked at in this tick, and has won.
        if best.verdict is not None and is_fresh[others.index(best)]:
            begun, _ = tracker.update(begun, best.verdict, self._sight(sub, None, others))
        return replace(after.about(best.plan.name, left), standing=begun), named

    def _placed(self) -> _Found:
        """Search the whole plan, or follow what the last search found where that will do."""
        state, submap = self.state, self.submap
        search, last = self.plan.scale.search.as_stated, state.searched
        if last is not None and last.holds(submap, self.finder.config.localizer):
            asked = self._question(last.sub, search)
            searched, comparison = last.followed(self.finder, asked, submap, self.timer)
            return _Found(state.segmenter, searched, comparison)
        sub, segmenter = prepare_submap(submap, state.segmenter, self.timer)
        comparison = self.finder.find(self._question(sub, search), self.timer)
        searched = Searched(sub, comparison.match, submap.free_area_m2)
        return _Found(segmenter, searched, comparison)

    def _question(self, sub: MapSide, search: ScaleSearch) -> Question:
        """Return where the submap lies, also by the last tick's placements, as a question."""
        tracked = self.state.tracked @ self.submap.T_odom_submap
        area_m2 = self.submap.free_area_m2
        return Question(self.plan.working, sub, area_m2, search, tracked, self.robot_xy)

    def _mirrored(self, found: _Found, search: ScaleSearch) -> tuple[Floorplan, Verdict]:
        """Return the verdict on the drawing's mirror image, and the plan that has it by now."""
        scale = found.comparison.estimates.take(slice(1)).scale
        # A drawing both flipped and misstated matters only as a misstated one's rival.
        alike = search.as_stated if search.is_within(scale).all() else search
        with self.timer.stage('mirror'):
            plan = self.plan.with_mirror()
            assert plan.mirror is not None  # it was asked for
            # Its stages are not the drawing's.
            area_m2 = self.submap.free_area_m2
            asked = Question(plan.mirror, found.searched.sub, area_m2, alike)
            mirrored = self.finder.find(asked, StageTimer())
        return plan, mirrored.verdict

    def _told(self, verdict: Verdict) -> tuple[Verdict, PoseHint | None]:
        """Return the verdict after someone's word, unless walls outweigh it, and what is left."""
        hint = self.state.hint
        if hint is None or not verdict.placements:
            return verdict, hint
        A_submap_odom = self.submap.T_odom_submap.inv()
        agrees = hint.agreeing(verdict.placements, A_submap_odom)
        told = self.finder.judge.told(verdict, agrees, hint.log_odds)
        is_heeded = bool(hint.agreeing(told.placements.take(slice(1)), A_submap_odom)[0])
        return (told if is_heeded else verdict), hint.after(is_heeded)

    def _sight(
        self, sub: MapSide, hint: PoseHint | None, others: tuple[OtherStorey, ...]
    ) -> Sight:
        area_m2, rival = self.submap.free_area_m2, strongest(others)
        is_little = area_m2 < self.plan.half_area_m2
        return Sight(
            sub.evidence,
            self.submap.T_odom_submap.inv(),
            self.robot_xy,
            floor_m2=area_m2,
            driven_m=path_length(self.submap.path_xy),
            unseen_m=self.plan.working.evidence.unseen_wall_m(area_m2),
            needs_news=is_little and (hint is None or hint.is_doubted),
            scales=self.plan.scale.tolerated,
            storey=self.plan.name if others else '',
            rival_storey=None if rival is None else rival.said,
            unsearched=unsearched(others, area_m2),
        )

    def _output(
        self,
        plan: Floorplan,
        found: _Found,
        judged: Placements,
        belief: Belief,
        A_working_odom: Affine2D | None,
        spread: PoseSpread | None,
    ) -> LocalizerOutput:
        estimates = plan.nominal_estimates(judged)
        is_hung = belief.is_mirrored and self.is_upside_down
        return LocalizerOutput(
            stamp_ns=self.submap.stamp_ns,
            status=belief.status,
            A_plan_odom=None if A_working_odom is None else plan.to_nominal(A_working_odom),
            spread=None if spread is None else plan.nominal_spread(spread),
            probability=belief.probability,
            estimates=estimates,
            match=found.comparison.match,
            segmentation=found.searched.sub.segmentation,
            graph=found.searched.sub.graph,
            submap=self.submap,
            timings_ms=self.timer.timings_ms,
            scale=plan.nominal_scale(),
            reason=UPSIDE_DOWN if is_hung else belief.reason,
            is_mirrored=belief.is_mirrored,
        )

    def _spread(self, belief: Belief, A_plan_odom: Affine2D | None) -> PoseSpread | None:
        """Return how far the robot may be from where a claim puts it, working metres."""
        if A_plan_odom is None:
            return None
        plan, submap, last = self.plan.working.evidence, self.submap, self.state.spread
        assert self.robot_xy is not None  # a claim rests on scans, and they have poses
        recent, newest, xy_odom = (
            submap.T_odom_submap.apply(xy)
            for xy in (submap.recent_xy, submap.newest_xy, self.robot_xy)
        )
        before = (0.0, 0.0)
        if last is not None:
            before = last.signs.unrest_rad, (submap.stamp_ns - last.stamp_ns) / NS_PER_S
        unrest_rad = unrest_of(plan, newest, A_plan_odom, xy_odom, before)
        figures = Misfit(belief.bend_m, belief.residual_m, unrest_rad).figures
        information = wall_information(plan, recent, A_plan_odom, xy_odom)
        signs = Signs(information, figures, unrest_rad)
        return packaged_uncertainty().spread(signs, xy_odom, submap.stamp_ns)
