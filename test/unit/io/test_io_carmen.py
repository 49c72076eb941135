# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""CARMEN laser logs: geometry of the beams, clocks that fail, malformed lines."""

import gzip

import numpy as np
import pytest

from fpnet.recordings import carmen
from fpnet.recordings.opening import open_scans
from fpnet_core.errors import CloudFormatError

X, Y, YAW = 1.5, -2.25, 0.7


def flaser(ranges, time_s=1.0, pose=(X, Y, YAW)):
    values = ' '.join(map(str, ranges))
    x, y, yaw = pose
    return f'FLASER {len(ranges)} {values} {x} {y} {yaw} 9 9 9 {time_s} host {time_s}\n'


def write(path, text):
    data = text.encode()
    path.write_bytes(gzip.compress(data) if path.suffix == '.gz' else data)
    return path


@pytest.mark.parametrize('name', ['run.log', 'run.log.gz'])
def test_beams_and_pose(tmp_path, name):
    """181 readings: the first is to the right, the middle one ahead, the last to the left."""
    ranges = np.full(181, 80.0)
    ranges[[0, 90, 180]] = 2.0, 3.0, 4.0
    text = '# a comment\nODOM 0 0 0 0 0 0 0.1 host 0.1\n' + flaser(ranges, 12.5)
    [scan] = open_scans(write(tmp_path / name, text))
    np.testing.assert_allclose(scan.points, [[0, -2, 0], [3, 0, 0], [0, 4, 0]], atol=1e-6)
    assert scan.points.dtype == np.float32
    assert scan.stamp_ns == 12_500_000_000
    assert scan.time_s is None
    c, s = np.cos(YAW), np.sin(YAW)
    expected = [[c, -s, 0, X], [s, c, 0, Y], [0, 0, 1, 0], [0, 0, 0, 1]]
    np.testing.assert_allclose(scan.T_odom_sensor, expected)


@pytest.mark.parametrize(('count', 'step_deg'), [(180, 1.0), (181, 1.0), (360, 0.5), (361, 0.5)])
def test_angular_step_of_known_lasers(tmp_path, count, step_deg):
    [scan] = open_scans(write(tmp_path / 'a.log', flaser(np.ones(count))))
    angles = np.degrees(np.arctan2(scan.points[:, 1], scan.points[:, 0]))
    np.testing.assert_allclose(np.diff(angles), step_deg, atol=1e-3)
    assert angles[0] == pytest.approx(-90.0)


def test_robotlaser_has_its_own_angles(tmp_path):
    text = (
        'ROBOTLASER1 0 -1.0 2.0 0.5 30.0 0.01 0 5 1 2 3 4 5 2 9 9 '
        f'{X} {Y} {YAW} 0 0 0 0.1 0.2 0.3 0.4 0.5 7.25 host 0.5\n'
    )
    [scan] = open_scans(write(tmp_path / 'a.log', text))
    angles = np.arctan2(scan.points[:, 1], scan.points[:, 0])
    np.testing.assert_allclose(angles, [-1.0, -0.5, 0.0, 0.5, 1.0], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(scan.points, axis=1), [1, 2, 3, 4, 5], rtol=1e-6)
    assert scan.stamp_ns == 7_250_000_000
    np.testing.assert_allclose(scan.T_odom_sensor[:2, 3], [X, Y])


def test_readings_without_echo_are_left_out(tmp_path):
    ranges = [1.0, 0.0, 81.91, 51.15, float('nan'), float('inf'), -1.0, 32.77]
    [scan] = open_scans(write(tmp_path / 'a.log', flaser(ranges)))
    assert len(scan.points) == 1


def test_stamps_always_increase(tmp_path):
    text = ''.join(flaser([1.0, 1.0], t) for t in (1.0, 2.0, 1.9, 3.0))
    stamps = [scan.stamp_ns for scan in open_scans(write(tmp_path / 'a.log', text))]
    assert stamps == [1_000_000_000, 2_000_000_000, 2_001_000_000, 3_000_000_000]


def test_clock_that_stands_still_is_replaced(tmp_path):
    text = flaser([1.0, 1.0], 1.01893e9) * 3
    stamps = [scan.stamp_ns for scan in open_scans(write(tmp_path / 'a.log', text))]
    assert stamps == [0, 1_000_000_000, 2_000_000_000]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('', 'no laser scans'),
        ('hello\n', 'no laser scans'),
        ('FLASER\n', 'line 1: malformed FLASER'),
        ('\nFLASER 3 1 2\n', 'line 2: malformed'),
        ('FLASER 99999999999 1 2\n', 'malformed'),
        (flaser(['one', 'two']), 'malformed'),
        (flaser([1.0, 2.0], pose=('nan', 0, 0)), 'malformed'),
        ('ROBOTLASER1 0 0 0 0\n', 'malformed ROBOTLASER1'),
    ],
)
def test_malformed_logs_are_named(tmp_path, text, message):
    with pytest.raises(CloudFormatError, match=message):
        open_scans(write(tmp_path / 'a.log', text))


@pytest.mark.parametrize(
    'data', [b'no gzip', gzip.compress(b'x' * 1000)[:-9]], ids=['no archive', 'truncated']
)
def test_broken_archives_are_named(tmp_path, data):
    (tmp_path / 'a.log.gz').write_bytes(data)
    with pytest.raises(CloudFormatError, match='cannot read laser log'):
        open_scans(tmp_path / 'a.log.gz')


def test_logs_that_unpack_to_more_than_the_limit_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(carmen, 'MAX_LOG_BYTES', 10**5)
    monkeypatch.setattr(carmen, '_LONGEST_LINE', 10**3)
    (tmp_path / 'a.log.gz').write_bytes(gzip.compress(b'#' * 10**6))
    with pytest.raises(CloudFormatError, match='more than 100000 bytes'):
        open_scans(tmp_path / 'a.log.gz')
