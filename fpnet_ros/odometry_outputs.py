# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publishers of the odometry node: poses with velocities, clouds, and TF if enabled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nav_msgs.msg import Odometry
import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from sensor_msgs.msg import PointCloud2

from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.geometry.motion import twist
from fpnet_core.io.scans import RegisteredSweep
from fpnet_core.io.topic_names import KISS_FRAME, KISS_ODOMETRY, TF_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.optional_messages import NO_TF, TFMessage
from fpnet_ros.robot_odometry import RobotOdometryParameters
from fpnet_ros.runtime import STREAM, TF
from msg_adapters.clouds import cloud_to_msg
from msg_adapters.odometry import odometry_to_msg
from msg_adapters.transforms import transform_to_msg

_TWIST_VARIANCES = (0.15**2,) * 3 + (0.06**2,) * 3
"""
Variances of the velocity between two sweeps [m^2/s^2], [rad^2/s^2]. Fitted: to simulated
recordings (`python benchmarks/wirings.py`).
"""

_SENT = 100  # numerical: own transforms kept for comparison: ten seconds of sweeps

Array = NDArray[np.float64]


class OdometryParameters(RobotOdometryParameters):
    """Parameters of the odometry node, named as in KISS-ICP's node."""

    base_frame: str = Field(
        '',
        description='Frame whose pose is published; empty: the root of the sensor in '
        '/tf_static, else the sensor.',
    )
    lidar_odom_frame: str = Field('odom_lidar', description='Frame of the published odometry.')
    publish_odom_tf: bool = Field(
        True,
        description='Publish the odometry as TF as well; false if the robot has its own.',
    )
    invert_odom_tf: bool = Field(
        False, description='Publish TF from the moving frame to the odometry frame.'
    )
    position_covariance: float = Field(
        0.1, ge=0.0, description='Variance of the position in the messages [m^2].'
    )
    orientation_covariance: float = Field(
        0.1, ge=0.0, description='Variance of the orientation in the messages [rad^2].'
    )
    use_imu: bool = Field(
        False, description='Take rotations between sweeps from the gyroscope on the topic imu.'
    )
    max_pending_scans: int = Field(
        10, ge=1, le=1000, description='Number of clouds that may wait; the oldest are dropped.'
    )


class OdometryOutputs:
    """
    The publishers of one odometry node.

    Parameters
    ----------
    publisher
        Creates a publisher from message class, topic and QoS.
    subscribe
        Creates a subscription from message class, topic, callback and QoS.
    settings
        Frames and covariances.
    warn
        Logs a warning.
    """

    def __init__(
        self,
        publisher: Callable[[type, str, Any], Any],
        subscribe: Callable[[type, str, Callable[[Any], None], Any], Any],
        settings: OdometryParameters,
        warn: Callable[[str], Any],
    ) -> None:
        self._settings, self._warn = settings, warn
        self.moving = ''
        """The frame whose pose was published last, empty before the first."""
        self._last: tuple[int, Array] | None = None  # stamp and pose that were published last
        self._odometry = publisher(Odometry, KISS_ODOMETRY, STREAM)
        self._frames = publisher(PointCloud2, KISS_FRAME, STREAM)
        self._sent: tuple[Any, ...] = ()  # own transforms, which return on /tf
        self._tf = None
        if TFMessage is None:
            warn(f'no TF: {NO_TF}')
        elif settings.publish_odom_tf:
            self._tf = publisher(TFMessage, TF_TOPIC, TF)
            if not settings.invert_odom_tf:
                subscribe(TFMessage, TF_TOPIC, self._on_tf, TF)

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
        self._frames.publish(
            cloud_to_msg(found.points, stamp_ns, sensor, viewpoints=found.viewpoints)
        )

    def begin_anew(self) -> None:
        """Forget the last pose, after the clock went back."""
        self._last = None

    def _publish_pose(self, T_odom_base: Array, stamp_ns: int) -> None:
        settings, odom, moving = self._settings, self._settings.lidar_odom_frame, self.moving
        variances = (settings.position_covariance,) * 3 + (settings.orientation_covariance,) * 3
        velocity = self._velocity(T_odom_base, stamp_ns)
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

    def _velocity(self, T_odom_base: Array, stamp_ns: int) -> Array | None:
        """Return the velocity since the last sweep, None after the first."""
        last, self._last = self._last, (stamp_ns, T_odom_base)
        if last is None:
            return None
        return twist(np.linalg.inv(last[1]) @ T_odom_base, (stamp_ns - last[0]) / NS_PER_S)

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
