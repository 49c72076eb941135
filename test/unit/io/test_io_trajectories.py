# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pose files: layouts told by their columns, times to the nanosecond."""

import numpy as np
import pytest

from fpnet.recordings.trajectories import read_poses, read_tum, write_tum
from fpnet_core.errors import OdometryError

STAMPS = np.array([1_630_577_758_569_490_123, 1_630_577_759_000_000_007])
XY = np.array([[1.25, -7.5], [2.5, 3.75]])
YAW = np.array([0.7, -2.9])


def test_tum_round_trip_keeps_nanoseconds(tmp_path):
    path = tmp_path / 'new' / 'run.tum'
    write_tum(path, STAMPS, XY, YAW, z=1.5)
    back = read_tum(path)
    np.testing.assert_array_equal(back.stamps_ns, STAMPS)
    np.testing.assert_allclose(back.xy, XY)
    np.testing.assert_allclose(back.yaw, YAW)
    np.testing.assert_allclose(back.T_frame_body[:, 2, 3], 1.5)
    assert len(back) == 2


def test_tum_lines_are_what_other_tools_read(tmp_path):
    write_tum(tmp_path / 'a.tum', [1_500_000_000], [[1.0, 2.0]], [np.pi / 2])
    assert (tmp_path / 'a.tum').read_text() == (
        '1.500000000 1.000000 2.000000 0.000000 0 0 0.707106781 0.707106781\n'
    )


def test_layouts_are_told_by_columns(tmp_path):
    c, s = np.cos(0.3), np.sin(0.3)
    tum = f'# t x y z q\n5.25 1 2 3 0 0 {np.sin(0.15)} {np.cos(0.15)}\n'
    kitti = f'{c} {-s} 0 1 {s} {c} 0 2 0 0 1 3\n'
    balm = f'{c},{-s},0,1,\n{s},{c},0,2,\n0,0,1,3,\n0,0,0,5.25,\n'
    expected = [[c, -s, 0, 1], [s, c, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    for text, stamp_ns in ((tum, 5_250_000_000), (kitti, 0), (balm, 5_250_000_000)):
        (tmp_path / 'poses.txt').write_text(text)
        poses = read_poses(tmp_path / 'poses.txt')
        np.testing.assert_allclose(poses.T_frame_body[0], expected, atol=1e-12)
        assert poses.stamps_ns.tolist() == [stamp_ns]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('', 'no pose'),
        ('# nothing\n', 'no pose'),
        ('1 2 3\n', 'got 3'),
        ('1 0 0 0 0 0 0 1\n2 0 0 0\n', 'pose line 2 has 4 values, expected 8'),
        ('1 0 0 0 0 0 0 0\n', 'zero'),
        ('1 0 0 nan 0 0 0 1\n', 'NaN'),
        ('soon 0 0 0 0 0 0 1\n', 'number|Conversion'),
        ('inf 0 0 0 0 0 0 1\n', 'finite'),
        ('1e30 0 0 0 0 0 0 1\n', 'large|long'),
        ('2 0 0 0 0 2 0 0 0 0 2 0\n', 'not a rigid'),
        ('1 0 0 0\n0 1 0 0\n0 0 1 0\n', 'blocks of four'),
    ],
)
def test_malformed_poses_are_named(tmp_path, text, message):
    (tmp_path / 'poses.txt').write_text(text)
    with pytest.raises(OdometryError, match=message):
        read_poses(tmp_path / 'poses.txt')


def test_tum_reader_takes_tum_only(tmp_path):
    (tmp_path / 'a.txt').write_text('1 0 0 1 0 1 0 2 0 0 1 3\n')
    with pytest.raises(OdometryError, match='expected TUM'):
        read_tum(tmp_path / 'a.txt')
    (tmp_path / 'b.txt').write_bytes(b'\xff\xfe\x00')
    with pytest.raises(OdometryError, match='not text'):
        read_tum(tmp_path / 'b.txt')
    with pytest.raises(OdometryError, match='No such file'):
        read_tum(tmp_path / 'c.txt')


def test_kiss_icp_arrays_have_no_time(tmp_path):
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, 3] = [[0, 0, 0], [1, 2, 3], [4, 5, 6]]
    np.save(tmp_path / 'drive_poses.npy', poses)
    back = read_poses(tmp_path / 'drive_poses.npy')
    np.testing.assert_array_equal(back.T_frame_body, poses)
    assert back.stamps_ns.tolist() == [0, 100_000_000, 200_000_000]


@pytest.mark.parametrize(
    ('array', 'message'),
    [
        (np.zeros((3, 12)), 'expected poses'),
        (np.zeros((0, 4, 4)), 'no pose'),
        (np.zeros((2, 4, 4)), 'pose 0 is not a rigid'),
    ],
)
def test_arrays_that_hold_no_poses_are_refused(tmp_path, array, message):
    np.save(tmp_path / 'a.npy', array)
    with pytest.raises(OdometryError, match=message):
        read_poses(tmp_path / 'a.npy')


def test_damaged_arrays_are_refused(tmp_path):
    (tmp_path / 'a.npy').write_bytes(b'not an array')
    with pytest.raises(OdometryError, match='not an array'):
        read_poses(tmp_path / 'a.npy')
