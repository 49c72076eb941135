# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``geometry_msgs/PoseStamped``, to and from planar poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fpnet_core.geometry import SE2
from msg_adapters.stamps import header_to_msg, stamp_from_msg
from msg_adapters.transforms import matrix_from_pose_msg, matrix_to_pose_msg


@dataclass(frozen=True)
class StampedPose:
    """A planar pose ``T_frame_body`` in the frame called ``frame_id`` at ``stamp_ns``."""

    stamp_ns: int
    frame_id: str
    T_frame_body: SE2


def pose_from_msg(msg: Any) -> StampedPose:
    """
    Return what a PoseStamped says about the plane; height, roll and pitch are dropped.

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
