# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The one stateful object that a node, the command line and the benchmarks drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import logging
from pathlib import Path
import re
import threading

import numpy as np
from numpy.typing import NDArray
from scipy.special import logit

from fpnet_core.config import FpnetConfig, LocalizerConfig, ScalePolicy
from fpnet_core.doctor.sensor import MountVotes
from fpnet_core.errors import OdometryError, StateError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.geometry.rigid3d import checked_rigid
from fpnet_core.io.scans import Scan
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.global_localizer import GlobalLocalizer
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.odometry_monitor import KnownWalls, OdometryMonitor, OdometryReset
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.localizer.state import SavedState, plan_fingerprint, read_state, write_state
from fpnet_core.localizer.storeys import StoreyPlan, check_weights, prepared_storeys
from fpnet_core.localizer.update import update
from fpnet_core.localizer.update_state import Observation, UpdateState
from fpnet_core.matching import RegionMatcher
from fpnet_core.pose import MapEvidence, PreparedMap
from fpnet_core.scoring import WORD, PlacementScorer
from fpnet_core.scoring.reasons import CONTRADICTED, NO_PLAN, NOT_LOOKED, anew
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.stamps import NS_PER_S
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import GridMap, LocalizerOutput, Status, Submap

_log = logging.getLogger(__name__)

_NEWS_NS = 5 * NS_PER_S  # chosen: odometry that breaks again so soon is no news


@dataclass(frozen=True, eq=False)
class Snapshot:
    """What may be said at one moment: an output, and the ``plan`` that it is on; None: none."""

    output: LocalizerOutput
    plan: Floorplan | None = None


