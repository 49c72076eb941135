# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Point files of every layout, written here byte by byte."""

import struct

import numpy as np
import pytest

from fpnet_core.errors import CloudFormatError
from fpnet_core.io.clouds import read_cloud

POINTS = np.array([[1.5, -2.25, 0.125], [10.0, 20.0, -30.0], [-7.0, 0.5, 3.0]])


def ply(fmt, extra=()):
    """Three vertices with a colour before and extra lines after, then a face to pass over."""
    header = [
        'ply', f'format {fmt} 1.0', 'comment made here', 'element vertex 3', 'property uchar red',
        'property float x', 'property float y', 'property double z', *extra,
        'element face 1', 'property list uchar int vertex_indices', 'end_header\n',
    ]  # fmt: skip
    head = '\n'.join(header).encode()
    if fmt == 'ascii':
        rows = ''.join(f'255 {x} {y} {z}\n' for x, y, z in POINTS)
        return head + rows.encode() + b'3 0 1 2\n'
    order = '<' if 'little' in fmt else '>'
    dtype = np.dtype([('r', 'u1'), ('x', order + 'f4'), ('y', order + 'f4'), ('z', order + 'f8')])
    records = np.zeros(3, dtype)
    for name, column in zip('xyz', POINTS.T, strict=True):
        records[name] = column
    return head + records.tobytes() + b'\x03'


def pcd(encoding):
    header = (
        '# .PCD v0.7\nVERSION 0.7\nFIELDS x y z _ intensity\nSIZE 4 4 4 1 4\nTYPE F F F U F\n'
        'COUNT 1 1 1 4 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\n'
        f'DATA {encoding}\n'
    ).encode()
    if encoding == 'ascii':
        return header + ''.join(f'{x} {y} {z} 0 0 0 0 9\n' for x, y, z in POINTS).encode()
    dtype = np.dtype([('xyz', '<f4', 3), ('pad', 'u1', 4), ('i', '<f4')])
    records = np.zeros(3, dtype)
    records['xyz'] = POINTS
    return header + records.tobytes()


FILES = {
    'ascii.ply': ply('ascii'),
    'little.ply': ply('binary_little_endian'),
    'big.ply': ply('binary_big_endian'),
    'ascii.pcd': pcd('ascii'),
    'binary.pcd': pcd('binary'),
    'plain.xyz': b'# x y z\n' + b''.join(b'%g %g %g 7\n' % tuple(p) for p in POINTS),
}


@pytest.mark.parametrize('name', FILES)
def test_every_layout_gives_the_same_points(tmp_path, name):
    (tmp_path / name).write_bytes(FILES[name])
    points = read_cloud(tmp_path / name)
    np.testing.assert_array_equal(points, POINTS)
    assert points.dtype == np.float64


def test_npy_with_more_columns(tmp_path):
    np.save(tmp_path / 'a.npy', np.column_stack([POINTS, np.ones(3)]).astype(np.float32))
    np.testing.assert_array_equal(read_cloud(tmp_path / 'a.npy'), POINTS)


def test_compressed_pcd(tmp_path):
    o3d = pytest.importorskip('open3d')
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(POINTS))
    o3d.io.write_point_cloud(str(tmp_path / 'a.pcd'), cloud, compressed=True)
    np.testing.assert_allclose(read_cloud(tmp_path / 'a.pcd'), POINTS, atol=1e-6)


def test_compressed_pcd_that_promises_too_much_is_refused(tmp_path):
    o3d = pytest.importorskip('open3d')
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(POINTS))
    o3d.io.write_point_cloud(str(tmp_path / 'a.pcd'), cloud, compressed=True)
    good = (tmp_path / 'a.pcd').read_bytes()
    huge = good.replace(b'WIDTH 3', b'WIDTH 4000000000').replace(b'POINTS 3', b'POINTS 4000000000')
    body = good.index(b'binary_compressed') + len(b'binary_compressed\n')
    bomb = good[:body] + b'\xff' * 8 + good[body + 8 :]
    for content in (huge, bomb, good[: body + 4], good[:-3]):
        (tmp_path / 'a.pcd').write_bytes(content)
        with pytest.raises(CloudFormatError, match='the header describes'):
            read_cloud(tmp_path / 'a.pcd')


