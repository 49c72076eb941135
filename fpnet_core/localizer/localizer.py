# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The one stateful object that a node, the command line and the benchmarks drive."""

from __future__ import annotations

from dataclasses import replace
import logging
from pathlib import Path
import threading

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import OdometryError, StateError
from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.geometry.rigid3d import checked_rigid
from fpnet_core.judging import Judge
from fpnet_core.judging.reasons import CONTRADICTED, NO_PLAN, NOT_LOOKED, anew, waiting
from fpnet_core.localizer.belief import Belief, HypothesisTracker
from fpnet_core.localizer.continuity import Break, Continuity
from fpnet_core.localizer.diagnosis import Compared, causes_of_look, causes_of_waiting
from fpnet_core.localizer.finder import Comparison, Finder
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.scale import ScaleSearch
from fpnet_core.localizer.search import Searched
from fpnet_core.localizer.sides import RobotXY, StageTimer, prepare_submap
from fpnet_core.localizer.state import LocalizerState, plan_fingerprint, read_state, write_state
from fpnet_core.localizer.surroundings import Surroundings
from fpnet_core.matches import MatchResult
from fpnet_core.matching import RegionMatcher
from fpnet_core.pose import MapSide
from fpnet_core.segmentation import ScaleEstimate, SubmapSegmenter
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import GridMap, LocalizerOutput, Status, Submap

_log = logging.getLogger(__name__)

_FOLLOWED = 8  # placements that the next tick refines again; numerical: the claim and its rivals


