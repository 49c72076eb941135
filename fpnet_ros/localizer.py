# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Localise a robot on a floorplan from registered scans and odometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
import sys
from threading import Lock
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid
import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from rclpy.clock import Clock, ClockType
from std_srvs.srv import Empty, Trigger

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import FpnetError, StateError
from fpnet_core.geometry import SE2
from fpnet_core.io.runs import write_output
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.localizer.warm_up import warm_up
from fpnet_core.raster.warping import warped_grid
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import GridMap
from fpnet_ros.inputs import NO_TF, InputParameters, LocatedScan, ScanInput, TFMessage
from fpnet_ros.lifecycle import ManagedNode, run_managed
from fpnet_ros.outputs import LocalizerOutputs
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import (
    LATCHED,
    STALE_INPUT_S,
    STREAM,
    ErrorLog,
    SilenceLog,
    StatusLog,
    one_line,
)
from fpnet_ros.work import DroppingWorker
from msg_adapters.diagnostics import LocalizerReport, report_of_output
from msg_adapters.grids import grid_from_msg
from msg_adapters.poses import uncertain_pose_from_msg

_DIAGNOSTICS_PERIOD_S = 1.0  # chosen


class LocalizerParameters(InputParameters):
    """What only the node needs beside the configuration tree."""

    map_frame: str = Field('map', description='Frame of the floorplan at its true scale.')
    tf_broadcast: bool = Field(True, description='Publish the TF from map_frame to odometry.')
    transform_tolerance: float = Field(
        0.5, ge=0.0, le=10.0, description='The TF is post-dated by this much [s].'
    )
    tf_rate_hz: float = Field(25.0, ge=1.0, le=200.0, description='Rate of the TF.')
    path_spacing_m: float = Field(
        0.1, ge=0.0, description='Distance between poses of floorplan_path.'
    )
    stale_input_s: float = Field(
        STALE_INPUT_S,
        gt=0.0,
        description='Silence of an input after which log and diagnostics warn.',
    )
    state_file: str = Field(
        '', description='Where the state is saved, and read at the start; empty: nowhere.'
    )
    autosave_period_s: float = Field(
        0.0, ge=0.0, description='Time between two saves of the state; 0: only on request.'
    )
    run_dir: str = Field('', description='Folder for every tick, as files; empty: none.')


_LIVE = ('tf_broadcast', 'transform_tolerance', 'stale_input_s')
_LIVE_CONFIG = ('localizer.tick_period_s',)


@dataclass(frozen=True, eq=False)
class _Floorplan:
    """The floorplan in force, the frame that it came in, and its true size."""

    grid: GridMap
    frame_id: str
    map_frame: MapFrame


