# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node that localizes a robot on a floorplan from registered scans and odometry."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import replace
from functools import lru_cache
from threading import Lock

from rclpy.clock import Clock, ClockType

from fpnet_core.config import FpnetConfig, ScalePolicy
from fpnet_core.errors import FpnetError
from fpnet_core.io.sessions import TICK_NAME, TICKS_NAME
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.guidance import NextLook, next_look
from fpnet_core.localizer.localizer import Snapshot
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.localizer.warm_up import warm_up
from fpnet_core.sites.site_localizer import create_site_localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.checkup import Checkup
from fpnet_ros.floorplans import FloorplanInput, ServedPlan, StoreyTopics
from fpnet_ros.health import DIAGNOSTICS_PERIOD_S, Health
from fpnet_ros.inputs import LocatedScan, ScanInput
from fpnet_ros.lifecycle import ManagedNode, run_managed
from fpnet_ros.logs import NodeLog, one_line
from fpnet_ros.outputs import LocalizerOutputs, StampedOutput
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import NO_TF, TFMessage
from fpnet_ros.services import (
    InitialPoses,
    LocalizeAction,
    offer_save_state,
    offer_services,
)
from fpnet_ros.settings import LIVE, LIVE_CONFIG, LocalizerParameters
from fpnet_ros.state_file import RunFolder, StateFile
from fpnet_ros.work import DroppingWorker, Worker
from msg_adapters.diagnostics import LocalizerReport


