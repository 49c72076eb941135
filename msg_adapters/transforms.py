# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``geometry_msgs/Pose``, to and from rigid (4, 4) matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.errors import OdometryError
from fpnet_core.geometry.rigid3d import quaternion_from_rigid, rigid_from_quaternion


def matrix_from_pose_msg(msg: Any) -> NDArray[np.float64]:
    """
    Return the (4, 4) transform of a ``geometry_msgs/Pose``; its quaternion is normalised.

    Raises
    ------
    OdometryError
        If a value is not finite or the quaternion is zero.
    """
    position, rotation = msg.position, msg.orientation
    try:
        return rigid_from_quaternion(
            (position.x, position.y, position.z),
            (rotation.x, rotation.y, rotation.z, rotation.w),
        )
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
