# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion of times, poses and transforms in messages to plain values.

The functions only read attributes, so that messages of rclpy and of rosbags both work and the
core needs no message package.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.geometry.rigid3d import rigid_from_quaternion
from fpnet_core.stamps import NS_PER_S

_NOT_MEASURED = -1.0  # given: sensor_msgs/Imu


@dataclass(frozen=True, eq=False)
class StampedTransform:
    """``T_parent_child (4, 4)`` at ``stamp_ns``; frame names have no leading slash."""

    stamp_ns: int
    parent: str
    child: str
    T_parent_child: NDArray[np.float64]


def stamp_to_ns(stamp: Any) -> int:
    """Return the nanoseconds of a ``builtin_interfaces/Time``."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)


def rigid_of(position: Any, rotation: Any) -> NDArray[np.float64]:
    """
    Return the (4, 4) transform of a message's position and quaternion, normalised.

    Raises
    ------
    ValueError
        If a value is not finite or the quaternion is zero.
    """
    return rigid_from_quaternion(
        (position.x, position.y, position.z), (rotation.x, rotation.y, rotation.z, rotation.w)
    )


def has_gyro(message: Any) -> bool:
    """Return whether a ``sensor_msgs/Imu`` message has angular rates, by its covariance."""
    return bool(message.angular_velocity_covariance[0] != _NOT_MEASURED)


def rate_of(message: Any) -> NDArray[np.float64]:
    """
    Return the angular rate ``(3,)`` of a ``sensor_msgs/Imu``, in its frame [rad/s].

    Raises
    ------
    ValueError
        If it has no gyroscope (its covariance is -1), or a value is not finite.
    """
    if not has_gyro(message):
        raise ValueError('the IMU has no gyroscope (angular_velocity_covariance[0] is -1)')
    rate = message.angular_velocity
    values = np.array([rate.x, rate.y, rate.z], dtype=np.float64)
    if not np.isfinite(values).all():
        raise ValueError('angular_velocity is not finite')
    return values


def transform_of(message: Any) -> StampedTransform:
    """Convert a ``geometry_msgs/TransformStamped``; raise ValueError as :func:`rigid_of`."""
    transform = message.transform
    return StampedTransform(
        stamp_to_ns(message.header.stamp),
        plain_frame(message.header.frame_id),
        plain_frame(message.child_frame_id),
        rigid_of(transform.translation, transform.rotation),
    )


def transforms_of(message: Any, child: str = '') -> Iterator[StampedTransform]:
    """
    Yield all transforms of a ``tf2_msgs/TFMessage``, or only those of one child frame.

    Raises
    ------
    ValueError
        If a transform is not rigid; after those before it have been yielded.
    """
    for each in message.transforms:
        if not child or plain_frame(each.child_frame_id) == child:
            yield transform_of(each)
