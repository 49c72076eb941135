# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every adapter is tried on the messages of each library that may hand them over."""

import pytest

rclpy_serialization = pytest.importorskip('rclpy.serialization')


def _as_built(msg):
    return msg


def _through_rclpy(msg):
    data = rclpy_serialization.serialize_message(msg)
    return rclpy_serialization.deserialize_message(data, type(msg))


def _through_rosbags(msg):
    from rosbags.typesys import Stores, get_typestore

    package = type(msg).__module__.partition('.msg.')[0]
    data = rclpy_serialization.serialize_message(msg)
    msgtype = f'{package}/msg/{type(msg).__name__}'
    return get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(data, msgtype)


@pytest.fixture(params=[_as_built, _through_rclpy, _through_rosbags], ids=lambda f: f.__name__)
def received(request):
    """Turn a message that an adapter built into what a subscriber or bag reader sees."""
    return request.param
