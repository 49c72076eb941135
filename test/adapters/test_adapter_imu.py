# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import numpy as np
import pytest

from fpnet_core.errors import OdometryError
from msg_adapters.imu import rate_from_msg


def imu(rate):
    from sensor_msgs.msg import Imu

    msg = Imu()
    msg.header.frame_id = 'imu_link'
    msg.angular_velocity.x, msg.angular_velocity.y, msg.angular_velocity.z = rate
    return msg


def test_an_imu_tells_its_rates(received):
    np.testing.assert_array_equal(rate_from_msg(received(imu((0.1, -0.2, 3.0)))), (0.1, -0.2, 3.0))


def test_one_without_a_gyroscope_or_with_nonsense_is_refused(received):
    msg = imu((0.0, 0.0, 0.0))
    msg.angular_velocity_covariance[0] = -1.0
    with pytest.raises(OdometryError, match="'imu_link': the IMU has no gyroscope"):
        rate_from_msg(received(msg))
    with pytest.raises(OdometryError, match='angular_velocity is not finite'):
        rate_from_msg(received(imu((0.0, float('nan'), 0.0))))
