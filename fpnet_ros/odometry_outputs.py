# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publishers of the odometry node: poses with velocities, clouds, and TF if enabled."""

from __future__ import annotations

from typing import Any

from nav_msgs.msg import Odometry
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2

from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.geometry.motion import twist
from fpnet_core.io.scans import RegisteredSweep
from fpnet_core.io.topic_names import KISS_FRAME, KISS_ODOMETRY, TF_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.params import OwnValues
from fpnet_ros.runtime import NO_TF, STREAM, TF, TFMessage
from fpnet_ros.settings import OdometryParameters
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.transforms import transform_to_msg

Array = NDArray[np.float64]

_TWIST_VARIANCES = (0.15**2,) * 3 + (0.06**2,) * 3
"""
Variances of the velocity between two sweeps [m^2/s^2], [rad^2/s^2]. Fitted: to simulated
recordings (`python benchmarks/wirings.py`).
"""

_SENT = 100  # numerical: own transforms kept for comparison: ten seconds of sweeps


class OdometryOutputs:
    """The publishers of one odometry node; ``settings`` has frames and covariances."""

    def __init__(self, node: OwnValues, settings: OdometryParameters) -> None:
        self._settings, self._warn = settings, node.get_logger().warning
        self.moving = ''
        """The frame whose pose was published last, empty before the first."""
        self._last: tuple[int, Array] | None = None  # stamp and pose that were published last
        self._odometry = node.add_publisher(Odometry, KISS_ODOMETRY, STREAM)
        self._frames = node.add_publisher(PointCloud2, KISS_FRAME, STREAM)
        self._sent: tuple[Any, ...] = ()  # own transforms, which return on /tf
        self._tf = None
        if TFMessage is None:
            self._warn(f'no TF: {NO_TF}')
        elif settings.publish_odom_tf:
            self._tf = node.add_publisher(TFMessage, TF_TOPIC, TF)
            if not settings.invert_odom_tf:
                node.add_subscription(TFMessage, TF_TOPIC, self._on_tf, TF)

    def publish(
        self,
        found: RegisteredSweep,
        stamp_ns: int,
        sensor: str,
        moving: str,
        T_moving_sensor: Array,
    ) -> None:
        """Publish a sweep and the pose of ``moving``; ``T_moving_sensor (4, 4)`` is the mount."""
        self.moving = moving
        self._publish_pose(found.T_odom_sensor @ np.linalg.inv(T_moving_sensor), stamp_ns)
        cloud = cloud_to_msg(found.points, stamp_ns, sensor, viewpoints=found.viewpoints)
        self._frames.publish(cloud)

    def begin_anew(self) -> None:
        """Forget the last pose, after the clock went back."""
        self._last = None

    def _publish_pose(self, T_odom_base: Array, stamp_ns: int) -> None:
        settings, odom, moving = self._settings, self._settings.lidar_odom_frame, self.moving
        last, self._last = self._last, (stamp_ns, T_odom_base)
        velocity = None  # unknown after the first sweep
        if last is not None:
            seconds = (stamp_ns - last[0]) / NS_PER_S
            velocity = twist(np.linalg.inv(last[1]) @ T_odom_base, seconds)
        variances = (settings.position_covariance,) * 3 + (settings.orientation_covariance,) * 3
        self._odometry.publish(
            odometry_to_msg(
                T_odom_base, stamp_ns, odom, moving, variances, velocity, _TWIST_VARIANCES
            )
        )
        publisher = self._tf
        if publisher is None:
            return
        if settings.invert_odom_tf:
            transform = transform_to_msg(np.linalg.inv(T_odom_base), stamp_ns, moving, odom)
        else:
            transform = transform_to_msg(T_odom_base, stamp_ns, odom, moving)
        self._sent = (*self._sent[1 - _SENT :], transform)
        publisher.publish(TFMessage(transforms=[transform]))

    def _on_tf(self, msg: Any) -> None:
        """
        Stop publishing TF if another node publishes a parent of the same frame.

        Its parent may have the name of ours, for example odom; then pose or stamp differ.
        """
        own = self._settings.lidar_odom_frame
        for transform in msg.transforms:
            parent = plain_frame(transform.header.frame_id)
            child = plain_frame(transform.child_frame_id)
            is_ours = parent == own and transform in self._sent
            if self.moving == child and not is_ours and self._tf:
                self._tf = None
                self._warn(
                    f'another node publishes {parent} -> {self.moving} on /tf, so ours from {own} '
                    f'is withheld; set publish_odom_tf: false, and odom_frame: {parent} for the '
                    'localizer'
                )
