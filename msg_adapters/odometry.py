# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``nav_msgs/Odometry``, to and from rigid (4, 4) matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.io.messages import StampedTransform
from msg_adapters.stamps import header_to_msg, stamp_from_msg
from msg_adapters.transforms import matrix_from_pose_msg, matrix_to_pose_msg

_UNKNOWN = -1.0  # given: marks values without a measurement in sensor_msgs


def odometry_from_msg(msg: Any) -> StampedTransform:
    """
    Return the pose of an Odometry message, as the transform from ``child_frame_id`` to its frame.

    Velocities, covariances and leading slashes of frames are dropped.

    Raises
    ------
    OdometryError
        If a value is not finite or the quaternion is zero.
    """
    return StampedTransform(
        stamp_from_msg(msg.header.stamp),
        plain_frame(msg.header.frame_id),
        plain_frame(msg.child_frame_id),
        matrix_from_pose_msg(msg.pose.pose),
    )


def odometry_to_msg(
    T_odom_child: ArrayLike,
    stamp_ns: int,
    frame_id: str,
    child_frame_id: str,
    variances: ArrayLike = (0.0,) * 6,
    twist: ArrayLike | None = None,
    twist_variances: ArrayLike = (0.0,) * 6,
) -> Any:
    """
    Return an Odometry message.

    ``variances (6,)`` are those of x, y, z [m^2], roll, pitch, yaw [rad^2]; zeros mean unknown.
    ``twist (6,)`` is the velocity in the child's frame [m/s], [rad/s]; None: zeros, with a first
    variance of -1, which means unknown.

    Raises
    ------
    OdometryError
        If the matrix is not rigid.
    """
    from nav_msgs.msg import Odometry

    msg = Odometry(header=header_to_msg(stamp_ns, frame_id), child_frame_id=child_frame_id)
    msg.pose.pose = matrix_to_pose_msg(T_odom_child)
    msg.pose.covariance = np.diag(np.asarray(variances, dtype=np.float64)).ravel()
    if twist is None:
        msg.twist.covariance[0] = _UNKNOWN
        return msg
    values = np.asarray(twist, dtype=np.float64).tolist()
    for vector, three in (
        (msg.twist.twist.linear, values[:3]),
        (msg.twist.twist.angular, values[3:]),
    ):
        vector.x, vector.y, vector.z = three
    msg.twist.covariance = np.diag(np.asarray(twist_variances, dtype=np.float64)).ravel()
    return msg
