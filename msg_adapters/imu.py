# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Angular rates from ``sensor_msgs/Imu``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import OdometryError
from fpnet_core.io.messages import rate_of


def rate_from_msg(msg: Any) -> NDArray[np.float64]:
    """
    Return the angular rate ``(3,)`` of an Imu message, in its frame [rad/s].

    Raises
    ------
    OdometryError
        If it has no gyroscope, or a value is not finite.
    """
    try:
        return rate_of(msg)
    except ValueError as error:
        raise OdometryError(f'Imu of {msg.header.frame_id!r}: {error}') from None