class Localizer:
    """
    Finds the robot on a floorplan from registered scans.

    ``add_scan`` is cheap and may be called while ``tick`` runs in another thread; ``tick`` does
    the heavy work on a copy of the submap. Given the same calls in the same order the outputs
    are the same, so a recording replays identically offline.

    Parameters
    ----------
    config : the configuration tree
    matcher : the graph matcher to use
    judge : weighs placements; None takes the configured one
    """

    def __init__(
        self, config: FpnetConfig, matcher: RegionMatcher, judge: Judge | None = None
    ) -> None:
        self._config = config
        judge = judge or Judge.configured(config.localizer)
        self._finder = Finder(matcher, judge, config)
        self._lock = threading.Lock()
        self._builder = SubmapBuilder(config.submap)
        self._segmenter = SubmapSegmenter()
        self._tracker = HypothesisTracker(config.localizer, judge)
        self._surroundings = Surroundings(config)
        self._plan: Floorplan | None = None
        self._tracked = Placements.empty()  # A_plan_odom of the last tick's placements
        self._searched: Searched | None = None  # None: the next tick searches
        self._continuity = Continuity(config.localizer)
        self._hint: PoseHint | None = None
        self._restored: LocalizerState | None = None  # until its floorplan has come
        self._submap: Submap | None = None
        self._epoch = 0  # grows when plan or odometry frame are replaced
        self._solved_epoch = -1  # of the last tick
        self._output = LocalizerOutput(0, Status.NO_PLAN, reason=NO_PLAN)

    @property
    def plan(self) -> MapSide | None:
        """The prepared floorplan in nominal metres, None before the first one."""
        return None if self._plan is None else self._plan.nominal

    @property
    def output(self) -> LocalizerOutput:
        """The newest tick's output."""
        return self._output

    def set_plan(self, grid: GridMap, scale: ScaleEstimate | None = None) -> None:
        """
        Take a floorplan, replacing the old one; the submap is kept.

        ``scale`` is what is known of its scale, and asked where the configuration calls that
        unknown; None takes what its rooms and doors say.

        Raises
        ------
        MapFormatError
            If the drawing holds no room; the old plan stays in force.
        """
        plan = Floorplan(grid, self._config, scale)
        with self._lock:
            self._plan = plan
            self._forget_placements()
            if self._restored and self._restored.plan == plan_fingerprint(grid):
                self._tracked = self._restored.placements
            self._restored = None

    def add_scan(
        self, points: NDArray[np.float32], T_odom_sensor: NDArray[np.float64], stamp_ns: int
    ) -> None:
        """
        Add one registered scan to the submap.

        Parameters
        ----------
        points : (P, 3) float32, sensor frame, metres
        T_odom_sensor : (4, 4) rigid
        stamp_ns : sensor time

        Raises
        ------
        CloudFormatError, OdometryError
            If the scan cannot be used; it is dropped and the submap is kept.
        """
        pose = checked_rigid(T_odom_sensor)
        with self._lock:
            broken = self._continuity.check(stamp_ns, pose)
            if broken is not None:
                self._bridge(broken)
            self._builder.add_scan(points, pose, stamp_ns)
            self._continuity.go_on_from(stamp_ns, pose)

    def tick(self, now_ns: int) -> LocalizerOutput:
        """
        Segment, match, verify and decide on what has been seen so far.

        ``now_ns`` stamps the output while there is no scan. Never raises on what sensors send;
        "no answer" is a status. Without a new scan or plan the last output stands: the same
        evidence confirms nothing twice.
        """
        timer = StageTimer()
        with self._lock:
            with timer.stage('take'):
                taken = self._builder.take()
            if taken is None and self._solved_epoch == self._epoch:
                return self._output
            self._submap = taken or self._submap
            plan, submap, epoch = self._plan, self._submap, self._epoch
            segmenter, last = self._segmenter, self._continuity.last
        if plan is None or submap is None or not self._has_seen_enough(submap):
            return self._publish(self._unsolved(now_ns, plan, submap), epoch)
        with timer.stage('total'):
            robot_xy = None if last is None else _planar(submap.T_odom_submap.inv(), last[1])
            output = self._solve(plan, submap, robot_xy, segmenter, epoch, timer)
        return self._publish(output, epoch)

    def reset(self) -> None:
        """Forget the submap and every placement; the plan stays."""
        with self._lock:
            self._start_anew()

    def relocalize(self) -> None:
        """Forget every placement and claim; plan and submap stay."""
        with self._lock:
            self._forget_placements()

    def suggest(self, hint: PoseHint) -> None:
        """
        Take someone's word on where the robot is, in the plan's nominal metres.

        The placement is tried with the next tick, and placements elsewhere are dropped as long
        as one near it fits. A claim still needs the walls to agree.
        """
        with self._lock:
            self._forget_placements()
            if self._plan is not None:
                hint = replace(hint, T_plan_base=self._plan.to_working(hint.T_plan_base))
            self._hint, self._tracked = hint, Placements.of([hint.A_plan_odom])

    def restart_odometry(self) -> None:
        """Say that the next scan comes with a new odometry frame; the submap ends with it."""
        with self._lock:
            self._continuity.expect_new_frame()

    def save_state(self, path: Path | str) -> None:
        """
        Write submap and placements for :meth:`load_state`.

        Raises
        ------
        StateError
            If there was no scan yet, or the file cannot be written.
        """
        with self._lock:
            if self._continuity.last is None:
                raise StateError('nothing to save: no scan has come yet')
            plan = self._plan and plan_fingerprint(self._plan.given)
            state = LocalizerState(
                self._config.submap.resolution_m,
                *self._continuity.last,
                self._tracked,
                plan or '',
                self._builder.arrays(),
            )
        write_state(path, state)

    def load_state(self, path: Path | str) -> None:
        """
        Go on where a saved localizer was; its placements count once their floorplan is set.

        Claims are not restored: they need fresh scans that agree. Odometry must have gone on
        meanwhile; a scan that is too far from the last one starts a new submap.

        Raises
        ------
        StateError
            If the file is unusable or was made with another resolution; nothing has changed.
        """
        state = read_state(path)
        if state.resolution_m != self._config.submap.resolution_m:
            raise StateError(
                f'{path} was saved with submap.resolution_m {state.resolution_m:g}, this is '
                f'{self._config.submap.resolution_m:g}; use the same, or remove the file'
            )
        try:
            builder = SubmapBuilder.restored(self._config.submap, state.submap)
        except (KeyError, ValueError, OdometryError) as error:
            raise StateError(f'{path} is damaged: {error}; remove it') from None
        with self._lock:
            self._start_anew()
            self._builder, self._restored = builder, state
            self._continuity.go_on_from(state.stamp_ns, state.T_odom_sensor)

    def _unsolved(
        self, now_ns: int, plan: Floorplan | None, submap: Submap | None
    ) -> LocalizerOutput:
        """Return the output of a tick that has nothing to compare, or too little."""
        if plan is None:
            return LocalizerOutput(now_ns, Status.NO_PLAN, submap=submap, reason=NO_PLAN)
        seen_m2 = 0.0 if submap is None else submap.free_area_m2
        why = waiting(seen_m2, self._config.localizer.min_explored_m2)
        causes = causes_of_waiting(submap, self._config)
        return LocalizerOutput(now_ns, Status.WAITING, submap=submap, reason=why, causes=causes)

    def _solve(
        self,
        plan: Floorplan,
        submap: Submap,
        robot_xy: RobotXY,
        segmenter: SubmapSegmenter,
        epoch: int,
        timer: StageTimer,
    ) -> LocalizerOutput:
        tracked = self._tracked @ submap.T_odom_submap
        doubts = self._tracker.wants_mirror
        search = plan.scale.search if doubts else plan.scale.search.as_stated
        searched, result = self._placed(plan, submap, tracked, search, robot_xy, segmenter, timer)
        sub = searched.sub
        mirrored = None
        if doubts:
            found = result.estimates.take(slice(1)).scale
            # A drawing both flipped and misstated matters only as a misstated one's rival.
            alike = search.as_stated if search.is_within(found).all() else search
            mirrored = plan.mirrored(sub, submap.free_area_m2, alike, self._finder, timer)
        A_submap_odom = submap.T_odom_submap.inv()
        with self._lock:
            if epoch != self._epoch:  # overtaken: the tracker is that of a later plan or frame
                return self._output
            verdict = result.verdict
            if self._hint is not None:
                agreeing = self._hint.agreeing(verdict.placements, A_submap_odom)
                verdict = self._finder.judge.narrowed(verdict, agreeing)
            belief = self._tracker.update(
                verdict,
                sub.evidence,
                A_submap_odom,
                mirrored,
                robot_xy,
                needs_news=self._hint is None and submap.free_area_m2 < plan.half_area_m2,
                scales=plan.scale.tolerated,
            )
            self._tracked = belief.judged.take(slice(_FOLLOWED)) @ A_submap_odom
            self._searched = searched if self._tracker.is_settled else None
            _follow_scale(plan, belief, sub)
            judged = belief.judged
            belief, A = self._surroundings.judge(plan.working.evidence, submap, belief, robot_xy)
            if self._surroundings.is_elsewhere:
                _log.warning('the robot is not where it was taken to be; starting anew')
                self._start_anew(CONTRADICTED)
        A_plan_odom = None if A is None else plan.to_nominal(A)
        look = Compared(plan.working, sub, submap.free_area_m2, search, verdict)
        return _output(plan, submap, look, result.match, judged, belief, A_plan_odom, timer)

    def _placed(
        self,
        plan: Floorplan,
        submap: Submap,
        tracked: Placements,
        search: ScaleSearch,
        robot_xy: RobotXY,
        segmenter: SubmapSegmenter,
        timer: StageTimer,
    ) -> tuple[Searched, Comparison]:
        """Search the whole plan, or follow what the last search found where that will do."""
        last = self._searched
        if last is not None and last.holds(submap, self._config.localizer):
            return last.followed(
                self._finder, plan.working, submap, tracked, timer, search, robot_xy
            )
        sub = prepare_submap(submap, segmenter, timer)
        result = self._finder.find(
            plan.working, sub, submap.free_area_m2, search, timer, tracked, robot_xy
        )
        return Searched(sub, result.match, submap.free_area_m2), result

    def _publish(self, output: LocalizerOutput, epoch: int) -> LocalizerOutput:
        """Keep the output unless the submap or plan was replaced while it was computed."""
        with self._lock:
            if epoch == self._epoch:
                self._output, self._solved_epoch = output, epoch
            return self._output

    def _has_seen_enough(self, submap: Submap) -> bool:
        return submap.free_area_m2 >= self._config.localizer.min_explored_m2

    def _bridge(self, broken: Break) -> None:
        """Start anew, with the placements where they would be in the new frame."""
        _log.warning('%s; starting anew', broken.reason)
        tracked = Placements.empty()
        if broken.T_old_new is not None:
            tracked = self._tracked @ broken.T_old_new
        self._start_anew(broken.reason)
        self._tracked = tracked

    def _start_anew(self, why: str = '') -> None:
        self._builder.reset()
        # A new one: a tick may be using the old one in another thread.
        self._segmenter = SubmapSegmenter()
        self._submap = None
        self._continuity.forget()
        self._forget_placements(anew(why) if why else NOT_LOOKED)

    def _forget_placements(self, why: str = NOT_LOOKED) -> None:
        self._epoch += 1
        self._tracker.reset()
        self._surroundings.reset()
        self._tracked, self._searched, self._hint = Placements.empty(), None, None
        has_plan = self._plan is not None
        status, why = (Status.WAITING, why) if has_plan else (Status.NO_PLAN, NO_PLAN)
        self._output = LocalizerOutput(self._output.stamp_ns, status, reason=why)


