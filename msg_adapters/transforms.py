# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``geometry_msgs/Pose`` and ``TransformStamped``, to and from rigid (4, 4) matrices."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.errors import OdometryError
from fpnet_core.geometry.rigid3d import quaternion_from_rigid
from fpnet_core.io.messages import StampedTransform, rigid_of, transform_of
from msg_adapters.stamps import header_to_msg


def matrix_from_pose_msg(msg: Any) -> NDArray[np.float64]:
    """
    Return the (4, 4) transform of a ``geometry_msgs/Pose``; its quaternion is normalised.

    Raises
    ------
    OdometryError
        If a value is not finite or the quaternion is zero.
    """
    try:
        return rigid_of(msg.position, msg.orientation)
    except ValueError as error:
        raise OdometryError(f'pose message is unusable: {error}; fix its publisher') from None


def matrix_to_pose_msg(T_frame_body: ArrayLike) -> Any:
    """
    Return a ``geometry_msgs/Pose`` of a rigid (4, 4) transform.

    Raises
    ------
    OdometryError
        If the matrix is not rigid.
    """
    from geometry_msgs.msg import Point, Pose, Quaternion

    try:
        x, y, z, w = map(float, quaternion_from_rigid(T_frame_body))
    except ValueError as error:
        raise OdometryError(f'pose to publish: {error}') from None
    position = Point(**dict(zip('xyz', np.asarray(T_frame_body)[:3, 3].tolist(), strict=True)))
    return Pose(position=position, orientation=Quaternion(x=x, y=y, z=z, w=w))


def transform_from_msg(msg: Any) -> StampedTransform:
    """
    Return the transform of a ``TransformStamped``; leading slashes of frames are dropped.

    Raises
    ------
    OdometryError
        If a value is not finite or the quaternion is zero.
    """
    try:
        return transform_of(msg)
    except ValueError as error:
        raise OdometryError(
            f'transform {msg.header.frame_id} -> {msg.child_frame_id} is unusable: {error}; '
            'fix its publisher'
        ) from None


def transforms_from_msg(
    msg: Any, report: Callable[[OdometryError], Any]
) -> list[StampedTransform]:
    """Return the transforms of a ``tf2_msgs/TFMessage``; report unusable ones instead."""
    found = []
    for each in msg.transforms:
        try:
            found.append(transform_from_msg(each))
        except OdometryError as error:
            report(error)
    return found


def transform_to_msg(T_parent_child: ArrayLike, stamp_ns: int, parent: str, child: str) -> Any:
    """
    Return a ``geometry_msgs/TransformStamped``.

    Raises
    ------
    OdometryError
        If the matrix is not rigid.
    """
    from geometry_msgs.msg import Transform, TransformStamped, Vector3

    pose = matrix_to_pose_msg(T_parent_child)
    position = pose.position
    return TransformStamped(
        header=header_to_msg(stamp_ns, parent),
        child_frame_id=child,
        transform=Transform(
            translation=Vector3(x=position.x, y=position.y, z=position.z),
            rotation=pose.orientation,
        ),
    )
