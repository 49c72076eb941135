# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The PointCloud2 codec against every way in which drivers lay out, or break, a cloud."""

import numpy as np
import pytest

from fpnet_core.errors import CloudFormatError
from fpnet_core.io.pointcloud2 import (
    DATATYPES,
    PointField,
    decode_points,
    encode_points,
    sweep_seconds,
)

POINTS = np.array([[1.5, -2.25, 0.125], [10.0, 20.0, -30.0], [-7.0, 0.5, 3.0]], dtype=np.float32)
XYZ = [PointField('x', 0, 7), PointField('y', 4, 7), PointField('z', 8, 7)]


def decode(fields=XYZ, data=None, step=12, row=None, width=3, height=1, big=False):
    data = POINTS.tobytes() if data is None else data
    return decode_points(
        fields, data, step, width * step if row is None else row, width, height, big
    )


def test_round_trip_keeps_values_and_times():
    time = np.array([0.0, 0.02, 0.1])
    fields, step, data = encode_points(POINTS, np.ones(3), np.array([0, 5, 31]), time)
    assert [f.name for f in fields] == ['x', 'y', 'z', 'intensity', 'ring', 'time']
    assert step == 4 * 4 + 2 + 8
    cloud = decode(fields, data, step)
    np.testing.assert_array_equal(cloud.points, POINTS)
    np.testing.assert_allclose(cloud.time_s, time)
    assert cloud.points.dtype == np.float32


def test_viewpoints_make_the_round_trip_and_go_with_their_points():
    begins = np.array([[0.3, 0.1, 0.0], [-0.3, 0.0, 0.0], [0.3, 0.1, 0.5]], dtype=np.float32)
    fields, step, data = encode_points(POINTS, viewpoints=begins)
    assert [f.name for f in fields] == ['x', 'y', 'z', 'vp_x', 'vp_y', 'vp_z']
    np.testing.assert_array_equal(decode(fields, data, step).viewpoints, begins)
    begins[1, 2] = np.nan
    fields, step, data = encode_points(POINTS, viewpoints=begins)
    cloud = decode(fields, data, step)
    np.testing.assert_array_equal(cloud.viewpoints, begins[[0, 2]])
    np.testing.assert_array_equal(cloud.points, POINTS[[0, 2]])
    assert decode().viewpoints is None
    with pytest.raises(CloudFormatError, match=r'viewpoints to encode: expected shape \(3, 3\)'):
        encode_points(POINTS, viewpoints=begins[:2])


@pytest.mark.parametrize('code', DATATYPES)
@pytest.mark.parametrize('order', ['<', '>'])
def test_every_datatype_in_both_byte_orders(code, order):
    dtype = np.dtype(order + DATATYPES[code])
    values = np.array([[1, 2, 3], [4, 5, 6]]).astype(dtype)
    fields = [PointField(name, k * dtype.itemsize, code) for k, name in enumerate('xyz')]
    cloud = decode(fields, values.tobytes(), 3 * dtype.itemsize, None, 2, 1, order == '>')
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])


