# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Folders of point files with a pose file beside them."""

import numpy as np
import pytest

from fpnet_core.errors import CloudFormatError, OdometryError
from fpnet_core.io.recordings import open_scans
from fpnet_core.io.trajectories import write_tum

RNG = np.random.default_rng(2)
CLOUDS = [RNG.normal(size=(20, 3)).astype(np.float32) for _ in range(12)]
STAMPS = 5_000_000_000 + 100_000_000 * np.arange(12)
XY = RNG.normal(size=(12, 2))
YAW = np.linspace(-1.0, 1.2, 12)


@pytest.fixture
def folder(tmp_path):
    """Twelve scans, so that scan10 must not come before scan2, and a readme."""
    for index, cloud in enumerate(CLOUDS):
        np.save(tmp_path / f'scan{index}.npy', cloud)
    (tmp_path / 'README.txt').write_text('Some scans, 12 of them.\n')
    write_tum(tmp_path / 'poses.tum', STAMPS, XY, YAW)
    return tmp_path


def test_scans_in_the_order_of_their_numbers(folder):
    source = open_scans(folder)
    scans = list(source)
    assert (source.kind, len(source), source.has_poses) == ('folder', 12, True)
    assert [scan.stamp_ns for scan in scans] == STAMPS.tolist()
    for scan, cloud, xy, yaw in zip(scans, CLOUDS, XY, YAW, strict=True):
        np.testing.assert_array_equal(scan.points, cloud)
        np.testing.assert_allclose(scan.T_odom_sensor[:2, 3], xy, atol=1e-6)
        assert np.arctan2(*scan.T_odom_sensor[1::-1, 0]) == pytest.approx(yaw)


def test_a_digit_that_is_no_number_is_a_letter(folder):
    (folder / 'scan3.npy').rename(folder / 'scan3\N{SUPERSCRIPT TWO}3.npy')
    assert len(list(open_scans(folder))) == 12


def test_archive_of_half_precision_scans(folder):
    for file in folder.glob('*.npy'):
        file.unlink()
    arrays = {f's{k}': cloud.astype(np.float16) for k, cloud in enumerate(CLOUDS)}
    np.savez(folder / 'scans.npz', **arrays)
    scans = list(open_scans(folder))
    np.testing.assert_allclose(scans[10].points, CLOUDS[10], atol=2e-3)


def test_without_a_pose_file_the_scans_are_raw(folder):
    (folder / 'poses.tum').unlink()
    source = open_scans(folder)
    assert not source.has_poses
    scans = list(source)
    assert scans[3].T_odom_sensor is None
    assert scans[3].stamp_ns == 300_000_000


def test_unordered_stamps_are_sorted(folder):
    write_tum(folder / 'poses.tum', STAMPS[::-1], XY, YAW)
    scans = list(open_scans(folder))
    assert [scan.stamp_ns for scan in scans] == STAMPS.tolist()
    np.testing.assert_array_equal(scans[0].points, CLOUDS[11])


def test_counts_must_agree(folder):
    write_tum(folder / 'poses.tum', STAMPS[:-1], XY[:-1], YAW[:-1])
    with pytest.raises(OdometryError, match='12 scans but 11 poses'):
        open_scans(folder)


def test_a_broken_pose_file_is_not_passed_over(folder):
    (folder / 'poses.tum').write_text('1 2 3\n')
    with pytest.raises(OdometryError, match=r'poses\.tum'):
        open_scans(folder)


def test_two_pose_files_are_ambiguous(folder):
    write_tum(folder / 'other.tum', STAMPS, XY, YAW)
    with pytest.raises(OdometryError, match=r'other\.tum, poses\.tum'):
        open_scans(folder)


@pytest.mark.parametrize('name', ['scan3.npy', 'all.npz'])
def test_damaged_scans_are_named(folder, name):
    if name == 'all.npz':
        for file in folder.glob('*.npy'):
            file.unlink()
    (folder / name).write_bytes(b'PK junk')
    with pytest.raises(CloudFormatError, match=name):
        list(open_scans(folder))


def test_other_inputs_are_refused_with_the_choices(tmp_path):
    with pytest.raises(CloudFormatError, match='has no scans'):
        open_scans(tmp_path)
    (tmp_path / 'a.txt').write_text('')
    with pytest.raises(CloudFormatError, match=r'bag .* CARMEN log .* folder'):
        open_scans(tmp_path / 'a.txt')
    with pytest.raises(CloudFormatError, match='topics can only be chosen in a bag'):
        open_scans(tmp_path / 'a.txt', topics=['/points'])