def _planar(T_submap_odom: SE2, T_odom_sensor: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where the sensor is in the submap, ``(2,)``."""
    return T_submap_odom.apply(T_odom_sensor[:2, 3])


def _follow_scale(plan: Floorplan, belief: Belief, sub: MapSide) -> None:
    """Let claims measure the plan's scale; being ambiguous again says nothing about it."""
    if belief.status is Status.LOCALIZED and belief.best is not None:
        plan.scale.follow(belief.best.A_plan_submap, sub.evidence.walls, belief.bend_m)
    elif belief.status is not Status.AMBIGUOUS:
        plan.scale.forget()


def _output(
    plan: Floorplan,
    submap: Submap,
    look: Compared,
    match: MatchResult,
    judged: Placements,
    belief: Belief,
    A_plan_odom: Affine2D | None,
    timer: StageTimer,
) -> LocalizerOutput:
    estimates = plan.nominal_estimates(judged)
    # The belief's best is the first estimate wherever something is claimed.
    best = estimates[0] if belief.status is Status.LOCALIZED else None
    return LocalizerOutput(
        stamp_ns=submap.stamp_ns,
        status=belief.status,
        A_plan_odom=A_plan_odom,
        cov=best.cov if best else None,
        probability=belief.probability,
        estimates=estimates,
        match=match,
        segmentation=look.sub.segmentation,
        graph=look.sub.graph,
        submap=submap,
        timings_ms=timer.timings_ms,
        scale=plan.nominal_scale(),
        reason=belief.reason,
        is_mirrored=belief.is_mirrored,
        causes=causes_of_look(look, belief.status, belief.is_mirrored),
    )
