# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Localise a robot on a floorplan from registered scans and odometry."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
import sys
from threading import Lock

from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.clock import Clock, ClockType
from std_srvs.srv import Trigger

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.localizer.warm_up import warm_up
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.checkup import Checkup
from fpnet_ros.floorplans import FloorplanInput, ServedPlan
from fpnet_ros.hand_over import HandOver
from fpnet_ros.health import Health
from fpnet_ros.initial_poses import InitialPoses
from fpnet_ros.inputs import LocatedScan, ScanInput
from fpnet_ros.lifecycle import ManagedNode, run_managed
from fpnet_ros.localize_action import LocalizeAction
from fpnet_ros.optional_messages import NO_TF, TFMessage
from fpnet_ros.outputs import LocalizerOutputs, Moment
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import STREAM, SilenceLog, StatusLog, error_reporter, one_line
from fpnet_ros.services import offer_amcl_services, offer_services, offer_set_initial_pose
from fpnet_ros.settings import LIVE, LIVE_CONFIG, LocalizerParameters
from fpnet_ros.state_file import RunFolder, StateFile
from fpnet_ros.storeys import StoreyTopics, create_site_localizer
from fpnet_ros.work import DroppingWorker, Worker
from msg_adapters.diagnostics import LocalizerReport

_DIAGNOSTICS_PERIOD_S = 1.0  # chosen