def test_points_that_are_not_finite_are_dropped(tmp_path):
    points = np.vstack([POINTS, [[np.nan, 0, 0], [0, np.inf, 0]]])
    np.save(tmp_path / 'a.npy', points)
    np.testing.assert_array_equal(read_cloud(tmp_path / 'a.npy'), POINTS)


@pytest.mark.parametrize(
    ('name', 'data', 'message'),
    [
        ('a.ply', ply('binary_little_endian')[:-30], 'truncated'),
        ('a.ply', b'solid', 'header|begin'),
        ('a.ply', ply('binary_middle_endian'), 'no known format'),
        ('a.ply', ply('ascii', ['property list uchar int neighbours']), 'list properties'),
        ('a.ply', ply('ascii').replace(b' x\n', b' a\n'), 'expected fields x, y and z'),
        ('a.ply', ply('ascii').replace(b'vertex 3', b'vertex -3'), 'damaged'),
        ('a.ply', ply('binary_big_endian').replace(b'vertex 3', b'vertex 3000000'), 'truncated'),
        ('a.pcd', pcd('binary').replace(b'POINTS 3', b'POINTS 4'), 'truncated'),
        ('a.pcd', pcd('binary').replace(b'SIZE 4 ', b'SIZE '), 'different lengths'),
        ('a.pcd', pcd('binary').replace(b'DATA binary', b'COUNT 0 1 1 4 1\nDATA binary'), 'least'),
        ('a.pcd', pcd('binary').replace(b'DATA binary', b'DATA zipped'), 'unknown PCD encoding'),
        ('a.pcd', b'FIELDS x y z\n', 'no DATA line'),
        ('a.npy', b'\x93NUMPY junk', 'damaged'),
        ('a.xyz', b'1 2\n', 'damaged'),
        ('a.xyz', b'one two three\n', 'damaged'),
        ('a.stl', b'', 'unknown point file'),
        ('a.ply', b'', 'header'),
    ],
)  # fmt: skip
def test_damaged_files_are_named(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(CloudFormatError, match=message):
        read_cloud(tmp_path / name)


def test_missing_and_empty(tmp_path):
    with pytest.raises(CloudFormatError, match='No such file'):
        read_cloud(tmp_path / 'a.ply')
    np.save(tmp_path / 'a.npy', np.zeros((0, 3)))
    with pytest.raises(CloudFormatError, match='no finite point'):
        read_cloud(tmp_path / 'a.npy')


@pytest.mark.parametrize(
    ('suffix', 'row'), [('.pts', '{} {} {} 7 255 0 0'), ('.xyzn', '{} {} {} 0 0 1')]
)
def test_rarer_text_formats_come_through_open3d(tmp_path, suffix, row):
    lines = [row.format(*point) for point in POINTS.tolist()]
    if suffix == '.pts':
        lines.insert(0, '3')
    path = tmp_path / f'cloud{suffix}'
    path.write_text('\n'.join(lines) + '\n')
    np.testing.assert_allclose(read_cloud(path), POINTS)
    path.write_text('no points here\n')
    with pytest.raises(CloudFormatError, match=r'no finite point|damaged'):
        read_cloud(path)
    with pytest.raises(CloudFormatError, match='No such file'):
        read_cloud(tmp_path / f'absent{suffix}')


def test_all_scans_of_an_e57_file(tmp_path):
    pye57 = pytest.importorskip('pye57')
    path = tmp_path / 'cloud.e57'
    file = pye57.E57(str(path), mode='w')
    columns = {f'cartesian{axis}': POINTS[:, k].copy() for k, axis in enumerate('XYZ')}
    turned = np.array([np.cos(0.25), 0.0, 0.0, np.sin(0.25)])  # 0.5 rad about z
    file.write_scan_raw(columns)
    file.write_scan_raw(columns, rotation=turned, translation=np.array([1.0, 2.0, 3.0]))
    file.close()
    points = read_cloud(path)
    c, s = np.cos(0.5), np.sin(0.5)
    expected = POINTS @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + (1.0, 2.0, 3.0)
    np.testing.assert_allclose(points, np.concatenate([POINTS, expected]), atol=1e-9)
    (tmp_path / 'bad.e57').write_bytes(path.read_bytes()[:100])
    with pytest.raises(CloudFormatError, match='damaged'):
        read_cloud(tmp_path / 'bad.e57')


def test_e57_without_its_package_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'pye57', None)
    with pytest.raises(CloudFormatError, match='pip install pye57'):
        read_cloud(tmp_path / 'cloud.e57')


