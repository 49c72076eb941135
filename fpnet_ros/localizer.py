# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node that localizes a robot on a floorplan from registered scans and odometry."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future

from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.clock import Clock, ClockType
from rclpy.utilities import get_rmw_implementation_identifier

from fpnet_core.config import FpnetConfig
from fpnet_core.io.sessions import TICK_NAME, TICKS_NAME
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.warm_up import warm_up
from fpnet_core.sites.site_localizer import create_site_localizer
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.checkup import Checkup
from fpnet_ros.floorplans import FloorplanInput, ServedPlan
from fpnet_ros.health import DIAGNOSTICS_PERIOD_S, Health
from fpnet_ros.initial_poses import InitialPoses
from fpnet_ros.inputs import LocatedScan, ScanInput
from fpnet_ros.large_clouds import said_of_transport
from fpnet_ros.lifecycle import ManagedNode, run_managed
from fpnet_ros.localize_action import LocalizeAction
from fpnet_ros.optional_messages import NO_TF, TFMessage
from fpnet_ros.outputs import LocalizerOutputs
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import STREAM, SilenceLog, error_reporter
from fpnet_ros.services import (
    offer_amcl_services,
    offer_save_state,
    offer_services,
    offer_set_initial_pose,
)
from fpnet_ros.settings import LIVE, LIVE_CONFIG, LocalizerParameters
from fpnet_ros.state_file import RunFolder, StateFile
from fpnet_ros.status_publisher import StatusPublisher
from fpnet_ros.storeys import StoreyTopics
from fpnet_ros.work import DroppingWorker, Worker


