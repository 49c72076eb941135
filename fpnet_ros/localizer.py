# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publish the robot's pose on a floorplan from registered scans and odometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from pydantic import Field
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import PointCloud2

from fpnet_core.config import FpnetConfig, Section
from fpnet_core.errors import FpnetError, OdometryError
from fpnet_core.io.runs import write_output
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.warm_up import warm_up
from fpnet_core.types import GridMap, LocalizerOutput
from fpnet_ros.params import declare_section
from fpnet_ros.runtime import (
    LATCHED,
    SCAN_QUEUE,
    SENSOR_DATA,
    STATUS,
    STREAM,
    ErrorLog,
    one_line,
    run_node,
)
from msg_adapters.clouds import cloud_from_msg
from msg_adapters.diagnostics import report_of_output, report_to_msg
from msg_adapters.grids import grid_from_msg
from msg_adapters.odometry import OdometryReading, odometry_from_msg
from msg_adapters.pairing import StampPairing
from msg_adapters.poses import pose_to_msg
from msg_adapters.stamps import stamp_from_msg


class LocalizerParameters(Section):
    """What only the node needs beside the configuration tree."""

    run_dir: str = Field('', description='Folder for the last tick at shutdown; empty: none.')


class LocalizerNode(Node):
    """
    Drives one :class:`fpnet_core.localizer.Localizer`.

    Subscribes ``kiss/frame``, ``kiss/odometry`` (paired by stamp) and ``floorplan``; publishes
    ``/floorplan_pose`` in the floorplan grid's frame with the sensor's stamp, only while
    localized, and ``~/status`` after every tick. Scans are added on the executor's thread; ticks
    and new floorplans are worked off one after the other on a second one.
    """

    def __init__(self) -> None:
        super().__init__('localizer')
        self._errors = ErrorLog(self.get_logger().error)
        self._run_dir = declare_section(self, LocalizerParameters).run_dir
        config = declare_section(self, FpnetConfig, without=('odometry',))
        self._localizer = create_localizer(config)
        self.get_logger().info('warming up; the first time after an installation takes longer')
        warm_up(config)
        self._pairing = StampPairing[PointCloud2, Odometry](SCAN_QUEUE)
        self._plan_frame = ''
        self._newest: OdometryReading | None = None
        self._published_ns: int | None = None
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix='tick')
        self._tick: Future[None] | None = None
        self._pose_publisher = self.create_publisher(PoseStamped, 'floorplan_pose', STREAM)
        self._status_publisher = self.create_publisher(DiagnosticStatus, '~/status', STATUS)
        self._subscribe(PointCloud2, 'kiss/frame', self._on_frame)
        self._subscribe(Odometry, 'kiss/odometry', self._on_odometry)
        self.create_subscription(OccupancyGrid, 'floorplan', self._on_floorplan, LATCHED)
        self.create_timer(config.localizer.tick_period_s, self._start_tick)

    def destroy_node(self) -> None:
        """End the worker, then write the last tick for reports."""
        self._worker.shutdown(wait=True, cancel_futures=True)
        if self._run_dir:
            write_output(Path(self._run_dir) / 'last_tick.npz', self._localizer.output)
        super().destroy_node()

    def _subscribe(self, kind: type, topic: str, callback: Callable[[Any], None]) -> None:
        self.create_subscription(
            kind,
            topic,
            callback,
            SENSOR_DATA,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def _on_frame(self, msg: PointCloud2) -> None:
        pair = self._pairing.add_first(stamp_from_msg(msg.header.stamp), msg)
        if pair is not None:
            self._add_scan(*pair)

    def _on_odometry(self, msg: Odometry) -> None:
        pair = self._pairing.add_second(stamp_from_msg(msg.header.stamp), msg)
        if pair is not None:
            self._add_scan(*pair)

    def _add_scan(self, frame_msg: PointCloud2, odometry_msg: Odometry) -> None:
        try:
            cloud = cloud_from_msg(frame_msg)
            odometry = odometry_from_msg(odometry_msg)
            _check_same_body(odometry, frame_msg.header.frame_id)
            self._localizer.add_scan(cloud.points, odometry.T_odom_child, odometry.stamp_ns)
        except FpnetError as error:
            self._errors.report(error)
            return
        self._newest = odometry
        self._publish_pose()

    def _publish_pose(self) -> None:
        """Publish the pose at the newest scan, once, if the localizer claims one."""
        odometry = self._newest
        if odometry is None or odometry.stamp_ns == self._published_ns:
            return
        pose = self._localizer.pose(odometry.T_odom_child)
        if pose is not None:
            self._published_ns = odometry.stamp_ns
            self._pose_publisher.publish(pose_to_msg(pose, odometry.stamp_ns, self._plan_frame))

    def _on_floorplan(self, msg: OccupancyGrid) -> None:
        try:
            grid = grid_from_msg(msg)
        except FpnetError as error:
            self.get_logger().error(one_line(error))
            return
        self._submit(self._take_floorplan, grid, msg.header.frame_id)

    def _take_floorplan(self, grid: GridMap, frame_id: str) -> None:
        try:
            self._localizer.set_plan(grid)
        except FpnetError as error:
            self.get_logger().error(one_line(error))
            return
        self._plan_frame = frame_id
        self.get_logger().info(f'took the floorplan in frame {frame_id}')
        self._publish_status(self._localizer.output)

    def _start_tick(self) -> None:
        self._publish_pose()  # the last tick may have found the robot after its newest scan
        if self._tick is None or self._tick.done():
            self._tick = self._submit(self._run_tick)

    def _run_tick(self) -> None:
        self._publish_status(self._localizer.tick(self.get_clock().now().nanoseconds))

    def _publish_status(self, output: LocalizerOutput) -> None:
        report = report_of_output(output, self._pairing.dropped)
        self._status_publisher.publish(report_to_msg(report, self.get_fully_qualified_name()))

    def _submit(self, work: Callable[..., None], *arguments: Any) -> Future[None]:
        future = self._worker.submit(work, *arguments)
        future.add_done_callback(self._log_failure)
        return future

    def _log_failure(self, future: Future[None]) -> None:
        """A defect in the worker must not pass in silence; the node goes on with the next tick."""
        if not future.cancelled() and (error := future.exception()) is not None:
            self.get_logger().error(f'internal error, please report it: {error!r}')


def _check_same_body(odometry: OdometryReading, sensor_frame: str) -> None:
    if odometry.child_frame_id != sensor_frame:
        raise OdometryError(
            f'odometry is that of {odometry.child_frame_id!r}, the scan is in {sensor_frame!r}; '
            "let the odometry publish the sensor's own pose (base_frame empty in KISS-ICP)"
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    return run_node(LocalizerNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
