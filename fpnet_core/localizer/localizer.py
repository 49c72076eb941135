# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stateful localizer used by the node, the command line and the benchmarks."""

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

_NEWS_NS = 5 * NS_PER_S  # chosen: repeated odometry resets within this time are logged once


@dataclass(frozen=True, eq=False)
class Snapshot:
    """An output, and the ``plan`` that it refers to; None: no plan."""

    output: LocalizerOutput
    plan: Floorplan | None = None


class Localizer:
    """
    Localizes the robot on a floorplan from registered scans.

    The function :func:`fpnet_core.localizer.update.update` makes all decisions without side
    effects; this object holds the state between calls. All methods are thread-safe:
    ``add_scan`` never waits for a running ``update``, and an update whose floorplan, odometry
    frame or hint changes while it runs is discarded. The same calls give the same outputs.

    Parameters
    ----------
    config : configuration tree
    matcher : graph matcher
    """

    def __init__(self, config: FpnetConfig, matcher: RegionMatcher) -> None:
        self._config = config
        scorer = PlacementScorer.configured(config.localizer)
        self._global_localizer = GlobalLocalizer(matcher, scorer, config)
        self._update_lock = threading.Lock()  # serialises updates: matchers are not thread-safe
        self._lock = threading.Lock()  # guards all members below, held briefly
        self._builder = SubmapBuilder(config.submap)
        self._mount = MountVotes()
        self._monitor = OdometryMonitor(config.localizer)
        self._last_reset = '', 0  # reason and stamp of the last odometry reset
        self._submap: Submap | None = None
        self._state = UpdateState()
        self._is_solved = False  # nothing has changed since the last update
        self._restored: SavedState | None = None  # until its floorplan is set
        self._snapshot = Snapshot(LocalizerOutput(0, Status.NO_PLAN, reason=NO_PLAN))
        self._walls = KnownWalls()

    @property
    def plan(self) -> PreparedMap | None:
        """The prepared floorplan in nominal metres, None before the first one."""
        plan = self._state.plan
        return None if plan is None else plan.nominal

    @property
    def output(self) -> LocalizerOutput:
        """Output of the newest update."""
        return self._snapshot.output

    @property
    def snapshot(self) -> Snapshot:
        """Newest output and the plan that it refers to."""
        return self._snapshot

    def set_plan(
        self,
        grid: GridMap,
        scale: ScaleEstimate | None = None,
        policy: ScalePolicy | None = None,
    ) -> None:
        """
        Set the floorplan, replacing all previous ones; the submap is kept.

        ``scale`` is the prior used if the scale is unknown; None: estimate it from rooms and
        doors. ``policy`` is the scale policy; None: as configured.

        Raises
        ------
        MapFormatError
            If the drawing contains no room; the old plan is kept.
        """
        self.set_storeys([StoreyPlan('', grid, scale, policy)])

    def set_storeys(self, storeys: Sequence[StoreyPlan]) -> None:
        """
        Set the storeys of a site, replacing all floorplans; the submap is kept.

        The robot is on one of them, all equally probable without a hint.

        Raises
        ------
        MapFormatError
            If a drawing contains no room, or there is no drawing; the old plans are kept.
        """
        plans = prepared_storeys(storeys, self._config)
        with self._lock:
            state = self._state.on(*plans)
            if self._restored:
                state = _with_saved(state, self._restored)
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
        viewpoints : (P, 3), origin of each ray, sensor frame [m]; None: the sensor's origin

        Raises
        ------
        CloudFormatError, OdometryError
            If the scan cannot be used; it is dropped and the submap is kept.
        """
        pose = checked_rigid(T_odom_sensor)
        with self._lock:
            look = self._builder.look(points, pose, viewpoints)
            is_placed = self._snapshot.output.A_plan_odom is not None
            broken = self._monitor.check(
                stamp_ns, pose, look.body_xy, self._known(), knows_all=is_placed
            )
            if broken is not None:
                self._on_reset(broken, stamp_ns, pose)
                look = self._builder.look(points, pose, viewpoints)
            self._builder.add(look, stamp_ns)
            self._mount.look(Scan(stamp_ns, points, T_odom_sensor=pose))
            self._monitor.go_on_from(stamp_ns, pose)

    def update(self, now_ns: int) -> LocalizerOutput:
        """
        Segment, match, verify and decide on all observations so far.

        ``now_ns`` stamps the output if there is no scan. Never raises on sensor data; the absence
        of a pose is a status. Without a new scan or plan the last output is returned, because
        the same evidence must not count twice.
        """
        with self._update_lock:
            timer = StageTimer()
            with self._lock:
                with timer.stage('take'):
                    taken = self._builder.take()
                state, last = self._state, self._monitor.last
                if taken is None and self._is_solved:
                    return self._snapshot.output
                self._submap = taken or self._submap
                T_odom_sensor = None if last is None else last[1]
                is_hung = self._mount.is_upside_down
                observation = Observation(now_ns, self._submap, T_odom_sensor, is_hung)
            after, output = update(state, observation, self._global_localizer, timer)
            with self._lock:
                if state is self._state:  # else the update is outdated
                    self._keep(after, output)
                return self._snapshot.output

    def reset(self) -> None:
        """Discard the submap and all placements; keep the plan."""
        with self._lock:
            self._restart()

    def relocalize(self) -> None:
        """Discard all placements; keep the plan and the submap."""
        with self._lock:
            self._begin(self._state.unlocalized())

    def suggest(self, hint: PoseHint) -> None:
        """
        Add a hint about the robot's pose, in the plan's nominal metres.

        The next update tries the placement, and placements elsewhere are scaled down as
        long as one near it fits. Acceptance still requires agreement with the walls, and an
        accepted placement is kept unless the walls fit the hint better.
        """
        with self._lock:
            is_accepted = self._snapshot.output.status is Status.LOCALIZED
            state = self._state if is_accepted else self._state.unlocalized()
            hinted = state.with_hint(hint)
            if hinted.track.is_accepted:
                self._state, self._is_solved = hinted, False
            else:
                self._begin(hinted)

    def follow(self, thresholds: LocalizerConfig) -> None:
        """
        Set new thresholds, effective from the next scan and update.

        The scale policy applies to the next floorplan; the scorer and its prior are kept.
        """
        with self._lock:
            self._config = self._config.model_copy(update={'localizer': thresholds})
            self._global_localizer = replace(self._global_localizer, config=self._config)
            self._monitor.follow(thresholds)

    def suggest_storey(self, weights: Mapping[str, float]) -> None:
        """
        Add a hint about the storey; the submap and the results on each storey are kept.

        Parameters
        ----------
        weights : of every storey, by name; they need not sum to one. Acceptance still requires
            agreement with the walls; only between equal storeys the weights alone decide.

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
        Report that the robot has left its storey: the submap ends, and a new one begins.

        ``weights`` are those of the possible storeys, as in :meth:`suggest_storey`; ``starts`` are
        placements ``A_plan_odom``, nominal metres, to try first.
        """
        with self._lock:
            check_weights(weights, self._state.storeys)
            self._restart(why)
            self._begin(self._state.weighed(weights).starting(starts or {}), anew(why))

    def restart_odometry(self) -> None:
        """Report that the next scan has a new odometry frame; the submap ends with the old one."""
        with self._lock:
            self._monitor.expect_new_frame()

    def save_state(self, path: Path | str, odometry: str = '') -> None:
        """
        Save submap, placements and scale for :meth:`load_state`.

        ``odometry`` identifies the run of the odometry of the scans; empty: unknown.

        Raises
        ------
        StateError
            If there was no scan yet, or the file cannot be written.
        """
        with self._lock:
            if self._monitor.last is None:
                raise StateError('nothing to save: no scan was received yet')
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
        Continue from a saved state; its placements are used once their floorplan is set.

        The status is not restored: it needs new scans that agree. Returns the run of the odometry
        at the time of saving. Unless that run continues, call :meth:`restart_odometry` before the
        next scan; then a new submap begins and tries the last placements first. A scan too far
        from the last one also begins a new submap.

        Raises
        ------
        StateError
            If the file is unusable or has another resolution; the localizer is unchanged.
        """
        saved = read_state(path)
        if saved.resolution_m != self._config.submap.resolution_m:
            raise StateError(
                f'{path} was saved with submap.resolution_m {saved.resolution_m:g}, now it is '
                f'{self._config.submap.resolution_m:g}; use the same value, or remove the file'
            )
        try:
            builder = SubmapBuilder.restored(self._config.submap, saved.submap)
        except (KeyError, ValueError, OdometryError) as error:
            raise StateError(f'{path} is damaged: {error}; remove it') from None
        with self._lock:
            self._restart()
            self._builder, self._restored = builder, saved
            self._monitor.go_on_from(saved.stamp_ns, saved.T_odom_sensor)
        return saved.odometry

    def _known(self) -> MapEvidence | None:
        """Return the known walls near the robot's last position."""
        said, last, recent = self._snapshot, self._monitor.last, self._builder.recent_xy
        if last is None:
            return None
        drawn = None if said.plan is None else said.plan.nominal.evidence.walls
        return self._walls.around(last[1][:2, 3], recent, drawn, said.output.A_plan_odom)

    def _keep(self, state: UpdateState, output: LocalizerOutput) -> None:
        """Store the result of an update."""
        self._state, self._is_solved = state, True
        if state.is_elsewhere:
            _log.warning('the newest scans contradict the pose; starting a new submap')
            self._restart(CONTRADICTED)
        else:
            # The next update may concern another storey than this output.
            on = (plan for plan in state.storeys if plan.name == output.storey)
            self._snapshot = Snapshot(output, next(on, state.plan))

    def _on_reset(self, broken: OdometryReset, stamp_ns: int, pose: NDArray[np.float64]) -> None:
        """
        Start a new submap, with the placements transformed to the new odometry frame.

        The last accepted pose becomes a hint there, weighted by its probability and by that of the
        transform to the new frame.
        """
        kind, (last_kind, last_ns) = re.sub(r'\d+', '', broken.reason), self._last_reset
        if kind != last_kind or not 0 <= stamp_ns - last_ns < _NEWS_NS:
            _log.warning('%s; starting a new submap', broken.reason)
        self._last_reset = kind, stamp_ns
        tracked, restored, said = self._state.tracked, self._restored, self._snapshot.output
        self._restart(broken.reason)
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

    def _restart(self, why: str = '') -> None:
        self._builder.reset()
        self._submap = self._restored = None
        self._monitor.forget()
        self._begin(self._state.without_submap(), anew(why) if why else NOT_LOOKED)

    def _begin(self, state: UpdateState, why: str = NOT_LOOKED) -> None:
        """Continue from a state without an accepted pose; a running update becomes outdated."""
        self._state, self._is_solved = state, False
        status, why = (Status.NO_PLAN, NO_PLAN) if state.plan is None else (Status.WAITING, why)
        output = LocalizerOutput(self._snapshot.output.stamp_ns, status, reason=why)
        self._snapshot = Snapshot(output, state.plan)


def _with_saved(state: UpdateState, saved: SavedState) -> UpdateState:
    """Return the initial state on floorplans, with a saved state if it fits one of them."""
    known = [plan for plan in state.storeys if plan_fingerprint(plan.given) == saved.plan]
    if not known:
        return state
    state, plan = state.about(known[0].name), known[0]
    scale = plan.scale.remembered(saved.scale, plan.factor)
    return replace(state, plan=replace(plan, scale=scale), tracked=saved.placements)