class LocalizerNode(ManagedNode):
    """
    Drives one :class:`fpnet_core.localizer.Localizer`.

    Three threads: the executor's takes messages, answers services and rebroadcasts TF; scans are
    added in a second one; ticks, new floorplans and saves follow one another in a third, so that
    a service whose answer takes long waits without holding up the first. Topics, services and
    parameters are described in docs/ros.md.
    """

    def __init__(self) -> None:
        super().__init__('localizer')
        follow = self._follow_parameters
        self._settings = ParameterTree(self, LocalizerParameters, live=LIVE, on_change=follow)
        self._config = ParameterTree(
            self, FpnetConfig, without=('odometry',), live=LIVE_CONFIG, on_change=follow
        )
        self._report = error_reporter(self)
        self._statuses = StatusLog(self.get_logger().info, self.get_logger().warning)
        self._silence = SilenceLog(self.get_logger().info, self.get_logger().warning)
        self._publish_lock = Lock()
        self.add_slow_service(Trigger, '~/save_state', self._on_save_state)
        self._action = LocalizeAction(self, self._look_again)
        self._forget()

    def _forget(self) -> None:
        self._is_configured = False
        self._settings.is_frozen = self._config.is_frozen = False
        self._frame: MapFrame | None = None
        self._newest: LocatedScan | None = None
        self._told: LocalizerReport | None = None
        self._tick: Future[None] | None = None

    def configure(self) -> None:
        """Load the weights, compile, and connect; a bad parameter or file is an FpnetError."""
        config, parameters = self._config.value, self._settings.value
        self._localizer = create_site_localizer(config)
        self.get_logger().info('warming up; the first time after an installation takes longer')
        warm_up(create_localizer(config))
        if TFMessage is None and parameters.sends_tf:
            self.get_logger().warning(f'no TF: {NO_TF}')
        self._scans = DroppingWorker(self._add_scan, parameters.max_pending_scans, self._report)
        self._ticks = Worker('ticks', self._report)
        self._is_configured = True
        self._out = LocalizerOutputs(self, parameters.path_spacing_m)
        self._input = ScanInput(
            self, parameters, self._on_scan, self._on_restart, self._report, config.scans.stamp
        )
        self._state_file = StateFile(
            parameters.state_file, self._localizer, self._input.odometry_run, self.get_logger()
        )
        self._state_file.restore()
        self._storeys = StoreyTopics(
            self, self._localizer, parameters.site, config, parameters.map_frame
        )
        self._checkup = Checkup(self, self._input.topics())
        self._run_folder = RunFolder(parameters.run_dir, self.get_logger())
        self._health = Health(self._input, self._scans)
        if not parameters.site:
            self._plans = FloorplanInput(self, self._on_floorplan, self._report)
        self._listen_to_words(parameters)
        self._add_timers(config.localizer.tick_period_s, parameters)
        self._settings.is_frozen = self._config.is_frozen = True

    def activate(self) -> None:
        """Say how things stand: until now nobody could hear it."""
        self._publish_tick()

    def deactivate(self) -> None:
        """Publish nothing from now on: a running tick ends unheard."""
        self._action.stop()
        with self._publish_lock:
            self._out.forget_claim()

    def cleanup(self) -> None:
        """Save the state, before anything that may take long; end the threads."""
        self._action.stop()
        if not self._is_configured:
            return
        self._scans.close()
        try:
            if self._state_file.path and self._newest is not None:
                self._state_file.save()
        finally:
            self._ticks.close()
            self._run_folder.write('last_tick.npz', self._localizer.output)
            self._forget()

    def _listen_to_words(self, parameters: LocalizerParameters) -> None:
        """Take what others say; beside AMCL what has its names is AMCL's."""
        self._words = InitialPoses(
            self._situation,
            self._storeys.frame_named,
            self._localizer.suggest,
            self.get_logger(),
            parameters.first_pose,
        )
        self._hand_over = HandOver(self) if parameters.hand_over else None
        offer_services(self, self._look_again, self._localizer.reset)
        offer_set_initial_pose(self, self._words, parameters.hand_over)
        if not parameters.hand_over:
            offer_amcl_services(self, self._look_again, self._tick_now)
            self.add_subscription(
                PoseWithCovarianceStamped, 'initialpose', self._words.on_message, STREAM
            )

    def _add_timers(self, tick_period_s: float, parameters: LocalizerParameters) -> None:
        # The others go on while the simulated clock stands still.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._tick_timer = self.add_timer(tick_period_s, self._start_tick)
        self._tf_timer = self.add_timer(1.0 / parameters.tf_rate_hz, self._broadcast, steady)
        self.add_timer(_DIAGNOSTICS_PERIOD_S, self._publish_diagnostics, steady)
        if parameters.state_file and parameters.autosave_period_s:
            self.add_timer(parameters.autosave_period_s, self._autosave, steady)

    def _follow_parameters(self) -> None:
        if not self._settings.is_frozen:  # what is configured later reads them then
            return
        thresholds, parameters = self._config.value.localizer, self._settings.value
        self._tick_timer.timer_period_ns = round(thresholds.tick_period_s * NS_PER_S)
        self._tf_timer.timer_period_ns = round(NS_PER_S / parameters.tf_rate_hz)
        self._out.path_spacing_m = parameters.path_spacing_m
        self._localizer.follow(thresholds)

    # ---- inputs: the executor's thread

    def _on_scan(self, scan: LocatedScan) -> None:
        if self.is_active:
            self._state_file.before_scan()
            self._scans.put(scan)

    def _on_restart(self) -> None:
        self.get_logger().warning('another process publishes the odometry now')
        self._localizer.restart_odometry()

    def _on_floorplan(self, plan: ServedPlan) -> None:
        self._ticks.submit(self._take_floorplan, plan)

    # ---- services: the executor's thread

    def _situation(self) -> tuple[MapFrame | None, LocatedScan | None]:
        return self._frame, self._newest

    def _look_again(self) -> None:
        self._localizer.relocalize()
        if self._hand_over is not None:
            self._hand_over.again()
        if self.is_active:
            self._publish_tick()

    def _tick_now(self) -> None:
        if self.is_active:  # behind a running tick, which has not seen what the caller has
            self._tick = self._ticks.submit(self._run_tick)

    async def _on_save_state(
        self, _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        path = self._settings.value.state_file
        if not path:
            response.message = 'parameter state_file is empty; set it to a path'
        elif not self._is_configured:
            response.message = 'the node is not configured'
        else:
            saved = self._ticks.submit(self._state_file.save)
            await self.finished(saved)
            error = 'the node was cleaned up' if saved.cancelled() else saved.result()
            response.success, response.message = not error, error or f'saved to {path}'
        return response

    # ---- timers: the executor's thread

    def _start_tick(self) -> None:
        if self.is_active and (self._tick is None or self._tick.done()):
            self._tick = self._ticks.submit(self._run_tick)

    def _broadcast(self) -> None:
        """Repeat the TF for now and a little longer, as long as scans come."""
        parameters, now_ns = self._settings.value, self.get_clock().now().nanoseconds
        if self.is_active and self._health.has_turned(now_ns, parameters.scan_timeout_s):
            self._publish_tick()
        self._follow_words()
        if parameters.sends_tf and now_ns and not self._health.is_starved:
            self._out.broadcast(now_ns + round(parameters.transform_tolerance * NS_PER_S))

    def _follow_words(self) -> None:
        self._words.follow()
        if self._told is not None:
            claimed = None if self._health.is_starved else self._out.claimed
            self._action.follow(self._told, claimed)

    def _publish_diagnostics(self) -> None:
        output, stale_s = self._localizer.output, self._settings.value.stale_input_s
        self._state_file.follow_odometry()
        if self.is_active:
            self._silence.follow(self._input.silence_s, stale_s)
            if self._hand_over is not None:
                self._hand_over.follow(self._out.claimed)
        news, findings = self._health.news(output, stale_s), self._checkup.findings()
        self._out.publish_diagnostics(news, findings, self.get_clock().now().nanoseconds)

    def _autosave(self) -> None:
        if self.is_active and self._newest is not None:
            self._ticks.submit(self._state_file.save)

    # ---- scans: their own thread

    def _add_scan(self, scan: LocatedScan) -> None:
        cloud = scan.unpack()
        self._checkup.look(scan, cloud.points)
        self._localizer.add_scan(cloud.points, scan.T_odom_sensor, scan.stamp_ns, cloud.viewpoints)
        self._newest = scan
        self._health.saw_scan(self.get_clock().now().nanoseconds)
        self._publish_moment()

    def _publish_moment(self) -> Moment:
        """Publish where the robot is, by what holds now, and return that."""
        with self._publish_lock:  # of two threads the later one publishes the later moment
            moment = Moment.of(self._localizer.snapshot, self._frame, self._newest)
            if self.is_active:
                self._out.publish_pose(moment)
        return moment

    # ---- ticks: their own thread

    def _run_tick(self) -> None:
        before = self._localizer.output
        output = self._localizer.tick(self.get_clock().now().nanoseconds)
        self._publish_tick()
        if output is not before:
            self._storeys.publish_differences(self._localizer.snapshot, self._frame)
            self._run_folder.write(f'ticks/{output.stamp_ns:020d}.npz', output)

    def _publish_tick(self) -> None:
        changed = self._storeys.follow(self._localizer.snapshot)
        if changed is not None:
            self._out.forget_path()
            self._show(changed)
        frame, A_plan_odom = self._frame, self._localizer.output.A_plan_odom
        if frame is not None and A_plan_odom is not None:
            self._show(frame.followed(A_plan_odom))
        moment = self._publish_moment()  # the tick may have found the robot after its newest scan
        report = self._health.report(moment.output, self._settings.value.stale_input_s)
        self._told = report
        self._statuses.tell(report)
        self._out.publish_status(report)
        self._out.publish_tick(moment)

    def _take_floorplan(self, plan: ServedPlan) -> None:
        try:
            plan.give_to(self._localizer, self._config.value.localizer.scale_policy)
        except FpnetError as error:
            self.get_logger().error(one_line(error))
            return
        self._out.forget_path()
        self.get_logger().info(f'took the floorplan in frame {plan.frame_id}{plan.said_of_scale}')
        self._show(MapFrame(plan.grid, plan.frame_id, self._settings.value.map_frame))
        self._publish_tick()

    def _show(self, frame: MapFrame) -> None:
        """Take the frame ``map`` as it is now; publish the floorplan in it if it has changed."""
        if frame is not self._frame:
            self._frame = frame
            self._out.publish_scaled(frame, self.get_clock().now().nanoseconds)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    return run_managed(LocalizerNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