class LocalizerNode(ManagedNode):
    """
    Runs one :class:`fpnet_core.localizer.Localizer`.

    Three threads: the executor's handles messages, services and TF; a second one adds scans; a
    third one runs updates, new floorplans and saves in sequence, so that slow work does not block
    the first. docs/ros.md describes topics, services and parameters.
    """

    def __init__(self) -> None:
        super().__init__('localizer')
        follow = self._follow_parameters
        self._settings = ParameterTree(self, LocalizerParameters, live=LIVE, on_change=follow)
        self._config = ParameterTree(
            self, FpnetConfig, without=('odometry',), live=LIVE_CONFIG, on_change=follow
        )
        self._report = error_reporter(self)
        self._silence = SilenceLog(self.get_logger().info, self.get_logger().warning)
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
        config, parameters = self._config.value, self._settings.value
        self._localizer = create_site_localizer(config)
        if TFMessage is None and parameters.sends_tf:
            self.get_logger().warning(f'no TF: {NO_TF}')
        self._run_folder = RunFolder(parameters.run_dir, self.get_logger())
        self.add_end(lambda: self._run_folder.write(TICK_NAME, self._localizer.output))
        self._out = LocalizerOutputs(self, parameters.path_spacing_m)
        self._storeys = StoreyTopics(
            self, self._localizer, parameters.site, config, parameters.map_frame
        )
        self._start_threads(parameters)
        self._input = ScanInput(
            self,
            parameters,
            self._on_scan,
            self._on_restart,
            self._report,
            config.scans.stamp,
            self._on_stamp,
        )
        self._health = Health(
            self._input, self._scans, self.get_clock(), self.get_logger().warning
        )
        self._publisher = StatusPublisher(
            self,
            self._localizer,
            self._out,
            self._storeys,
            self._health,
            lambda: self._settings.value,
        )
        self._open_state_file(parameters.state_file)
        self._checkup = Checkup(self, self._input.topics())
        if not parameters.topics and (
            said := said_of_transport(get_rmw_implementation_identifier())
        ):
            self.get_logger().info(said)
        if not parameters.site:
            FloorplanInput(self, self._on_floorplan, self._report)
        self._offer_hints(parameters)
        self._add_timers(config.localizer.update_period_s, parameters)
        self._is_configured = True
        self._settings.is_frozen = self._config.is_frozen = True

    def activate(self) -> None:
        """Publish the status, which an inactive node does not publish."""
        self._publisher.update()

    def deactivate(self) -> None:
        """Stop publishing; the result of a running update is discarded."""
        self._action.stop()
        self._publisher.stop()

    def cleanup(self) -> None:
        """Abort goals, and allow all parameters to change again."""
        self._action.stop()
        self._is_configured = self._settings.is_frozen = self._config.is_frozen = False

    def _start_threads(self, parameters: LocalizerParameters) -> None:
        self._update: Future[None] | None = None
        self._updates = Worker('updates', self._report)
        self.add_end(self._updates.close)
        self._scans = DroppingWorker(self._add_scan, parameters.max_pending_scans, self._report)
        self.add_end(self._scans.close)

    def _open_state_file(self, path: str) -> None:
        """Restore the state; at cleanup, save it before waiting for the threads."""
        self._state_file = StateFile(
            path, self._localizer, self._input.odometry_run, self.get_logger()
        )
        self.add_end(lambda: self._publisher.newest and self._state_file.save())
        self._state_file.restore()

    def _offer_hints(self, parameters: LocalizerParameters) -> None:
        """Offer pose hints and services; with ``hand_over`` AMCL's names are left to AMCL."""
        self._hints = InitialPoses(
            self._publisher.situation,
            self._storeys.frame_named,
            self._localizer.suggest,
            self.get_logger(),
            parameters.first_pose,
        )
        offer_services(self, self._relocalize, self._localizer.reset)
        offer_set_initial_pose(self, self._hints, parameters.hand_over)
        if not parameters.hand_over:
            offer_amcl_services(self, self._relocalize, self._update_now)
            self.add_subscription(
                PoseWithCovarianceStamped, 'initialpose', self._hints.on_message, STREAM
            )

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

    # ---- inputs: the executor's thread

    def _on_stamp(self, stamp_ns: int) -> None:
        if self.is_active:
            self._checkup.hear(stamp_ns)

    def _on_scan(self, scan: LocatedScan) -> None:
        if self.is_active:
            self._state_file.before_scan()
            self._scans.put(scan)

    def _on_restart(self) -> None:
        self.get_logger().warning('another process publishes the odometry now')
        self._localizer.restart_odometry()

    def _on_floorplan(self, plan: ServedPlan) -> None:
        policy = self._config.value.localizer.scale_policy
        self._updates.submit(self._publisher.floorplan, plan, policy)

    # ---- services: the executor's thread

    def _relocalize(self) -> None:
        self._localizer.relocalize()
        if self.is_active:
            self._publisher.update()

    def _update_now(self) -> None:
        if self.is_active:  # queued after a running update, which lacks the newest scans
            self._update = self._updates.submit(self._run_update)

    def _save(self) -> Future[str] | None:
        return self._updates.submit(self._state_file.save) if self._is_configured else None

    # ---- timers: the executor's thread

    def _start_update(self) -> None:
        if self.is_active and (self._update is None or self._update.done()):
            self._update = self._updates.submit(self._run_update)

    def _follow(self) -> None:
        self._publisher.transform()
        self._hints.follow()
        if self._publisher.told is not None:
            self._action.follow(self._publisher.told, self._publisher.accepted)

    def _publish_diagnostics(self) -> None:
        self._state_file.follow_odometry()
        if self.is_active:
            stale_s = self._settings.value.stale_input_s
            if self._silence.follow(self._health.silence_s, stale_s):
                self._publisher.update()  # no update runs while the clock stands still
        self._publisher.diagnostics(self._checkup.findings())

    def _autosave(self) -> None:
        if self.is_active and self._publisher.newest is not None:
            self._save()

    # ---- scans: their own thread

    def _add_scan(self, scan: LocatedScan) -> None:
        cloud = scan.unpack()
        self._checkup.look(scan, cloud.points)
        self._localizer.add_scan(cloud.points, scan.T_odom_sensor, scan.stamp_ns, cloud.viewpoints)
        self._publisher.scan(scan)

    # ---- updates: their own thread

    def _run_update(self) -> None:
        before = self._localizer.output
        output = self._localizer.update(self.get_clock().now().nanoseconds)
        self._publisher.update()
        if output is not before:
            self._publisher.differences()
            self._run_folder.write(f'{TICKS_NAME}/{output.stamp_ns:020d}.npz', output)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_managed(LocalizerNode, arguments)
