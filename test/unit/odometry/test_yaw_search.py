# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A lidar in the hand of a person who turns fast: with scans alone, and with a gyroscope."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.config import OdometryConfig
from fpnet_core.geometry.gyro_track import GyroTrack
from fpnet_core.odometry.kiss import KissOdometry
from fpnet_core.odometry.yaw_search import Guess, YawSearch
from fpnet_lab.sim.drives.driving import WALK
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.lidars.sensors import LidarModel

LIMITS = TourLimits(rooms=3, shortest_s=12.0, longest_s=30.0, motion=WALK)
BEAMS16 = LidarModel(beams=16, columns=360)
PLANAR = LidarModel(
    beams=1, columns=720, lowest_rad=0.0, highest_rad=0.0, max_range_m=25.0, angle_sigma_rad=0.0
)


@pytest.fixture(scope='module', params=[BEAMS16, PLANAR], ids=['beams16', 'planar'])
def walk(request):
    options = RecordingOptions(lidar=request.param, limits=LIMITS)
    recording = make_recording(41, options, threads=1)
    return recording, list(recording)


def off_after_a_second(poses, truth):
    """Return how far poses are off after ten sweeps ``(S,)`` [m], and turned [deg]."""
    by_poses, true = (np.linalg.inv(each[:-10]) @ each[10:] for each in (poses, truth))
    off = np.linalg.inv(true) @ by_poses
    turned = np.rad2deg(np.abs(np.arctan2(off[:, 1, 0], off[:, 0, 0])))
    return np.linalg.norm(off[:, :2, 3], axis=1), turned


def registered(scans):
    odometry = KissOdometry(OdometryConfig())
    return np.array([odometry.register_scan(scan).T_odom_sensor for scan in scans])


def test_a_walk_turns_as_people_with_a_lidar_do(walk):
    tour = walk[0].tour
    rates = np.rad2deg(np.abs(np.gradient(tour.yaw_rad, tour.time_s)))
    assert np.percentile(rates, 95) > 100.0
    assert 200.0 < rates.max() < 440.0


def test_scans_alone_follow_it(walk):
    recording, scans = walk
    metres, degrees = off_after_a_second(registered(scans), recording.truth())
    assert metres.max() < 0.5
    assert np.median(metres) < 0.06
    assert np.median(degrees) < 1.0


def with_gyro(recording, scans, factor=1.0):
    track = GyroTrack()
    for stamp_ns, rate in zip(*recording.gyro_rates(), strict=True):
        track.add(int(stamp_ns), factor * rate)
    return [replace(scan, R_gyro_sensor=track.at(scan.stamp_ns)) for scan in scans]


def test_a_gyroscope_that_has_proven_itself_leaves_less_off(walk, caplog):
    caplog.set_level('INFO')
    recording, scans = walk
    alone = off_after_a_second(registered(scans), recording.truth())
    by_gyro = off_after_a_second(registered(with_gyro(recording, scans)), recording.truth())
    assert by_gyro[0].max() < 0.25
    assert 'the rotation of the gyroscope fits the scans' in caplog.text
    later = slice(len(scans) // 2, None)
    assert np.median(by_gyro[1][later]) < 0.8 * np.median(alone[1][later])


@pytest.mark.parametrize('factor', [57.3, -1.0], ids=['degrees', 'mirrored'])
def test_walls_deny_a_gyroscope_that_is_wrong(walk, factor, caplog):
    recording, scans = walk
    poses = registered(with_gyro(recording, scans, factor))
    metres, degrees = off_after_a_second(poses, recording.truth())
    assert [each.message for each in caplog.records] == [
        'the rotation of the gyroscope does not fit the scans and is ignored until it does: are '
        'its rates in rad/s, and is its orientation on /tf_static right?'
    ], 'said once'
    assert metres.max() < 0.5
    assert np.median(degrees) < 1.5


def corner(count=400):
    """Return points ``(2 count, 3)`` on two walls that meet [m]."""
    along = np.linspace(-4.0, 4.0, count)
    walls = [np.full(count, 3.0), along], [along, np.full(count, -2.0)]
    return np.vstack([np.column_stack([x, y, np.zeros(count)]) for x, y in walls])


def test_without_walls_the_guess_stays():
    search = YawSearch()
    guess, by_gyro = (Guess.moved(np.eye(4), np.eye(4)) for _ in range(2))
    assert search.best(guess, by_gyro, corner(), np.zeros(0), 0.0) == (guess, False)
    search.note(corner() + np.array([100.0, 0.0, 0.0]))
    assert search.best(guess, by_gyro, corner(), np.zeros(0), 0.0) == (guess, False)
