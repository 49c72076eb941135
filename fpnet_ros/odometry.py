# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lidar odometry by KISS-ICP, with the topics and frames of KISS-ICP's own ROS node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2

from fpnet_core.config import OdometryConfig
from fpnet_core.errors import ConfigError
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.io.laser_sweeps import LaserSweep
from fpnet_core.io.scans import Scan
from fpnet_core.odometry import KissOdometry
from fpnet_ros.checkup import SweepCheckup, findings_to_msg
from fpnet_ros.inputs import NO_TF, TFMessage
from fpnet_ros.lasers import LaserInput, LaserParameters
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.runtime import (
    STALE_INPUT_S,
    STREAM,
    TF,
    TF_STATIC,
    SilenceLog,
    error_reporter,
    run_node,
    sensor_data,
)
from fpnet_ros.work import DroppingWorker, Numbering
from msg_adapters.clouds import cloud_from_msg, cloud_to_msg
from msg_adapters.diagnostics import diagnostics_to_msg, health_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.stamps import stamp_from_msg
from msg_adapters.transforms import transform_from_msg, transform_to_msg

# Chosen, not measured:
_DIAGNOSTICS_PERIOD_S = 1.0


class OdometryParameters(LaserParameters):
    """Frames and covariances, named as in KISS-ICP's node."""

    base_frame: str = Field(
        '', description='Frame whose pose is published; empty: that of the clouds.'
    )
    lidar_odom_frame: str = Field('odom_lidar', description='Frame of the published odometry.')
    publish_odom_tf: bool = Field(True, description='Publish the odometry as TF, too.')
    invert_odom_tf: bool = Field(
        False, description='Publish TF from the moving frame to the odometry frame.'
    )
    position_covariance: float = Field(
        0.1, ge=0.0, description='Variance of the position in the messages [m^2].'
    )
    orientation_covariance: float = Field(
        0.1, ge=0.0, description='Variance of the orientation in the messages [rad^2].'
    )
    max_pending_scans: int = Field(
        10, ge=1, le=1000, description='Clouds that may wait; then the oldest are dropped.'
    )


@dataclass(frozen=True, eq=False)
class _Sweep:
    """A sweep to register, and the frame that it is in."""

    scan: Scan
    frame_id: str


def _sweep_of_cloud(data: bytes) -> _Sweep:
    msg = deserialize_message(data, PointCloud2)
    cloud, stamp_ns = cloud_from_msg(msg), stamp_from_msg(msg.header.stamp)
    scan = Scan(stamp_ns, cloud.points, cloud.time_s, viewpoints=cloud.viewpoints)
    return _Sweep(scan, msg.header.frame_id.lstrip('/'))


