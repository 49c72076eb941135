# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``sensor_msgs/LaserScan`` and ``MultiEchoLaserScan`` to arrays."""

from __future__ import annotations

from fpnet_core.io.laserscan import LaserPoints, LaserScanLike, decode_laser


def laser_from_msg(msg: LaserScanLike) -> LaserPoints:
    """
    Return points ``(P, 3) float32`` in the message's frame, z = 0, and their times.

    Rays without a valid range are dropped; of several echoes the nearest valid one counts. Times
    count from the header's stamp, the instant of the first ray.

    Raises
    ------
    CloudFormatError
        If limits, angles or times contradict each other.
    """
    return decode_laser(msg)