@dataclass(frozen=True, eq=False)
class _MapOdom:
    """The transform to broadcast."""

    T_map_odom: NDArray[np.float64]
    odom_frame: str


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
        self._settings = ParameterTree(self, LocalizerParameters, live=_LIVE)
        self._config = ParameterTree(
            self,
            FpnetConfig,
            without=('odometry',),
            live=_LIVE_CONFIG,
            on_change=self._follow_parameters,
        )
        self._errors = ErrorLog(self.get_logger().error)
        self._statuses = StatusLog(self.get_logger().info, self.get_logger().warning)
        self._silence = SilenceLog(self.get_logger().info, self.get_logger().warning)
        self._publish_lock = Lock()
        self.add_slow_service(Trigger, '~/save_state', self._on_save_state)
        self._forget()

    def _forget(self) -> None:
        self._is_configured = False
        self._settings.is_frozen = self._config.is_frozen = False
        self._floorplan: _Floorplan | None = None
        self._newest: LocatedScan | None = None
        self._published_ns: int | None = None
        self._map_odom: _MapOdom | None = None
        self._tf_stamp_ns = 0
        self._tick: Future[None] | None = None
        self._reported_drops = self._reported_losses = 0

    def configure(self) -> None:
        """Load the weights, compile, and connect; a bad parameter or file is an FpnetError."""
        config, parameters = self._config.value, self._settings.value
        self._localizer = create_localizer(config)
        self.get_logger().info('warming up; the first time after an installation takes longer')
        warm_up(create_localizer(config))
        self._restore(parameters.state_file)
        if TFMessage is None and parameters.tf_broadcast:
            self.get_logger().warning(f'no TF: {NO_TF}')
        self._scans = DroppingWorker(
            self._add_scan, parameters.max_pending_scans, self._report, 'scans'
        )
        self._ticks = ThreadPoolExecutor(max_workers=1, thread_name_prefix='ticks')
        self._is_configured = True
        self._out = LocalizerOutputs(self, parameters.map_frame, parameters.path_spacing_m)
        self._input = ScanInput(self, parameters, self._on_scan, self._on_restart, self._report)
        self.add_subscription(OccupancyGrid, 'floorplan', self._on_floorplan, LATCHED)
        self.add_subscription(
            PoseWithCovarianceStamped, 'initialpose', self._on_initial_pose, STREAM
        )
        self._add_services()
        self._add_timers(config.localizer.tick_period_s, parameters)
        self._settings.is_frozen = self._config.is_frozen = True

    def activate(self) -> None:
        """Say how things stand: until now nobody could hear it."""
        self._publish_tick()

    def deactivate(self) -> None:
        """Let the running tick end, so that nothing is published afterwards."""
        self._submit(lambda: None).result()
        self._map_odom = None

    def cleanup(self) -> None:
        """End the threads, save the state, write the last tick."""
        if not self._is_configured:
            return
        self._scans.close()
        self._ticks.shutdown(wait=True, cancel_futures=True)
        parameters = self._settings.value
        if parameters.run_dir:
            write_output(Path(parameters.run_dir) / 'last_tick.npz', self._localizer.output)
        if parameters.state_file and self._newest is not None:
            self._save(parameters.state_file)
        self._forget()

    def _add_services(self) -> None:
        self.add_service(Trigger, '~/relocalize', self._on_relocalize)
        self.add_service(Trigger, '~/reset', self._on_reset)
        self.add_service(Empty, 'reinitialize_global_localization', self._on_reinitialize)
        self.add_service(Empty, 'request_nomotion_update', self._on_nomotion_update)

    def _add_timers(self, tick_period_s: float, parameters: LocalizerParameters) -> None:
        # The last two go on while the simulated clock stands still.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._tick_timer = self.add_timer(tick_period_s, self._start_tick)
        self.add_timer(1.0 / parameters.tf_rate_hz, self._broadcast, steady)
        self.add_timer(_DIAGNOSTICS_PERIOD_S, self._publish_diagnostics, steady)
        if parameters.state_file and parameters.autosave_period_s:
            self.add_timer(parameters.autosave_period_s, self._autosave, steady)

    def _follow_parameters(self) -> None:
        if self._is_configured:
            period_s = self._config.value.localizer.tick_period_s
            self._tick_timer.timer_period_ns = round(period_s * NS_PER_S)

    # ---- inputs: the executor's thread

    def _on_scan(self, scan: LocatedScan) -> None:
        if self.is_active:
            self._scans.put(scan)

    def _on_restart(self) -> None:
        self.get_logger().warning('another process publishes the odometry now')
        self._localizer.restart_odometry()

    def _on_floorplan(self, msg: OccupancyGrid) -> None:
        try:
            grid = grid_from_msg(msg)
        except FpnetError as error:
            self.get_logger().error(one_line(error))
            return
        self._submit(self._take_floorplan, grid, msg.header.frame_id)

    def _on_initial_pose(self, msg: PoseWithCovarianceStamped) -> None:
        floorplan, scan = self._floorplan, self._newest
        try:
            given = uncertain_pose_from_msg(msg)
        except FpnetError as error:
            self._report(error)
            return
        frames = {self._settings.value.map_frame: 'map'}
        if floorplan is not None:
            frames[floorplan.frame_id] = 'plan'
        if given.pose.frame_id not in frames:
            known = ' or '.join(repr(frame) for frame in frames)
            self.get_logger().error(
                f'initialpose is in frame {given.pose.frame_id!r}, expected {known}; it was '
                'rejected'
            )
            return
        if floorplan is None or scan is None:
            missing = 'floorplan' if floorplan is None else 'scan'
            self.get_logger().error(f'initialpose came before the first {missing}; send it again')
            return
        T_plan_base = given.pose.T_frame_body
        if given.pose.frame_id != floorplan.frame_id:
            T_plan_base = floorplan.map_frame.to_plan(T_plan_base)
        sigma = np.sqrt(np.maximum(np.diag(given.cov), 0.0))
        self._localizer.suggest(
            PoseHint(
                T_plan_base,
                SE2.from_matrix4(scan.T_odom_base),
                float(sigma[:2].max()),
                float(sigma[2]),
            )
        )
        self.get_logger().info('took the initial pose; it counts once the walls agree')

    # ---- services: the executor's thread

    def _on_relocalize(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._localizer.relocalize()
        return _succeeded(response, 'forgot every placement; the submap stays')

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._localizer.reset()
        return _succeeded(response, 'forgot the submap and every placement')

    async def _on_save_state(
        self, _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        path = self._settings.value.state_file
        if not path:
            response.message = 'parameter state_file is empty; set it to a path'
        elif not self._is_configured:
            response.message = 'the node is not configured'
        else:
            saved = self._submit(self._save, path)
            await self.finished(saved)
            error = 'the node was cleaned up' if saved.cancelled() else saved.result()
            response.success, response.message = not error, error or f'saved to {path}'
        return response

    def _on_reinitialize(self, _: Empty.Request, response: Empty.Response) -> Empty.Response:
        self._localizer.relocalize()
        return response

    def _on_nomotion_update(self, _: Empty.Request, response: Empty.Response) -> Empty.Response:
        if self.is_active:  # behind a running tick, which has not seen what the caller has
            self._tick = self._submit(self._run_tick)
        return response

    # ---- timers: the executor's thread

    def _start_tick(self) -> None:
        if self.is_active and (self._tick is None or self._tick.done()):
            self._tick = self._submit(self._run_tick)

    def _broadcast(self) -> None:
        """Repeat the TF for now and a little longer; tf2 complains about a stamp sent twice."""
        parameters, map_odom = self._settings.value, self._map_odom
        now_ns = self.get_clock().now().nanoseconds
        if map_odom is None or not parameters.tf_broadcast or now_ns == 0:
            return
        stamp_ns = now_ns + round(parameters.transform_tolerance * NS_PER_S)
        if stamp_ns != self._tf_stamp_ns:
            self._tf_stamp_ns = stamp_ns
            self._out.publish_tf(map_odom.T_map_odom, stamp_ns, map_odom.odom_frame)

    def _publish_diagnostics(self) -> None:
        if self.is_active:
            self._silence.follow(self._input.silence_s, self._settings.value.stale_input_s)
        report = self._report_tick(self._new_losses())
        self._out.publish_diagnostics(report, self.get_clock().now().nanoseconds)

    def _new_losses(self) -> list[str]:
        """Name what was lost since the last time."""
        dropped, lost = self._dropped(), self._input.lost
        news = {
            'scans are dropped: more come than can be added': dropped > self._reported_drops,
            'scans are lost on the way here: see "Large clouds"': lost > self._reported_losses,
        }
        self._reported_drops, self._reported_losses = dropped, lost
        return [text for text, is_new in news.items() if is_new]

    def _autosave(self) -> None:
        if self.is_active and self._newest is not None:
            self._submit(self._save, self._settings.value.state_file)

    # ---- scans: their own thread

    def _add_scan(self, scan: LocatedScan) -> None:
        cloud = scan.unpack()
        self._localizer.add_scan(cloud.points, scan.T_odom_sensor, scan.stamp_ns, cloud.viewpoints)
        self._newest = scan
        self._publish_pose()

    def _publish_pose(self) -> None:
        """Publish the pose at the newest scan, once, if the localizer claims one."""
        with self._publish_lock:
            scan, floorplan, output = self._newest, self._floorplan, self._localizer.output
            located = None
            if scan is not None and floorplan is not None:
                located = floorplan.map_frame.located(output, scan.T_odom_base)
            if scan is None or floorplan is None or located is None:
                self._map_odom = None
                return
            T_map_tf = located.T_map_odom.as_matrix4() @ np.linalg.inv(scan.T_tf_odom)
            self._map_odom = _MapOdom(T_map_tf, scan.tf_frame)
            if scan.stamp_ns == self._published_ns:
                return
            self._published_ns = scan.stamp_ns
            self._out.publish_pose(located.T_plan_base, scan.stamp_ns, floorplan.frame_id)
            if located.cov is not None:
                self._out.publish_twin(located.T_map_base, located.cov, scan.stamp_ns)

    # ---- ticks: their own thread

    def _run_tick(self) -> None:
        before = self._localizer.output
        output = self._localizer.tick(self.get_clock().now().nanoseconds)
        self._publish_tick()
        if self._settings.value.run_dir and output is not before:
            name = f'ticks/{output.stamp_ns:020d}.npz'
            write_output(Path(self._settings.value.run_dir) / name, output)

    def _publish_tick(self) -> None:
        output, floorplan, scan = self._localizer.output, self._floorplan, self._newest
        if floorplan is not None and output.A_plan_odom is not None:
            map_frame = floorplan.map_frame.followed(output.A_plan_odom)
            if map_frame is not floorplan.map_frame:
                self._floorplan = floorplan = replace(floorplan, map_frame=map_frame)
                self._publish_scaled(floorplan)
            self._out.publish_path(output.stamp_ns, floorplan.frame_id)
        self._publish_pose()  # the tick may have found the robot after its newest scan
        report = self._report_tick()
        self._statuses.tell(report)
        self._out.publish_status(report)
        if floorplan is not None and scan is not None:
            self._out.publish_submap(output, scan.odom_frame)
            self._out.publish_markers(
                self._localizer.plan,
                output,
                floorplan.map_frame.A_map_plan,
                scan.odom_frame,
                SE2.from_matrix4(scan.T_odom_base),
            )

    def _take_floorplan(self, grid: GridMap, frame_id: str) -> None:
        try:
            self._localizer.set_plan(grid)
        except FpnetError as error:
            self.get_logger().error(one_line(error))
            return
        # A floorplan in the map's own frame is taken at its word: its scale is the map's.
        is_trusted = frame_id == self._settings.value.map_frame
        self._floorplan = _Floorplan(grid, frame_id, MapFrame(grid, is_trusted))
        self._out.forget_path()
        self.get_logger().info(f'took the floorplan in frame {frame_id}')
        self._publish_scaled(self._floorplan)
        self._publish_tick()

    def _publish_scaled(self, floorplan: _Floorplan) -> None:
        grid = warped_grid(floorplan.grid, floorplan.map_frame.A_map_plan)
        self._out.publish_scaled(grid, self.get_clock().now().nanoseconds)

    def _save(self, path: str) -> str:
        """Write the state; returns what went wrong, empty: nothing."""
        try:
            self._localizer.save_state(path)
        except StateError as error:
            self.get_logger().error(one_line(error))
            return one_line(error)
        return ''

    def _restore(self, path: str) -> None:
        """Go on from a saved state; a bad one is no reason not to start."""
        if not path or not Path(path).exists():
            return
        try:
            self._localizer.load_state(path)
        except StateError as error:
            self.get_logger().error(f'{one_line(error)}; starting anew')
            return
        self.get_logger().info(f'restored the state in {path}')

    # ---- any thread

    def _report_tick(self, losses: Sequence[str] = ()) -> LocalizerReport:
        figures = {
            **self._input.ages_s,
            'scan_ms': self._scans.work_ms,
            'scans': float(self._scans.done),
            'dropped_scans': float(self._dropped()),
            'lost_scans': float(self._input.lost),
        }
        warnings = [*losses]
        for name, age_s in self._input.ages_s.items():
            if age_s > self._settings.value.stale_input_s:
                warnings.append(f'no {name.removesuffix("_age_s")} for {age_s:.0f} s')
        return report_of_output(self._localizer.output, figures, ', '.join(warnings))

    def _dropped(self) -> int:
        return self._scans.dropped + self._input.unlocated

    def _submit(self, work: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future = self._ticks.submit(work, *arguments)
        future.add_done_callback(self._log_failure)
        return future

    def _log_failure(self, future: Future[Any]) -> None:
        """A defect in the worker must not pass in silence; the node goes on with the next tick."""
        if not future.cancelled() and (error := future.exception()) is not None:
            self._report(error)

    def _report(self, error: BaseException) -> None:
        if isinstance(error, FpnetError):
            self._errors.report(error)
        elif self.context.ok():  # else the publishers were gone, which is no defect
            self.get_logger().error(f'internal error, please report it: {error!r}')


def _succeeded(response: Trigger.Response, message: str) -> Trigger.Response:
    response.success, response.message = True, message
    return response


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    return run_managed(LocalizerNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