class OdometryNode(OwnValues):
    """
    Registers every cloud on ``pointcloud_topic``, in a thread of its own.

    Publishes ``kiss/odometry``, the pose at the cloud's stamp, and ``kiss/frame``, the cloud
    without the motion during its sweep, with the cloud's header. With a ``base_frame`` the pose
    is that frame's, by its place in ``/tf_static``.

    With ``scan_topics`` it registers the LaserScans of one or several planar scanners instead:
    ``kiss/frame`` is then in the base's frame, its stamp that of the last return.
    """

    def __init__(self) -> None:
        super().__init__('odometry')
        self._report = error_reporter(self)
        self._settings = ParameterTree(self, OdometryParameters).value
        config = ParameterTree(self, OdometryConfig, 'odometry.').value
        self._kiss = KissOdometry(config, self._on_clock_back)
        self._tree = FrameTree()
        self._odometry_publisher = self._publisher(Odometry, 'kiss/odometry', STREAM)
        self._frame_publisher = self._publisher(PointCloud2, 'kiss/frame', STREAM)
        self._diagnostics = self._publisher(DiagnosticArray, '/diagnostics', STREAM)
        self._connect_tf()
        self._clouds = Numbering()
        self._reported_drops = 0
        self._heard_s = time.monotonic()
        self._silence = SilenceLog(self.get_logger().info, self.get_logger().warning)
        self._scans: DroppingWorker[Callable[[], _Sweep]] = DroppingWorker(
            self._register, self._settings.max_pending_scans, self._report, 'registration'
        )
        self._lasers: LaserInput | None = None
        clouds = self.resolve_topic_name('pointcloud_topic')
        self._checkup = SweepCheckup(clouds, self.get_logger().warning)
        if self._settings.topics:
            self._listen_to_lasers(self._settings.topics)
        else:
            # Raw, as the worker unpacks: it takes longer than this thread has.
            self._subscribe(PointCloud2, 'pointcloud_topic', self._on_cloud, raw=True)
        self.create_timer(_DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)

    def destroy_node(self) -> None:
        """End the worker first."""
        self._scans.close()
        super().destroy_node()

    def _publisher(self, kind: type, topic: str, qos: Any) -> Any:
        options = QoSOverridingOptions.with_default_policies()
        return self.create_publisher(kind, topic, qos, qos_overriding_options=options)

    def _subscribe(
        self, kind: type, topic: str, callback: Callable[..., None], raw: bool = False
    ) -> None:
        self.create_subscription(
            kind,
            topic,
            callback,
            sensor_data(self._settings.max_pending_scans),
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            raw=raw,
        )

    def _listen_to_lasers(self, topics: dict[str, type]) -> None:
        base = self._settings.base_frame
        if len(topics) > 1 and not base:
            raise ConfigError(
                f'parameter base_frame is empty; {len(topics)} scanners are merged in that frame'
            )
        self._lasers = LaserInput(
            self._subscribe, topics, self._tree, lambda: base, self._on_sweep, self._report
        )

    def _connect_tf(self) -> None:
        self._tf_publisher = None
        if TFMessage is None:
            self.get_logger().warning(f'no TF: {NO_TF}')
            return
        if self._settings.publish_odom_tf:
            self._tf_publisher = self._publisher(TFMessage, '/tf', TF)
        self.create_subscription(TFMessage, '/tf_static', self._on_tf_static, TF_STATIC)

    def _on_tf_static(self, msg: Any) -> None:
        for transform in map(transform_from_msg, msg.transforms):
            self._tree.add_fixed(transform.parent, transform.child, transform.T_parent_child)

    def _on_cloud(self, data: bytes, info: dict[str, Any]) -> None:
        self._clouds.follow(info)
        self._heard_s = time.monotonic()
        self._scans.put(partial(_sweep_of_cloud, data))

    def _on_sweep(self, sweep: LaserSweep, base: str) -> None:
        self._heard_s = time.monotonic()
        scan = Scan(sweep.stamp_ns, sweep.points, sweep.time_s, viewpoints=sweep.viewpoints)
        self._scans.put(lambda: _Sweep(scan, base))

    def _register(self, unpack: Callable[[], _Sweep]) -> None:
        sweep = unpack()
        scan, sensor = sweep.scan, sweep.frame_id
        if self._lasers is None:
            self._checkup.look(scan.points, scan.time_s)
        moving = self._settings.base_frame or sensor
        T_base_sensor = self._tree.mount(moving, sensor)
        found = self._kiss.register_scan(scan)
        # As KISS-ICP's node: odom is where the base, not the sensor, was at the first cloud.
        T_odom_base = T_base_sensor @ found.T_odom_sensor @ np.linalg.inv(T_base_sensor)
        self._publish(T_odom_base, scan.stamp_ns, moving)
        self._frame_publisher.publish(
            cloud_to_msg(found.points, scan.stamp_ns, sensor, viewpoints=found.viewpoints)
        )

    def _on_clock_back(self, back_s: float) -> None:
        self.get_logger().warning(f'the clock went back by {back_s:.3f} s; starting anew')

    def _publish(self, T_odom_base: NDArray[np.float64], stamp_ns: int, moving: str) -> None:
        settings = self._settings
        variances = (settings.position_covariance,) * 3 + (settings.orientation_covariance,) * 3
        odom = settings.lidar_odom_frame
        self._odometry_publisher.publish(
            odometry_to_msg(T_odom_base, stamp_ns, odom, moving, variances)
        )
        if self._tf_publisher is not None:
            if settings.invert_odom_tf:
                T_base_odom = np.linalg.inv(T_odom_base)
                transform = transform_to_msg(T_base_odom, stamp_ns, moving, odom)
            else:
                transform = transform_to_msg(T_odom_base, stamp_ns, odom, moving)
            self._tf_publisher.publish(TFMessage(transforms=[transform]))

    def _publish_diagnostics(self) -> None:
        scans = ', '.join(self._settings.topics) or self.resolve_topic_name('pointcloud_topic')
        self._silence.follow({scans: time.monotonic() - self._heard_s}, STALE_INPUT_S)
        dropped, lost = self._scans.dropped, self._clouds.lost
        lost += 0 if self._lasers is None else self._lasers.lost
        warning = ''
        if dropped + lost > self._reported_drops:
            warning = 'clouds are dropped: more come than can be registered or received'
        self._reported_drops = dropped + lost
        values = {
            'scans': float(self._scans.done),
            'dropped_scans': float(dropped),
            'lost_scans': float(lost),
            'register_ms': self._scans.work_ms,
        }
        name = f'{self.get_fully_qualified_name()}: registration'
        status = health_to_msg(name, warning, values)
        now_ns = self.get_clock().now().nanoseconds
        wiring = findings_to_msg(self.get_fully_qualified_name(), self._checkup.findings or ())
        self._diagnostics.publish(diagnostics_to_msg([status, wiring], now_ns))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    return run_node(OdometryNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
