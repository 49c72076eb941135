# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lidar odometry by KISS-ICP, with the topics and frames of KISS-ICP's own ROS node."""

from __future__ import annotations

from collections.abc import Sequence
import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2

from fpnet_core.config import OdometryConfig, Section
from fpnet_core.errors import FpnetError
from fpnet_core.geometry.frame_tree import FrameTree
from fpnet_core.odometry import STALE_BEFORE_RESTART, KissOdometry
from fpnet_core.stamps import ClockGuard
from fpnet_ros.inputs import NO_TF, TFMessage
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import STREAM, TF, TF_STATIC, ErrorLog, run_node, sensor_data
from fpnet_ros.work import DroppingWorker, Numbering
from msg_adapters.clouds import cloud_from_msg, cloud_to_msg
from msg_adapters.diagnostics import diagnostics_to_msg, health_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.stamps import stamp_from_msg
from msg_adapters.transforms import transform_from_msg, transform_to_msg

_DIAGNOSTICS_PERIOD_S = 1.0


class OdometryParameters(Section):
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


class OdometryNode(Node):
    """
    Registers every cloud on ``pointcloud_topic``, in a thread of its own.

    Publishes ``kiss/odometry``, the pose at the cloud's stamp, and ``kiss/frame``, the cloud
    without the motion during its sweep, with the cloud's header. With a ``base_frame`` the pose
    is that frame's, by its place in ``/tf_static``.
    """

    def __init__(self) -> None:
        super().__init__('odometry')
        self._errors = ErrorLog(self.get_logger().error)
        self._settings = ParameterTree(self, OdometryParameters).value
        self._kiss = KissOdometry(ParameterTree(self, OdometryConfig, 'odometry.').value)
        self._tree = FrameTree()
        self._odometry_publisher = self._publisher(Odometry, 'kiss/odometry', STREAM)
        self._frame_publisher = self._publisher(PointCloud2, 'kiss/frame', STREAM)
        self._diagnostics = self._publisher(DiagnosticArray, '/diagnostics', STREAM)
        self._connect_tf()
        self._clouds = Numbering()
        self._reported_drops = 0
        self._clock = ClockGuard(STALE_BEFORE_RESTART)
        self._newest_ns: int | None = None
        self._scans = DroppingWorker(
            self._register, self._settings.max_pending_scans, self._report, 'registration'
        )
        self.create_subscription(
            PointCloud2,
            'pointcloud_topic',
            self._on_cloud,
            sensor_data(self._settings.max_pending_scans),
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            raw=True,  # unpacked by the worker: it takes longer than this thread has
        )
        self.create_timer(_DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)

    def destroy_node(self) -> None:
        """End the worker first."""
        self._scans.close()
        super().destroy_node()

    def _publisher(self, kind: type, topic: str, qos: Any) -> Any:
        options = QoSOverridingOptions.with_default_policies()
        return self.create_publisher(kind, topic, qos, qos_overriding_options=options)

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
        self._scans.put(data)

    def _register(self, data: bytes) -> None:
        msg = deserialize_message(data, PointCloud2)
        cloud = cloud_from_msg(msg)
        sensor = msg.header.frame_id.lstrip('/')
        moving = self._settings.base_frame or sensor
        T_base_sensor = self._tree.mount(moving, sensor)
        self._follow_clock(stamp_from_msg(msg.header.stamp))
        scan = self._kiss.register(cloud.points, cloud.time_s)
        # As KISS-ICP's node: odom is where the base, not the sensor, was at the first cloud.
        T_odom_base = T_base_sensor @ scan.T_odom_sensor @ np.linalg.inv(T_base_sensor)
        self._publish(T_odom_base, stamp_from_msg(msg.header.stamp), moving)
        self._frame_publisher.publish(
            cloud_to_msg(scan.points, stamp_from_msg(msg.header.stamp), sensor)
        )

    def _follow_clock(self, stamp_ns: int) -> None:
        """Refuse a cloud that is not newer than the last; begin anew where the clock went back."""
        last_ns = stamp_ns - 1 if self._newest_ns is None else self._newest_ns
        back_s = self._clock.back_s(stamp_ns, last_ns)
        if back_s is not None:
            self.get_logger().warning(f'the clock went back by {back_s:.3f} s; starting anew')
            self._kiss.reset()
        self._newest_ns = stamp_ns

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
        dropped, lost = self._scans.dropped, self._clouds.lost
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
        self._diagnostics.publish(diagnostics_to_msg([status], now_ns))

    def _report(self, error: BaseException) -> None:
        if isinstance(error, FpnetError):
            self._errors.report(error)
        elif self.context.ok():
            self.get_logger().error(f'internal error, please report it: {error!r}')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    return run_node(OdometryNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