SCALE, OFFSET = np.array([0.001, 0.001, 0.0005]), np.array([500_000.0, 5_400_000.0, 250.0])
"""Coordinates of a survey: far from zero, in millimetres."""


def las(minor=2, record=20, packed=False, count=3):
    """Return a LAS file with a record of its own before the points, as software writes."""
    size, start = (375, 429) if minor == 4 else (227, 281)
    header = bytearray(start)
    header[:4], header[24:26] = b'LASF', bytes([1, minor])
    legacy = 0 if minor == 4 else count
    header[94:111] = struct.pack('<HIIBHI', size, start, 1, 0x80 if packed else 0, record, legacy)
    header[131:179] = struct.pack('<6d', *SCALE, *OFFSET)
    if minor == 4:
        header[247:255] = struct.pack('<Q', count)
    rows = np.rint(POINTS / SCALE).astype('<i4')
    return bytes(header) + b''.join(row.tobytes() + bytes(record - 12) for row in rows)


@pytest.mark.parametrize(('minor', 'record'), [(0, 20), (2, 28), (4, 34)])
def test_las_of_every_version(tmp_path, minor, record):
    (tmp_path / 'a.las').write_bytes(las(minor, record))
    points = read_cloud(tmp_path / 'a.las')
    np.testing.assert_allclose(points - OFFSET, POINTS, atol=1e-6)


@pytest.mark.parametrize(
    ('data', 'message'),
    [
        (las()[:200], 'LAS header'),
        (b'LASX' + las()[4:], 'LAS header'),
        (las()[:-1], 'truncated'),
        (las(count=2**31), 'truncated'),
        (las(minor=4, count=2**60), 'truncated'),
        (las(record=20).replace(struct.pack('<BH', 0, 20), struct.pack('<BH', 0, 8)), '8 bytes'),
    ],
)
def test_damaged_las_is_named(tmp_path, data, message):
    (tmp_path / 'a.las').write_bytes(data)
    with pytest.raises(CloudFormatError, match=message):
        read_cloud(tmp_path / 'a.las')


def test_laz_is_unpacked(tmp_path):
    laspy = pytest.importorskip('laspy')
    header = laspy.LasHeader(point_format=6, version='1.4')
    header.scales, header.offsets = SCALE, OFFSET
    file = laspy.LasData(header)
    file.xyz = POINTS + OFFSET
    file.write(tmp_path / 'a.laz')
    np.testing.assert_allclose(read_cloud(tmp_path / 'a.laz') - OFFSET, POINTS, atol=1e-6)
    (tmp_path / 'b.laz').write_bytes((tmp_path / 'a.laz').read_bytes()[:-20])
    with pytest.raises(CloudFormatError, match='damaged'):
        read_cloud(tmp_path / 'b.laz')


def test_laz_without_its_package_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'laspy', None)
    (tmp_path / 'a.laz').write_bytes(las(packed=True))
    with pytest.raises(CloudFormatError, match=r'pip install .laspy\[lazrs\]'):
        read_cloud(tmp_path / 'a.laz')
