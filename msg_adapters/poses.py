# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar poses to and from ``PoseStamped``, with and without covariance, and ``Path``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.errors import OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.geometry.frame_tree import plain_frame
from msg_adapters.stamps import header_to_msg, stamp_from_msg
from msg_adapters.transforms import matrix_from_pose_msg, matrix_to_pose_msg

# Indices of x, y and yaw in ROS's order x, y, z, roll, pitch, yaw.
_PLANAR = np.ix_((0, 1, 5), (0, 1, 5))
_ROS_SHAPE = (6, 6)  # given


@dataclass(frozen=True)
class StampedPose:
    """A planar pose ``T_frame_body`` in the frame called ``frame_id`` at ``stamp_ns``."""

    stamp_ns: int
    frame_id: str
    T_frame_body: SE2


def pose_from_msg(msg: Any) -> StampedPose:
    """
    Return the planar pose of a PoseStamped; height, roll and pitch are dropped.

    Raises
    ------
    OdometryError
        If a value is not finite or the quaternion is zero.
    """
    pose = SE2.from_matrix4(matrix_from_pose_msg(msg.pose))
    return StampedPose(stamp_from_msg(msg.header.stamp), str(msg.header.frame_id), pose)


def pose_to_msg(T_frame_body: SE2, stamp_ns: int, frame_id: str) -> Any:
    """Return a PoseStamped at height 0."""
    from geometry_msgs.msg import PoseStamped

    return PoseStamped(
        header=header_to_msg(stamp_ns, frame_id),
        pose=matrix_to_pose_msg(T_frame_body.as_matrix4()),
    )


@dataclass(frozen=True, eq=False)
class UncertainPose:
    """A stamped pose and the covariance ``(3, 3)`` of its x, y [m] and yaw [rad]."""

    pose: StampedPose
    cov: NDArray[np.float64]


def uncertain_pose_from_msg(msg: Any) -> UncertainPose:
    """
    Return the planar pose and covariance of a PoseWithCovarianceStamped.

    Raises
    ------
    OdometryError
        If a value is not finite or the quaternion is zero.
    """
    cov = np.asarray(msg.pose.covariance, dtype=np.float64).reshape(_ROS_SHAPE)[_PLANAR]
    if not np.isfinite(cov).all():
        raise OdometryError('the covariance of a pose holds NaN or infinity; fix its publisher')
    pose = SE2.from_matrix4(matrix_from_pose_msg(msg.pose.pose))
    stamp_ns = stamp_from_msg(msg.header.stamp)
    return UncertainPose(StampedPose(stamp_ns, plain_frame(msg.header.frame_id), pose), cov)


def uncertain_pose_to_msg(T_frame_body: SE2, cov: ArrayLike, stamp_ns: int, frame_id: str) -> Any:
    """Return a PoseWithCovarianceStamped; ``cov (3, 3)`` is over x, y [m] and yaw [rad]."""
    from geometry_msgs.msg import PoseWithCovarianceStamped

    msg = PoseWithCovarianceStamped(header=header_to_msg(stamp_ns, frame_id))
    full = np.zeros(_ROS_SHAPE)
    full[_PLANAR] = cov
    msg.pose.pose = matrix_to_pose_msg(T_frame_body.as_matrix4())
    msg.pose.covariance = full.ravel()
    return msg


def path_to_msg(poses: Sequence[Any], stamp_ns: int, frame_id: str) -> Any:
    """Return a ``nav_msgs/Path`` of PoseStamped messages."""
    from nav_msgs.msg import Path

    return Path(header=header_to_msg(stamp_ns, frame_id), poses=list(poses))