class Localizer:
    """
    Finds the robot on a floorplan from registered scans.

    :func:`fpnet_core.localizer.update.update`, a function of values, makes all decisions; this
    object holds their state between calls. Every method may be called from any thread:
    ``add_scan`` never waits for a running ``update``, and an update whose floorplan, odometry
    frame or hint changes while it runs is discarded. The same calls give the same outputs.

    Parameters
    ----------
    config : the configuration tree
    matcher : the graph matcher to use
    """

    def __init__(self, config: FpnetConfig, matcher: RegionMatcher) -> None:
        self._config = config
        scorer = PlacementScorer.configured(config.localizer)
        self._global_localizer = GlobalLocalizer(matcher, scorer, config)
        self._ticking = threading.Lock()  # one tick after the other: matchers are not shared
        self._lock = threading.Lock()  # of all that follows, held for moments only
        self._builder = SubmapBuilder(config.submap)
        self._mount = MountVotes()
        self._monitor = OdometryMonitor(config.localizer)
        self._broken = '', 0  # why and when the last new odometry frame began
        self._submap: Submap | None = None
        self._state = UpdateState()
        self._is_solved = False  # a tick has seen all that there is
        self._restored: SavedState | None = None  # until its floorplan has come
        self._said = Snapshot(LocalizerOutput(0, Status.NO_PLAN, reason=NO_PLAN))
        self._walls = KnownWalls()

    @property
    def plan(self) -> PreparedMap | None:
        """The prepared floorplan in nominal metres, None before the first one."""
        plan = self._state.plan
        return None if plan is None else plan.nominal

    @property
    def output(self) -> LocalizerOutput:
        """The newest tick's output."""
        return self._said.output

    @property
    def snapshot(self) -> Snapshot:
        """The newest output and the plan that it is on."""
        return self._said

    def set_plan(
        self,
        grid: GridMap,
        scale: ScaleEstimate | None = None,
        policy: ScalePolicy | None = None,
    ) -> None:
        """
        Take a floorplan, replacing the old ones; the submap is kept.

        ``scale`` is what is known of its scale, and asked where that is unknown; None takes what
        its rooms and doors say. ``policy`` is how far it is trusted, None: as configured.

        Raises
        ------
        MapFormatError
            If the drawing holds no room; the old plan stays in force.
        """
        self.set_storeys([StoreyPlan('', grid, scale, policy)])

    def set_storeys(self, storeys: Sequence[StoreyPlan]) -> None:
        """
        Take the storeys of a site, replacing all floorplans; the submap is kept.

        The robot is on one of them, each as probable as the others until somebody says more.

        Raises
        ------
        MapFormatError
            If a drawing holds no room, or there is none; the old ones stay in force.
        """
        plans = prepared_storeys(storeys, self._config)
        with self._lock:
            state = self._state.on(*plans)
            if self._restored:
                state = _remembering(state, self._restored)
            self._restored = None
            self._begin(state)

    def add_scan(
        self,
        points: NDArray[np.float32],
        T_odom_sensor: NDArray[np.float64],
        stamp_ns: int,
        viewpoints: NDArray[np.float32] | None = None,
    ) -> None:
        """
        Add one registered scan to the submap.

        Parameters
        ----------
        points : (P, 3) float32, sensor frame, metres
        T_odom_sensor, stamp_ns : (4, 4) rigid, and sensor time
        viewpoints : (P, 3), where each ray began, sensor frame [m]; None: in its origin

        Raises
        ------
        CloudFormatError, OdometryError
            If the scan cannot be used; it is dropped and the submap is kept.
        """
        pose = checked_rigid(T_odom_sensor)
        with self._lock:
            look = self._builder.look(points, pose, viewpoints)
            is_placed = self._said.output.A_plan_odom is not None
            broken = self._monitor.check(
                stamp_ns, pose, look.body_xy, self._known(), knows_all=is_placed
            )
            if broken is not None:
                self._bridge(broken, stamp_ns, pose)
                look = self._builder.look(points, pose, viewpoints)
            self._builder.add(look, stamp_ns)
            self._mount.look(Scan(stamp_ns, points, T_odom_sensor=pose))
            self._monitor.go_on_from(stamp_ns, pose)

    def update(self, now_ns: int) -> LocalizerOutput:
        """
        Segment, match, verify and decide on what has been seen so far.

        ``now_ns`` stamps the output while there is no scan. Never raises on what sensors send;
        "no answer" is a status. Without a new scan or plan the last output stands: the same
        evidence confirms nothing twice.
        """
        with self._ticking:
            timer = StageTimer()
            with self._lock:
                with timer.stage('take'):
                    taken = self._builder.take()
                state, last = self._state, self._monitor.last
                if taken is None and self._is_solved:
                    return self._said.output
                self._submap = taken or self._submap
                T_odom_sensor = None if last is None else last[1]
                is_hung = self._mount.is_upside_down
                observation = Observation(now_ns, self._submap, T_odom_sensor, is_hung)
            after, output = update(state, observation, self._global_localizer, timer)
            with self._lock:
                if state is self._state:  # else it was overtaken
                    self._keep(after, output)
                return self._said.output

    def reset(self) -> None:
        """Forget the submap and every placement; the plan stays."""
        with self._lock:
            self._start_anew()

    def relocalize(self) -> None:
        """Forget every placement and claim; plan and submap stay."""
        with self._lock:
            self._begin(self._state.unlocalized())

    def suggest(self, hint: PoseHint) -> None:
        """
        Take someone's word on where the robot is, in the plan's nominal metres.

        The placement is tried with the next tick, and placements elsewhere count for little as
        long as one near it fits. A claim still needs the walls to agree, and one that was made
        stands unless they agree with the word rather.
        """
        with self._lock:
            is_accepted = self._said.output.status is Status.LOCALIZED
            state = self._state if is_accepted else self._state.unlocalized()
            hinted = state.with_hint(hint)
            if hinted.track.is_accepted:
                self._state, self._is_solved = hinted, False
            else:
                self._begin(hinted)

    def follow(self, thresholds: LocalizerConfig) -> None:
        """
        Take other thresholds, from the next scan and tick on.

        The scale policy holds for the next floorplan; the judge and its prior stay.
        """
        with self._lock:
            self._config = self._config.model_copy(update={'localizer': thresholds})
            self._global_localizer = replace(self._global_localizer, config=self._config)
            self._monitor.follow(thresholds)

    def suggest_storey(self, weights: Mapping[str, float]) -> None:
        """
        Take someone's word on the storey; the submap and what was seen on each stay.

        Parameters
        ----------
        weights : of every storey, by name; they need not add up to one. A claim still needs the
            walls to agree, and equal storeys are told apart by this alone.

        Raises
        ------
        HintError
            If a storey is missing or unknown, or a weight is not positive.
        """
        with self._lock:
            check_weights(weights, self._state.storeys)
            self._begin(self._state.weighed(weights))

    def leave_storey(
        self, weights: Mapping[str, float], why: str, starts: Mapping[str, Affine2D] | None = None
    ) -> None:
        """
        Say that the robot has left its storey: the submap ends, and the next one begins.

        ``weights`` are those of where it may be now, as of :meth:`suggest_storey`; ``starts`` are
        placements ``A_plan_odom``, nominal metres, to try first.
        """
        with self._lock:
            check_weights(weights, self._state.storeys)
            self._start_anew(why)
            self._begin(self._state.weighed(weights).starting(starts or {}), anew(why))

    def restart_odometry(self) -> None:
        """Say that the next scan comes with a new odometry frame; the submap ends with it."""
        with self._lock:
            self._monitor.expect_new_frame()

    def save_state(self, path: Path | str, odometry: str = '') -> None:
        """
        Write submap, placements and scale for :meth:`load_state`.

        ``odometry`` names the run of the odometry that the scans came with; empty: unknown.

        Raises
        ------
        StateError
            If there was no scan yet, or the file cannot be written.
        """
        with self._lock:
            if self._monitor.last is None:
                raise StateError('nothing to save: no scan has come yet')
            plan = self._state.plan
            saved = SavedState(
                self._config.submap.resolution_m,
                *self._monitor.last,
                self._state.tracked,
                '' if plan is None else plan_fingerprint(plan.given),
                self._builder.arrays(),
                {} if plan is None else plan.scale.arrays(plan.factor),
                odometry,
            )
        write_state(path, saved)

    def load_state(self, path: Path | str) -> str:
        """
        Go on where a saved localizer was; its placements count once their floorplan is set.

        Claims are not restored: they need fresh scans that agree. Returns the run of the odometry
        that it was saved with: unless that has gone on meanwhile, say so before the next scan
        (:meth:`restart_odometry`), and a new submap begins, the last placements tried first. A
        scan that is too far from the last one begins a new submap as well.

        Raises
        ------
        StateError
            If the file is unusable or was made with another resolution; nothing has changed.
        """
        saved = read_state(path)
        if saved.resolution_m != self._config.submap.resolution_m:
            raise StateError(
                f'{path} was saved with submap.resolution_m {saved.resolution_m:g}, this is '
                f'{self._config.submap.resolution_m:g}; use the same, or remove the file'
            )
        try:
            builder = SubmapBuilder.restored(self._config.submap, saved.submap)
        except (KeyError, ValueError, OdometryError) as error:
            raise StateError(f'{path} is damaged: {error}; remove it') from None
        with self._lock:
            self._start_anew()
            self._builder, self._restored = builder, saved
            self._monitor.go_on_from(saved.stamp_ns, saved.T_odom_sensor)
        return saved.odometry

    def _known(self) -> MapEvidence | None:
        """Return the walls that are known where the robot was last."""
        said, last, recent = self._said, self._monitor.last, self._builder.recent_xy
        if last is None:
            return None
        drawn = None if said.plan is None else said.plan.nominal.evidence.walls
        return self._walls.around(last[1][:2, 3], recent, drawn, said.output.A_plan_odom)

    def _keep(self, state: UpdateState, output: LocalizerOutput) -> None:
        """Take what a tick has led to."""
        self._state, self._is_solved = state, True
        if state.is_elsewhere:
            _log.warning('the robot is not where it was taken to be; starting anew')
            self._start_anew(CONTRADICTED)
        else:
            # The next tick may be about another storey than this one's output is on.
            on = (plan for plan in state.storeys if plan.name == output.storey)
            self._said = Snapshot(output, next(on, state.plan))

    def _bridge(self, broken: OdometryReset, stamp_ns: int, pose: NDArray[np.float64]) -> None:
        """
        Start anew, with the placements where they would be in the new frame.

        A claim tells where the robot is there, as surely as it stood and the walls have shown
        where the new frame lies.
        """
        kind, (last_kind, last_ns) = re.sub(r'\d+', '', broken.reason), self._broken
        if kind != last_kind or not 0 <= stamp_ns - last_ns < _NEWS_NS:
            _log.warning('%s; starting anew', broken.reason)
        self._broken = kind, stamp_ns
        tracked, restored, said = self._state.tracked, self._restored, self._said.output
        self._start_anew(broken.reason)
        if broken.T_old_new is not None:
            self._state = replace(self._state, tracked=tracked @ broken.T_old_new)
            if restored is not None:
                moved = restored.placements @ broken.T_old_new
                self._restored = replace(restored, placements=moved)
            T_odom_sensor = SE2.from_matrix4(pose)
            T_plan_sensor = said.pose((broken.T_old_new @ T_odom_sensor).as_matrix4())
            log_odds = min(WORD, float(logit(said.probability * broken.probability)))
            if T_plan_sensor is not None and log_odds > 0.0:
                hint = PoseHint(
                    T_plan_sensor, T_odom_sensor, storey=said.storey, log_odds=log_odds
                )
                self._state = self._state.with_hint(hint)

    def _start_anew(self, why: str = '') -> None:
        self._builder.reset()
        self._submap = self._restored = None
        self._monitor.forget()
        self._begin(self._state.without_submap(), anew(why) if why else NOT_LOOKED)

    def _begin(self, state: UpdateState, why: str = NOT_LOOKED) -> None:
        """Go on from a state without claims: a tick at work is overtaken, its output outdated."""
        self._state, self._is_solved = state, False
        status, why = (Status.NO_PLAN, NO_PLAN) if state.plan is None else (Status.WAITING, why)
        output = LocalizerOutput(self._said.output.stamp_ns, status, reason=why)
        self._said = Snapshot(output, state.plan)


def _remembering(state: UpdateState, saved: SavedState) -> UpdateState:
    """Return the beginning on floorplans, of which a saved localizer may have known one."""
    known = [plan for plan in state.storeys if plan_fingerprint(plan.given) == saved.plan]
    if not known:
        return state
    state, plan = state.about(known[0].name), known[0]
    scale = plan.scale.remembered(saved.scale, plan.factor)
    return replace(state, plan=replace(plan, scale=scale), tracked=saved.placements)