class LocalizerNode(ManagedNode):
    """
    Runs one :class:`fpnet_core.localizer.Localizer`.

    Three threads: the executor's handles messages, services and TF; a second one adds scans; a
    third one runs updates, new floorplans and saves in sequence, so that slow work does not block
    the first. Any of them may publish. docs/ros.md describes topics, services and parameters.
    """

    def __init__(self) -> None:
        super().__init__('localizer')
        follow = self._follow_parameters
        self._settings = ParameterTree(self, LocalizerParameters, live=LIVE, on_change=follow)
        self._config = ParameterTree(
            self, FpnetConfig, without=('odometry',), live=LIVE_CONFIG, on_change=follow
        )
        self._is_configured = False
        offer_save_state(self, lambda: self._settings.value.state_file, self._save)
        self._action = LocalizeAction(self, self._relocalize)

    def prepare(self) -> None:
        """Compile the kernels."""
        localizer = create_localizer(self._config.value)
        self.get_logger().info('compiling; the first start after an installation takes longer')
        warm_up(localizer)

    def configure(self) -> None:
        """Load the weights and connect; raise FpnetError for a bad parameter or file."""
        config, parameters, logger = self._config.value, self._settings.value, self.get_logger()
        self._log, self._publishing = NodeLog(logger, self.context.ok), Lock()
        self._frame: MapFrame | None = None  # of the floorplan
        self._shown: MapFrame | None = None
        self._newest: LocatedScan | None = None  # scan that was added last
        self._told: LocalizerReport | None = None  # of the last update
        self._next_look = lru_cache(maxsize=1)(self._look_on)
        self._update: Future[None] | None = None
        self._saving: Future[str] | None = None
        self._localizer = localizer = create_site_localizer(config)
        if TFMessage is None and parameters.sends_tf:
            logger.warning(f'no TF: {NO_TF}')
        self._run_folder = RunFolder(parameters.run_dir, logger)
        self.add_end(lambda: self._run_folder.write(TICK_NAME, localizer.output))
        self._out = LocalizerOutputs(self, parameters.path_spacing_m)
        self._storeys = StoreyTopics(self, localizer, config, parameters)
        self._updates = Worker('updates', self._log.report)
        self.add_end(self._updates.close)
        waiting = parameters.max_pending_scans
        self._scans = DroppingWorker(self._add_scan, waiting, self._log.report)
        self.add_end(self._scans.close)
        hooks, stamp = (self._on_scan, self._on_restart), config.scans.stamp
        hear = lambda stamp_ns: self.is_active and self._checkup.hear(stamp_ns)  # noqa: E731
        inputs = ScanInput(self, parameters, *hooks, self._log, stamp, hear)
        self._health = Health(inputs, self._scans, self.get_clock(), self._log)
        # At cleanup it is saved before waiting for the threads.
        path, run = parameters.state_file, inputs.odometry_run
        self._state_file = StateFile(path, localizer, run, logger)
        self.add_end(lambda: self._newest and self._state_file.save())
        self._state_file.restore()
        self._checkup = Checkup(self, inputs.topics)
        if not parameters.site:
            FloorplanInput(self, self._on_floorplan, self._log.report)
        # Hints refer to a floorplan and a scan.
        situation, named = lambda: (self._frame, self._newest), self._storeys.frame_named
        first = parameters.first_pose
        self._hints = InitialPoses(situation, named, localizer.suggest, logger, first)
        acts = self._relocalize, localizer.reset, self._update_now
        offer_services(self, self._hints, *acts, is_amcl_there=parameters.hand_over)
        self._add_timers(config.localizer.update_period_s, parameters)
        self._is_configured = True
        self._settings.is_frozen = self._config.is_frozen = True

    def activate(self) -> None:
        """Publish the status, which an inactive node does not publish."""
        self._publish()

    def deactivate(self) -> None:
        """Stop publishing; the result of a running update is discarded."""
        self._action.stop()
        with self._publishing:
            self._out.forget_pose()

    def cleanup(self) -> None:
        """Abort goals, and allow all parameters to change again."""
        self._action.stop()
        self._is_configured = self._settings.is_frozen = self._config.is_frozen = False

    def _add_timers(self, update_period_s: float, parameters: LocalizerParameters) -> None:
        # The timers on the steady clock also run while simulated time stands still.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._update_timer = self.add_timer(update_period_s, self._start_update)
        self._tf_timer = self.add_timer(1.0 / parameters.tf_rate_hz, self._follow, steady)
        self.add_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics, steady)
        if parameters.state_file and parameters.autosave_period_s:
            self.add_timer(parameters.autosave_period_s, self._autosave, steady)

    def _follow_parameters(self) -> None:
        if not self._settings.is_frozen:  # configure() will read them
            return
        thresholds, parameters = self._config.value.localizer, self._settings.value
        self._update_timer.timer_period_ns = round(thresholds.update_period_s * NS_PER_S)
        self._tf_timer.timer_period_ns = round(NS_PER_S / parameters.tf_rate_hz)
        self._out.path_spacing_m = parameters.path_spacing_m
        self._localizer.follow(thresholds)

    # ---- inputs, services and timers: the executor's thread

    def _on_scan(self, scan: LocatedScan) -> None:
        if self.is_active:
            self._state_file.before_scan()
            self._scans.put(scan)

    def _on_restart(self) -> None:
        self.get_logger().warning('another process publishes the odometry now')
        self._localizer.restart_odometry()

    def _on_floorplan(self, plan: ServedPlan) -> None:
        policy = self._config.value.localizer.scale_policy
        self._updates.submit(self._take_floorplan, plan, policy)

    def _relocalize(self) -> None:
        self._localizer.relocalize()
        if self.is_active:
            self._publish()

    def _update_now(self) -> None:
        if self.is_active:  # queued after a running update, which lacks the newest scans
            self._update = self._updates.submit(self._run_update)

    def _save(self) -> Future[str] | None:
        return self._updates.submit(self._state_file.save) if self._is_configured else None

    def _start_update(self) -> None:
        if self.is_active and (self._update is None or self._update.done()):
            self._update = self._updates.submit(self._run_update)

    def _follow(self) -> None:
        """Broadcast post-dated TF while scans arrive; publish when they stop or resume."""
        settings, health, now_ns = self._settings.value, self._health, self._now_ns()
        if self.is_active and health.has_turned(now_ns, settings.scan_timeout_s):
            self._publish()
        if settings.sends_tf and now_ns and not health.is_starved:
            self._out.broadcast(now_ns + round(settings.transform_tolerance * NS_PER_S))
        self._hints.follow()
        if self._told is not None:
            self._action.follow(self._told, None if health.is_starved else self._out.accepted)

    def _publish_diagnostics(self) -> None:
        stale_s = self._settings.value.stale_input_s
        self._state_file.follow_odometry()
        if self.is_active and self._log.silences(self._health.silence_s, stale_s):
            self._publish()  # no update runs while the clock stands still
        news = self._storeys.noted(self._health.news(self._localizer.output, stale_s))
        self._out.publish_diagnostics(news, self._checkup.findings(), self._now_ns())

    def _autosave(self) -> None:
        is_free = self._saving is None or self._saving.done()  # a slow disk delays no update
        if is_free and self.is_active and self._newest is not None:
            self._saving = self._save()

    # ---- scans: their own thread

    def _add_scan(self, scan: LocatedScan) -> None:
        cloud = scan.unpack()
        self._checkup.look(scan, cloud.points)
        self._localizer.add_scan(cloud.points, scan.T_odom_sensor, scan.stamp_ns, cloud.viewpoints)
        self._newest = scan
        self._health.saw_scan(self._now_ns())
        self._publish_pose()

    # ---- updates and floorplans: their own thread

    def _run_update(self) -> None:
        before = self._localizer.output
        output = self._localizer.update(self._now_ns())
        self._publish()
        if output is not before:
            self._storeys.publish_differences(self._localizer.snapshot, self._frame)
            self._run_folder.write(f'{TICKS_NAME}/{output.stamp_ns:020d}.npz', output)

    def _take_floorplan(self, plan: ServedPlan, policy: ScalePolicy) -> None:
        """Pass a floorplan to the localizer; if that refuses it, the old one stays."""
        try:
            plan.give_to(self._localizer, policy)
        except FpnetError as error:
            self.get_logger().error(one_line(error))
            return
        self._out.forget_path()
        said = f'{plan.frame_id}{plan.said_of_scale}'
        self.get_logger().info(f'received the floorplan in frame {said}')
        self._show(MapFrame(plan.grid, plan.frame_id, self._settings.value.map_frame))
        self._publish()

    # ---- publishing: any thread

    def _publish(self) -> None:
        """Publish pose, status and the other results of an update."""
        changed = self._storeys.follow(self._localizer.snapshot)
        if changed is not None:
            self._out.forget_path()
            self._show(changed)
        frame, A_plan_odom = self._frame, self._localizer.output.A_plan_odom
        if frame is not None:
            self._show(frame if A_plan_odom is None else frame.followed(A_plan_odom))
        look = self._next_look(snapshot := self._localizer.snapshot)
        stamped = self._publish_pose()  # the update may have located the newest scan
        report = self._health.report(stamped.output, self._settings.value.stale_input_s)
        report = self._storeys.noted(report)
        is_its = look is not None and snapshot is stamped.snapshot
        if is_its and not self._health.is_starved:
            stamped, report = replace(stamped, look=look), replace(report, look=look.words)
        self._told = report
        self._log.status(report)
        self._out.publish_status(report)
        self._out.publish_tick(stamped)

    def _publish_pose(self) -> StampedOutput:
        """Publish the pose from the current values, and return those."""
        with self._publishing:  # so that threads publish in the order of their values
            stamped = StampedOutput.of(self._localizer.snapshot, self._frame, self._newest)
            if self.is_active:
                self._out.publish_pose(stamped)
        return stamped

    def _look_on(self, snapshot: Snapshot) -> NextLook | None:
        """Return where to look next; computed once for each snapshot."""
        plan, scan = snapshot.plan, self._newest
        if plan is None or scan is None:
            return None
        return next_look(plan.nominal.evidence, snapshot.output, scan.T_odom_base)

    def _show(self, frame: MapFrame) -> None:
        """Set the frame ``map``; publish the floorplan in it if it has changed."""
        self._frame = frame
        # An inactive node's publishers drop messages: its floorplan is published on activation.
        if frame is not self._shown and self.is_active:
            self._shown = frame
            self._out.publish_scaled(frame, self._now_ns())

    def _now_ns(self) -> int:
        return self.get_clock().now().nanoseconds


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_managed(LocalizerNode, arguments)