def test_padding_within_points_and_rows_and_swapped_fields():
    """Two rows of two points: point step 20, row step 48, z first."""
    fields = [PointField('z', 4, 7), PointField('x', 8, 7), PointField('y', 16, 7)]
    raw = bytearray(b'\xff' * (2 * 48))
    expected = []
    for k in range(4):
        start = (k // 2) * 48 + (k % 2) * 20
        x, y, z = 1.0 + k, -2.0 * k, 0.5 * k
        expected.append([x, y, z])
        for offset, value in ((8, x), (16, y), (4, z)):
            raw[start + offset : start + offset + 4] = np.float32(value).tobytes()
    cloud = decode(fields, bytes(raw), 20, 48, 2, 2)
    np.testing.assert_array_equal(cloud.points, expected)


def test_nan_and_infinity_are_dropped_with_their_times():
    points = POINTS.copy()
    points[0, 2], points[2, 0] = np.nan, -np.inf
    fields, step, data = encode_points(points, time_s=np.array([0.0, 0.05, 0.1]))
    cloud = decode(fields, data, step)
    np.testing.assert_array_equal(cloud.points, POINTS[1:2])
    assert cloud.time_s.shape == (1,)


def test_zeros_are_no_returns_and_their_times_of_zero_do_not_stretch_the_sweep():
    stamps = 1.75e9 + np.array([0.0, 0.0, 0.05, 0.1])
    fields, step, data = encode_points(
        [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]], time_s=stamps
    )
    records = bytearray(data)
    records[step : 2 * step] = bytes(step)
    cloud = decode_points(fields, bytes(records), step, 4 * step, 4, 1, False)
    np.testing.assert_array_equal(cloud.points, np.diag([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(cloud.time_s, [0.0, 0.05, 0.1], atol=1e-6)
    assert cloud.first_s == 1.75e9


@pytest.mark.parametrize(('width', 'height'), [(0, 1), (0, 0), (5, 0)])
def test_no_points_are_empty_arrays(width, height):
    cloud = decode(data=b'', width=width, height=height, row=0)
    assert cloud.points.shape == (0, 3)
    assert cloud.time_s is None


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        ({'fields': XYZ[:2]}, 'lacks field z'),
        ({'fields': [*XYZ, XYZ[0]]}, 'twice'),
        (
            {'data': POINTS.tobytes()[:-1]},
            'truncated: 1 x 3 points of 12 bytes need 36 bytes, got 35',
        ),
        ({'step': 11}, 'does not fit in point_step 11'),
        ({'step': 0}, 'does not fit in point_step 0'),
        ({'row': 35}, 'row_step 35 is shorter'),
        ({'width': -1}, 'negative'),
        ({'width': 2**40, 'row': 0}, 'truncated'),
        ({'fields': [PointField('x', 0, 9), *XYZ[1:]]}, 'unknown datatype 9'),
        ({'fields': [PointField('x', -4, 7), *XYZ[1:]]}, 'offset -4'),
        ({'fields': [PointField('x', 0, 7, 3), *XYZ[1:]]}, 'count 3'),
        ({'data': [1, 2, 3]}, 'contiguous bytes'),
        ({'data': np.zeros(72, dtype=np.uint8)[::2]}, 'contiguous bytes'),
    ],
)
def test_malformed_clouds_are_named(arguments, message):
    with pytest.raises(CloudFormatError, match=message):
        decode(**arguments)


@pytest.mark.parametrize('name', ['t', 'time', 'timestamp', 'timestamps', 'time_stamp', 'stamps'])
def test_time_fields_by_any_name(name):
    fields, step, data = encode_points(POINTS, time_s=np.array([3.0, 3.04, 3.1]))
    renamed = [
        PointField(name if f.name == 'time' else f.name, f.offset, f.datatype) for f in fields
    ]
    np.testing.assert_allclose(decode(renamed, data, step).time_s, [0.0, 0.04, 0.1])


@pytest.mark.parametrize(
    'raw',
    [
        [0.0, 0.04, 0.1],  # relative seconds (Velodyne)
        [-0.1, -0.06, 0.0],  # counted back from the end
        [1.7e9, 1.7e9 + 0.04, 1.7e9 + 0.1],  # absolute seconds (Hesai)
        [0.0, 40.0, 100.0],  # milliseconds
        [0.0, 4.0e4, 1.0e5],  # microseconds
        [0.0, 4.0e7, 1.0e8],  # nanoseconds (Ouster)
        [1.7e18, 1.7e18 + 4.0e7, 1.7e18 + 1.0e8],  # absolute nanoseconds (Livox)
    ],
)
def test_units_of_time_are_told_by_the_length_of_a_sweep(raw):
    times = sweep_seconds(np.array(raw))
    np.testing.assert_allclose(times.since_first_s, [0.0, 0.04, 0.1], atol=1e-6)


@pytest.mark.parametrize('raw', [[0.0, np.nan], [0.0, 1e19]])
def test_unusable_times_are_none(raw):
    assert sweep_seconds(np.array(raw)) is None


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        ({'points': np.zeros((3, 2))}, r'\(P, 3\)'),
        ({'points': POINTS, 'ring': np.zeros(2)}, 'ring'),
    ],
)
def test_encode_rejects_wrong_shapes(arguments, message):
    with pytest.raises(CloudFormatError, match=message):
        encode_points(**arguments)
