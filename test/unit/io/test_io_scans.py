# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans of folders, with poses of files, and the bag in a recording's folder."""

import json
from types import SimpleNamespace as Message

import numpy as np
import pytest

from fpnet.recordings.opening import bag_within, open_scans
from fpnet.recordings.posed_scans import PosedScans
from fpnet.recordings.trajectories import Trajectory, read_poses, write_tum
from fpnet.recordings.truth import RESOLUTION_KEY, check_truth
from fpnet_core.errors import CloudFormatError, FpnetError, OdometryError
from fpnet_core.io.messages import transforms_of
from fpnet_core.io.scans import Scan

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


COUNT = 5
AHEAD = np.stack([np.arange(COUNT), np.zeros(COUNT)], axis=1)


@pytest.fixture
def scans(tmp_path):
    """Five raw scans a tenth of a second apart, from time 0."""
    folder = tmp_path / 'scans'
    folder.mkdir()
    for index in range(COUNT):
        np.save(folder / f'scan{index}.npy', np.full((4, 3), index, np.float32))
    source = open_scans(folder)
    assert not source.has_poses
    return source


def posed(scans, tmp_path, stamps_ns, xy=AHEAD):
    write_tum(tmp_path / 'drive_poses_tum.txt', stamps_ns, xy, np.zeros(len(stamps_ns)))
    return PosedScans(scans, read_poses(tmp_path / 'drive_poses_tum.txt'))


def x_of(source):
    return [float(scan.T_odom_sensor[0, 3]) for scan in source]


def test_one_pose_for_each_scan_goes_by_order(scans, tmp_path):
    """KISS-ICP numbers the scans of a folder: a second apart, whatever they were."""
    source = posed(scans, tmp_path, np.arange(COUNT) * 1_000_000_000)
    assert source.has_poses
    assert (source.kind, len(source)) == ('folder', COUNT)
    assert x_of(source) == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert [scan.stamp_ns for scan in source] == [scan.stamp_ns for scan in scans]


def test_other_counts_go_by_time(scans, tmp_path):
    stamps = np.array([110, 290, 420]) * 1_000_000
    source = posed(scans, tmp_path, stamps, AHEAD[:3])
    assert x_of(source) == [0.0, 1.0, 2.0]
    assert [scan.stamp_ns // 1_000_000 for scan in source] == [100, 300, 400]


def test_poses_in_any_order_and_ties_to_the_nearest(scans, tmp_path):
    stamps = np.array([320, 90, 300]) * 1_000_000
    assert x_of(posed(scans, tmp_path, stamps, AHEAD[:3])) == [1.0, 2.0]


def test_poses_of_another_recording_are_refused(scans, tmp_path):
    with pytest.raises(OdometryError, match='3 poses for 5 scans'):
        posed(scans, tmp_path, np.arange(3) + 10**15, AHEAD[:3])


class Wall:
    """A robot drives towards a wall at 2 m/s, and every sweep takes three quarters of a period."""

    kind = 'bag'
    has_poses = False
    ages_s = np.linspace(0.075, 0.0, 16)

    def __len__(self):
        return COUNT

    def __iter__(self):
        for stamp_ns, x in zip(self.stamps_ns, self.x, strict=True):
            seen_from = x - 2.0 * self.ages_s
            points = np.stack([5.0 - seen_from, *np.ones((2, 16))], axis=1).astype(np.float32)
            yield Scan(int(stamp_ns), points, time_s=self.ages_s[0] - self.ages_s)

    @property
    def stamps_ns(self):
        return np.arange(COUNT) * 100_000_000

    @property
    def x(self):
        return 2e-9 * self.stamps_ns

    def poses(self):
        poses = np.tile(np.eye(4), (COUNT, 1, 1))
        poses[:, 0, 3] = self.x
        return Trajectory(self.stamps_ns, poses)


def test_poses_undo_the_motion_during_a_sweep():
    """The first one has no pose before it, and stays bent by the 15 cm of its three quarters."""
    bent, *still = PosedScans(Wall(), Wall().poses())
    assert len(still) == COUNT - 1
    for scan in still:
        np.testing.assert_allclose(scan.points[:, 0] + scan.T_odom_sensor[0, 3], 5.0, atol=1e-5)
    assert np.isclose(np.ptp(bent.points[:, 0]), 0.15)


def test_the_bag_of_a_simulated_recording_is_found(tmp_path):
    bag = tmp_path / 'drive' / 'bag'
    bag.mkdir(parents=True)
    assert bag_within(tmp_path / 'drive') == bag
    (bag / 'metadata.yaml').write_text('')
    assert bag_within(bag) == bag
    (bag / 'bag').mkdir()
    assert bag_within(bag) == bag, 'a bag itself is not looked into'
    assert bag_within(tmp_path) == tmp_path
    assert bag_within(tmp_path / 'missing') == tmp_path / 'missing'


def test_truth_of_another_resolution_is_refused(tmp_path):
    truth = tmp_path / 'truth.tum'
    check_truth(truth, 0.05)
    (tmp_path / 'truth.json').write_text(json.dumps({RESOLUTION_KEY: 0.0317}))
    check_truth(truth, 0.0317)
    with pytest.raises(FpnetError, match=r'0\.0317 m per pixel, but it was read at 0\.05'):
        check_truth(truth, 0.05)
    check_truth(tmp_path / 'mine.tum', 0.05)
    (tmp_path / 'truth.json').write_text('{}')
    check_truth(truth, 0.05)


def said(parent, child, xyz, xyzw):
    header = Message(frame_id=parent, stamp=Message(sec=3, nanosec=5))
    place = Message(
        translation=Message(**dict(zip('xyz', xyz, strict=True))),
        rotation=Message(**dict(zip('xyzw', xyzw, strict=True))),
    )
    return Message(header=header, child_frame_id=child, transform=place)


# A third of a turn about x = y = z takes x to y: (1, 1, 1, 1) / 2, and twice as long here.
TURNED = said('/base', '/lidar', (1.0, -2.0, 0.5), (1.0, 1.0, 1.0, 1.0))
BROKEN = said('base', 'camera', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))


def test_what_is_asked_for_one_frame_does_not_fail_for_another():
    message = Message(transforms=[BROKEN, TURNED])
    assert [each.child for each in transforms_of(message, 'lidar')] == ['lidar']
    with pytest.raises(ValueError, match='quaternion is zero'):
        list(transforms_of(message))
