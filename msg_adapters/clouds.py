# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``sensor_msgs/PointCloud2``, to and from arrays."""

from __future__ import annotations

from array import array
from typing import Any

from numpy.typing import ArrayLike

from fpnet_core.io.pointcloud2 import (
    TIME_FIELDS,
    CloudArrays,
    decode_cloud,
    encode_points,
)
from msg_adapters.stamps import header_to_msg


def cloud_from_msg(msg: Any) -> CloudArrays:
    """
    Return points ``(P, 3) float32`` in the message's frame, and their times.

    Raises
    ------
    CloudFormatError
        If a coordinate field is missing or unusable, or lengths are inconsistent.
    """
    return decode_cloud(msg)  # without NaN and zeros, which are no returns


def carries_times(msg: Any) -> bool:
    """Return whether a message has a time for every point, without decoding it."""
    return any(field.name in TIME_FIELDS for field in msg.fields)


def cloud_to_msg(
    points: ArrayLike,
    stamp_ns: int,
    frame_id: str,
    intensity: ArrayLike | None = None,
    ring: ArrayLike | None = None,
    time_s: ArrayLike | None = None,
    viewpoints: ArrayLike | None = None,
) -> Any:
    """
    Return an unordered PointCloud2 of ``points (P, 3)`` [m] and optional columns ``(P,)``.

    ``viewpoints (P, 3)`` [m] are the origins of the rays, for a cloud of several scanners.

    Raises
    ------
    CloudFormatError
        If a column has another length than the points.
    """
    from sensor_msgs.msg import PointCloud2, PointField

    fields, point_step, data = encode_points(points, intensity, ring, time_s, viewpoints)
    return PointCloud2(
        header=header_to_msg(stamp_ns, frame_id),
        height=1,
        width=len(data) // point_step,
        fields=[
            PointField(name=f.name, offset=f.offset, datatype=f.datatype, count=f.count)
            for f in fields
        ],
        is_bigendian=False,
        point_step=point_step,
        row_step=len(data),
        # The setter checks anything but array('B') byte by byte: 1.5 s for a large cloud.
        data=array('B', data),
        is_dense=True,
    )
