# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arrays from ``sensor_msgs/LaserScan`` and ``MultiEchoLaserScan``."""

from __future__ import annotations

from fpnet_core.io.laserscan import LaserPoints, LaserScanLike, decode_laser


def laser_from_msg(msg: LaserScanLike) -> LaserPoints:
    """
    Return points ``(P, 3) float32`` in the message's frame, z = 0, and their times.

    Rays without a valid range are dropped; of several echoes the nearest valid one is used. Times
    are relative to the header's stamp, the instant of the first ray.

    Raises
    ------
    CloudFormatError
        If limits, angles or times are inconsistent.
    """
    return decode_laser(msg)
