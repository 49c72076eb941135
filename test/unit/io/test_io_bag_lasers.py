# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bags of planar scanners: chosen, mounted, merged, deskewed, registered; and refused."""

from dataclasses import replace
import logging

from laser_robot import FRONT, REAR, base_at, distance_to_walls, place
import numpy as np
import pytest

from fpnet.bag_writer import BagWriter
from fpnet.recordings.opening import open_scans
from fpnet.recordings.posed_scans import PosedScans
from fpnet.recordings.trajectories import Trajectory
from fpnet_core.config import OdometryConfig
from fpnet_core.errors import BagFormatError, CloudFormatError, OdometryError
from fpnet_core.odometry import KissOdometry

SWEEPS = 20
TOPICS = {'/front/scan': FRONT, '/rear/scan': REAR}


@pytest.fixture(scope='module')
def record(tmp_path_factory):
    """Return a function that records a drive, once for each kind of it."""
    made = {}

    def recorded(scanners=None, *, mounted=True, wheels=False):
        scanners = TOPICS if scanners is None else scanners
        key = (*((t, s.T_base_laser.tobytes()) for t, s in scanners.items()), mounted, wheels)
        if key not in made:
            made[key] = tmp_path_factory.mktemp('drive') / 'bag'
            write(made[key], scanners, mounted, wheels)
        return made[key]

    return recorded


def write(path, scanners, mounted, wheels):
    rng = np.random.default_rng(3)
    with BagWriter(path) as bag:
        for scanner in scanners.values():
            if mounted:
                T = scanner.T_base_laser
                bag.write_transform('/tf_static', 0, 'base_link', scanner.frame, T)
        for index in range(SWEEPS):
            for topic, scanner in scanners.items():
                stamp_ns, readings = scanner.readings(index, rng)
                bag.write_laser_scan(topic, stamp_ns, scanner.frame, readings)
                bag.write_pose('/truth', stamp_ns, 'room', base_at(stamp_ns))
                for step in range(0, 100, 10) if wheels and scanner is FRONT else ():
                    at_ns = stamp_ns + step * 1_000_000
                    bag.write_odometry('/odom', at_ns, 'odom', 'base_link', base_at(at_ns))


def off_walls(scan, T_room_sensor):
    """Median distance of a scan's points to the walls that they are returns of [m]."""
    points = scan.points @ T_room_sensor[:3, :3].T + T_room_sensor[:3, 3]
    return float(np.median(distance_to_walls(points[:, :2])))


def test_front_and_rear_are_merged_in_the_base_with_times_and_viewpoints(record):
    source = open_scans(record(), truth_topic='/truth')
    scans = list(source)
    assert (source.kind, len(source), len(scans), source.has_poses) == ('bag', 20, 20, False)
    scan = scans[5]
    assert 650 < len(scan.points) <= 720
    assert not scan.points[:, 2].any()
    begins = np.unique(scan.viewpoints, axis=0)
    np.testing.assert_allclose(begins, [(-0.3, -0.15, 0.0), (0.35, 0.1, 0.0)], atol=1e-6)
    assert scan.time_s.min() == 0.0
    assert scan.time_s.max() == pytest.approx(0.105, abs=3e-3)  # 30 ms and three quarters of 100
    assert off_walls(scan, scan.T_truth_sensor) < 0.08  # smeared by the motion during the sweep


def test_kiss_icp_registers_the_merged_sweeps_and_undoes_the_motion(record):
    odometry = KissOdometry(OdometryConfig())
    smeared, sharp = [], []
    scans = list(open_scans(record()))
    for scan in scans:
        sweep = odometry.register_scan(scan)
        smeared.append(off_walls(scan, base_at(scan.stamp_ns)))
        sharp.append(off_walls(sweep, base_at(scan.stamp_ns)))
    moved = np.linalg.inv(base_at(scans[0].stamp_ns)) @ base_at(scan.stamp_ns)
    error = np.linalg.inv(sweep.T_odom_sensor) @ moved
    assert np.hypot(*error[:2, 3]) < 0.05
    assert abs(np.degrees(np.arctan2(error[1, 0], error[0, 0]))) < 1.0
    # Flat scans stay flat: the odometry never leaves the plane.
    np.testing.assert_array_equal(sweep.T_odom_sensor[2], [0.0, 0.0, 1.0, 0.0])
    assert np.mean(sharp[3:]) < 0.6 * np.mean(smeared[3:])
    begins = np.linalg.norm(sweep.viewpoints[:, :2], axis=1)
    assert ((begins > 0.2) & (begins < 0.5)).all()


def test_with_wheels_the_motion_during_the_sweep_is_theirs(record):
    source = open_scans(record(wheels=True))
    scans = list(source)
    assert source.has_poses
    assert len(scans) > 15
    for scan in scans:
        np.testing.assert_allclose(scan.T_odom_sensor, base_at(scan.stamp_ns), atol=2e-3)
        assert off_walls(scan, scan.T_odom_sensor) < 0.01
        assert scan.time_s is None


