# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from array import array
import time

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


def test_nan_points_are_dropped(received):
    points = _points()
    points[2, 1] = np.nan
    points[5, 2] = np.inf
    cloud = cloud_from_msg(received(cloud_to_msg(points, STAMP_NS, 'lidar')))
    np.testing.assert_array_equal(
        cloud.points, np.delete(points, [2, 5], axis=0).astype(np.float32)
    )


def test_padded_point_step_and_rows_are_read(received):
    points = _points(6).astype(np.float32)
    msg = cloud_to_msg(points, STAMP_NS, 'lidar')
    padded = np.full((2, 3 * 20 + 8), 0xEE, dtype=np.uint8)
    for index, point in enumerate(points):
        row, column = divmod(index, 3)
        padded[row, column * 20 : column * 20 + 12] = np.frombuffer(point.tobytes(), np.uint8)
    msg.height, msg.width, msg.point_step, msg.row_step = 2, 3, 20, 3 * 20 + 8
    msg.data = array('B', padded.tobytes())
    np.testing.assert_array_equal(cloud_from_msg(received(msg)).points, points)


def test_big_endian_data_is_read(received):
    points = _points().astype(np.float32)
    msg = cloud_to_msg(points, STAMP_NS, 'lidar')
    msg.is_bigendian = True
    msg.data = array('B', points.astype('>f4').tobytes())
    np.testing.assert_array_equal(cloud_from_msg(received(msg)).points, points)


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


def test_a_large_cloud_is_filled_fast():
    points = np.ones((300_000, 3), dtype=np.float32)
    start = time.perf_counter()
    assert len(cloud_from_msg(cloud_to_msg(points, STAMP_NS, 'lidar')).points) == 300_000
    assert time.perf_counter() - start < 0.5
