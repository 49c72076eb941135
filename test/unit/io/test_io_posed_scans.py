# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans with the poses of a file that KISS-ICP wrote."""

import numpy as np
import pytest

from fpnet.recordings.opening import open_scans
from fpnet.recordings.posed_scans import PosedScans
from fpnet.recordings.trajectories import Trajectory, read_poses, write_tum
from fpnet_core.errors import OdometryError
from fpnet_core.io.scans import Scan

COUNT = 5
XY = np.stack([np.arange(COUNT), np.zeros(COUNT)], axis=1)


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


def posed(scans, tmp_path, stamps_ns, xy=XY):
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
    source = posed(scans, tmp_path, stamps, XY[:3])
    assert x_of(source) == [0.0, 1.0, 2.0]
    assert [scan.stamp_ns // 1_000_000 for scan in source] == [100, 300, 400]


def test_poses_in_any_order_and_ties_to_the_nearest(scans, tmp_path):
    stamps = np.array([320, 90, 300]) * 1_000_000
    assert x_of(posed(scans, tmp_path, stamps, XY[:3])) == [1.0, 2.0]


def test_poses_of_another_recording_are_refused(scans, tmp_path):
    with pytest.raises(OdometryError, match='3 poses for 5 scans'):
        posed(scans, tmp_path, np.arange(3) + 10**15, XY[:3])


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