@pytest.mark.parametrize('is_planar', [False, True])
def test_odometry_whose_poses_are_too_far_apart_places_no_scan(tmp_path, is_planar):
    with BagWriter(tmp_path / 'bag') as bag:
        for index in range(SWEEPS):
            stamp_ns, readings = FRONT.readings(index, np.random.default_rng(0))
            if is_planar:
                bag.write_laser_scan('/scan', stamp_ns, 'base_link', readings)
            else:
                bag.write_cloud('/points', stamp_ns, 'base_link', np.ones((9, 3), np.float32))
            if index % 10 == 0:  # once a second
                bag.write_odometry('/odom', stamp_ns + 1, 'odom', 'base_link', np.eye(4))
    with pytest.raises(
        OdometryError, match=r'all 20 scans lie .* 0.5 s or half a turn.*--odometry kiss'
    ):
        list(open_scans(tmp_path / 'bag'))


def test_one_scanner_can_be_chosen(record):
    bag = record()
    scans = list(open_scans(bag, topics=['/rear/scan']))
    assert len(scans) == SWEEPS
    np.testing.assert_allclose(np.unique(scans[0].viewpoints, axis=0), [(-0.3, -0.15, 0.0)])
    assert off_walls(scans[0], base_at(scans[0].stamp_ns)) < 0.08  # upside down, and put right


def test_a_single_scanner_needs_no_transform(record, caplog):
    bag = record({'/scan': FRONT}, mounted=False)
    with caplog.at_level(logging.WARNING):
        scan = next(iter(open_scans(bag)))
    assert not caplog.text
    assert not scan.viewpoints.any()
    assert off_walls(scan, base_at(scan.stamp_ns) @ FRONT.T_base_laser) < 0.08


def test_clouds_come_before_planar_scans_unless_these_are_named(tmp_path, caplog):
    with BagWriter(tmp_path / 'bag') as bag:
        stamp_ns, readings = FRONT.readings(0, np.random.default_rng(0))
        bag.write_laser_scan('/scan', stamp_ns, 'laser', readings)
        bag.write_cloud('/points', stamp_ns, 'lidar', np.ones((5, 3)))
    with caplog.at_level(logging.WARNING):
        assert len(next(iter(open_scans(tmp_path / 'bag'))).points) == 5
    assert 'using the scans on /points; to use /scan instead' in caplog.text
    assert len(next(iter(open_scans(tmp_path / 'bag', topics=['/scan']))).points) > 300
    with pytest.raises(BagFormatError, match='cannot merge /scan, /points; name one PointCloud2'):
        open_scans(tmp_path / 'bag', topics=['/scan', '/points'])
    with pytest.raises(BagFormatError, match='/none is missing'):
        open_scans(tmp_path / 'bag', topics=['/none'])


def test_scanners_whose_place_is_unknown_are_named(record):
    bag = record(mounted=False)
    with pytest.raises(OdometryError, match=r"/rear/scan: the pose of 'rear_laser' in 'front_l"):
        open_scans(bag)


def test_two_topics_of_one_scanner_are_not_merged(record):
    bag = record({'/scan': FRONT, '/scan_filtered': FRONT})
    with pytest.raises(BagFormatError, match="and /scan_filtered are from the same scanner 'fro"):
        open_scans(bag)
    assert len(list(open_scans(bag, topics=['/scan_filtered']))) == SWEEPS


def test_a_tilted_scanner_is_refused_with_bag_and_message(record):
    tilted = replace(FRONT, T_base_laser=place(0.3, 0.0, 0.3, pitch=0.2))
    bag = record({'/scan': tilted})
    with pytest.raises(
        CloudFormatError, match=r"bag, /scan, message 0: laser 'front_laser' is ti"
    ):
        list(open_scans(bag))


@pytest.mark.parametrize('topics', [[], ['/scan']])
def test_given_poses_ask_for_no_mount_and_keep_viewpoints(record, topics):
    bag = record({'/scan': FRONT}, mounted=False, wheels=True)
    source = open_scans(bag, topics=topics, odometry_topic='')
    stamps_ns = np.array([scan.stamp_ns for scan in source])
    T_room_laser = np.array([base_at(stamp_ns) @ FRONT.T_base_laser for stamp_ns in stamps_ns])
    scans = list(PosedScans(source, Trajectory(stamps_ns, T_room_laser)))
    assert len(scans) == SWEEPS
    for scan in scans:
        assert off_walls(scan, scan.T_odom_sensor) < 0.08
        assert scan.viewpoints.shape == scan.points.shape


def test_each_robot_of_a_recording_has_its_own_static_transforms(tmp_path):
    """Frames of both have the same names, as TF is in their namespaces."""
    rng = np.random.default_rng(3)
    with BagWriter(tmp_path / 'bag') as bag:
        for robot, scanner in (('one', FRONT), ('two', REAR)):
            T = scanner.T_base_laser
            bag.write_transform(f'/{robot}/tf_static', 0, 'base_link', 'laser', T)
            stamp_ns, readings = scanner.readings(0, rng)
            bag.write_laser_scan(f'/{robot}/scan', stamp_ns, 'laser', readings)
    for robot, scanner in (('one', FRONT), ('two', REAR)):
        scan = next(iter(open_scans(tmp_path / 'bag', topics=[f'/{robot}/scan'])))
        assert np.allclose(scan.viewpoints[0, :2], scanner.T_base_laser[:2, 3])
