# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0


import numpy as np
import pytest

from fpnet_core.errors import CloudFormatError
from msg_adapters.clouds import cloud_from_msg, cloud_to_msg

STAMP_NS = 1_700_000_000_123_456_789


def _points(count: int = 7) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(count, 3)).astype(np.float32) * (9.0, 4.0, 1.0)


def test_cloud_survives_the_round_trip(received):
    points = _points().astype(np.float32)
    count = len(points)
    msg = received(
        cloud_to_msg(
            points,
            STAMP_NS,
            'lidar',
            intensity=np.arange(count),
            ring=np.arange(count),
            time_s=np.linspace(0.0, 0.1, count, dtype=np.float32),
        )
    )
    assert msg.header.frame_id == 'lidar'
    assert (msg.header.stamp.sec, msg.header.stamp.nanosec) == (1_700_000_000, 123_456_789)
    assert [field.name for field in msg.fields] == ['x', 'y', 'z', 'intensity', 'ring', 'time']
    assert msg.row_step == msg.width * msg.point_step == len(msg.data)
    cloud = cloud_from_msg(msg)
    np.testing.assert_array_equal(cloud.points, points)
    np.testing.assert_allclose(cloud.time_s, np.linspace(0.0, 0.1, count), atol=1e-7)


def test_empty_cloud_survives_the_round_trip(received):
    cloud = cloud_from_msg(received(cloud_to_msg(np.zeros((0, 3)), STAMP_NS, 'lidar')))
    assert cloud.points.shape == (0, 3)


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        (lambda m: setattr(m, 'data', m.data[:-5]), 'truncated'),
        (lambda m: setattr(m, 'point_step', 8), 'point step|point_step'),
        (lambda m: setattr(m, 'row_step', 4), 'row_step'),
        (lambda m: setattr(m, 'fields', m.fields[:2]), 'lacks field z'),
        (lambda m: setattr(m.fields[0], 'datatype', 77), 'datatype'),
    ],
)
def test_malformed_clouds_are_refused(received, change, message):
    msg = cloud_to_msg(_points(), STAMP_NS, 'lidar')
    change(msg)
    with pytest.raises(CloudFormatError, match=message):
        cloud_from_msg(received(msg))


def test_columns_must_be_as_long_as_the_points():
    with pytest.raises(CloudFormatError, match='intensity'):
        cloud_to_msg(_points(), STAMP_NS, 'lidar', intensity=np.zeros(3))
