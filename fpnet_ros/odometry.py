# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lidar odometry by KISS-ICP, with the topics and frames of KISS-ICP's own ROS node."""

from __future__ import annotations

from collections.abc import Sequence
import sys

from nav_msgs.msg import Odometry
from pydantic import Field
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import PointCloud2

from fpnet_core.config import OdometryConfig, Section
from fpnet_core.errors import FpnetError
from fpnet_core.odometry import KissOdometry
from fpnet_ros.params import declare_section
from fpnet_ros.runtime import SENSOR_DATA, STREAM, ErrorLog, run_node
from msg_adapters.clouds import cloud_from_msg, cloud_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.stamps import stamp_from_msg


class OdometryParameters(Section):
    """Frames, named as in KISS-ICP's node."""

    lidar_odom_frame: str = Field('odom_lidar', description='Frame of the published odometry.')


class OdometryNode(Node):
    """
    Registers every cloud on ``pointcloud_topic``.

    Publishes ``kiss/odometry``, the sensor's pose at the cloud's stamp, and ``kiss/frame``, the
    cloud without the motion during its sweep, with the cloud's header.
    """

    def __init__(self) -> None:
        super().__init__('odometry')
        self._errors = ErrorLog(self.get_logger().error)
        self._odom_frame = declare_section(self, OdometryParameters).lidar_odom_frame
        self._kiss = KissOdometry(declare_section(self, OdometryConfig, 'odometry.'))
        self._odometry_publisher = self.create_publisher(Odometry, 'kiss/odometry', STREAM)
        self._frame_publisher = self.create_publisher(PointCloud2, 'kiss/frame', STREAM)
        self.create_subscription(
            PointCloud2,
            'pointcloud_topic',
            self._register,
            SENSOR_DATA,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def _register(self, msg: PointCloud2) -> None:
        try:
            cloud = cloud_from_msg(msg)
            scan = self._kiss.register(cloud.points, cloud.time_s)
        except FpnetError as error:
            self._errors.report(error)
            return
        stamp_ns, sensor_frame = stamp_from_msg(msg.header.stamp), msg.header.frame_id
        self._odometry_publisher.publish(
            odometry_to_msg(scan.T_odom_sensor, stamp_ns, self._odom_frame, sensor_frame)
        )
        self._frame_publisher.publish(cloud_to_msg(scan.points, stamp_ns, sensor_frame))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    return run_node(OdometryNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
