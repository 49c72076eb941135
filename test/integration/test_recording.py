# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording on disk: what is written reads back, and real KISS-ICP tracks it."""

import json

import numpy as np
import pytest
from short_recording import start_of_recording

from fpnet.cli import main
from fpnet.recordings.opening import open_scans
from fpnet.recordings.trajectories import read_tum
from fpnet_core.config import OdometryConfig
from fpnet_core.io.bags import BagReader
from fpnet_core.io.maps import read_map
from fpnet_core.odometry import KissOdometry
from fpnet_lab.sim.drives.recording import (
    LASER_TOPIC,
    TRUTH_TOPIC,
    RecordingOptions,
    make_recording,
    write_recording,
)
from fpnet_lab.sim.lidars.sensors import SENSORS, LidarModel

SEED = 2
COARSE = RecordingOptions(lidar=LidarModel(beams=16, columns=90))


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp('recording')
    seen = []
    recording = make_recording(SEED, COARSE)
    write_recording(recording, folder, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(i + 1, len(recording)) for i in range(len(recording))]
    return folder, recording


def test_bag_holds_the_scans_and_the_truth(written):
    folder, recording = written
    source = open_scans(folder / 'bag', truth_topic=TRUTH_TOPIC)
    assert len(source) == len(recording)
    assert not source.has_poses
    for index, (scan, expected) in enumerate(zip(source, recording, strict=True)):
        assert scan.stamp_ns == expected.stamp_ns
        assert np.allclose(scan.T_truth_sensor, expected.T_truth_sensor, atol=1e-9)
        if index % 100 == 0:
            assert scan.points.tobytes() == expected.points.tobytes()
            relative = expected.time_s - expected.time_s[0]
            assert scan.time_s == pytest.approx(relative, abs=1e-7)


def test_floorplan_and_truth_files_agree_with_the_recording(written):
    folder, recording = written
    grid = read_map(folder / 'floorplan.yaml')
    assert np.array_equal(grid.cells, recording.floorplan.cells)
    assert np.allclose(grid.T_frame_grid.matrix, recording.floorplan.T_frame_grid.matrix)
    trajectory = read_tum(folder / 'truth.tum')
    assert np.array_equal(trajectory.stamps_ns, recording.stamps_ns)
    assert np.allclose(trajectory.xy, recording.truth()[:, :2, 3], atol=1e-5)
    truth = json.loads((folder / 'truth.json').read_text())
    assert np.array_equal(truth['A_plan_building'], recording.A_plan_building.matrix[:2])
    assert truth['seed'] == SEED
    assert truth['tour_rooms'] == list(recording.tour.rooms)


@pytest.mark.parametrize('name', sorted(SENSORS))
def test_every_sensor_is_recorded_read_and_registered(name, tmp_path):
    recording = start_of_recording(2.5, SENSORS[name])
    storage = 'mcap' if name in ('dome', 'planar') else 'sqlite3'
    write_recording(recording, tmp_path, storage=storage, with_wheels=name == 'rosette')
    source = open_scans(tmp_path / 'bag', truth_topic=TRUTH_TOPIC)
    assert len(source) == len(recording) == len(read_tum(tmp_path / 'truth.tum').stamps_ns)
    assert source.has_poses == (name == 'rosette')
    odometry = KissOdometry(OdometryConfig())
    first = None
    for scan in source:
        first = scan.T_truth_sensor if first is None else first
        pose = scan.T_odom_sensor
        if pose is None:
            pose = odometry.register_scan(scan).T_odom_sensor
    error = np.linalg.inv(first @ pose) @ scan.T_truth_sensor
    assert np.linalg.norm(error[:2, 3]) < 0.3


def test_laser_scans_read_back_as_the_cloud_that_the_planar_sensor_saw(tmp_path):
    recording = start_of_recording(1.0, SENSORS['planar'])
    write_recording(recording, tmp_path, laser_scans=True)
    with BagReader(tmp_path / 'bag') as bag:
        assert set(bag.topics) == {LASER_TOPIC, TRUTH_TOPIC}
        (_, first_ns, message), *_ = bag.messages([LASER_TOPIC])
    seen = recording.scan(0)
    assert first_ns == seen.stamp_ns - 100_000_000
    assert len(message.ranges) == 1080
    assert np.isinf(message.ranges).sum() == 1080 - len(seen.points)
    for scan, expected in zip(open_scans(tmp_path / 'bag'), recording, strict=True):
        np.testing.assert_allclose(scan.points, expected.points, atol=2e-4)
        times = expected.time_s - expected.time_s[0]
        np.testing.assert_allclose(scan.time_s, times, atol=1e-6)
        last_s = expected.time_s[-1] - 0.1
        assert scan.stamp_ns - expected.stamp_ns == pytest.approx(last_s * 1e9, abs=1000)
    assert json.loads((tmp_path / 'truth.json').read_text())['scan_topic'] == LASER_TOPIC


@pytest.mark.parametrize('odometry', ['kiss', 'robot', 'both'])
def test_planar_recording_runs_through_localize(tmp_path, capsys, odometry):
    recording = start_of_recording(9.0, SENSORS['planar'])
    write_recording(recording, tmp_path / 'drive', with_wheels=odometry != 'kiss')
    words = ['localize', str(tmp_path / 'drive' / 'bag'), '--odometry', odometry]
    words += ['--floorplan', str(tmp_path / 'drive' / 'floorplan.yaml')]
    with pytest.raises(SystemExit) as end:
        main([*words, '--json', str(tmp_path / 'run.json')])
    report = json.loads((tmp_path / 'run.json').read_text())
    is_localized = report['status'] == 'localized'
    assert end.value.code == (0 if is_localized else 3), capsys.readouterr().err
    assert report['rejected_scans'] == 0
    assert report['path_m'] > 1.0


@pytest.mark.parametrize('odometry', ['robot', 'both'])
def test_odometry_that_the_recording_lacks_ends_in_one_line(tmp_path, capsys, odometry):
    write_recording(start_of_recording(1.0, SENSORS['planar']), tmp_path / 'drive')
    words = ['localize', str(tmp_path / 'drive' / 'bag'), '--odometry', odometry]
    with pytest.raises(SystemExit) as end:
        main([*words, '--floorplan', str(tmp_path / 'drive' / 'floorplan.yaml')])
    assert end.value.code == 1
    assert 'has no odometry' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['--sensor', 'sonar'], 'choose one of beams16'),
        (['--laser-scan'], 'only a planar sensor reports LaserScans'),
        (['--building', 'igloo'], 'choose one of plain'),
        (['--mesh', 'none.ply'], 'does not exist'),
        (['--floorplan', 'none.png'], 'does not exist'),
        (['--floorplan', 'none.png', '--family', 'bent'], 'omit'),
    ],
)
def test_impossible_requests_end_in_one_line(words, message, capsys, tmp_path):
    with pytest.raises(SystemExit) as end:
        main(['simulate', 'recording', '--out', str(tmp_path / 'out'), *words])
    assert end.value.code == 1
    err = capsys.readouterr().err
    assert message in err
    assert len(err.strip().splitlines()) == 1
    assert not (tmp_path / 'out').exists()


def test_command_writes_a_recording(tmp_path, capsys):
    out = tmp_path / 'recording'
    words = ['simulate', 'recording', '--out', str(out), '--seed', '3', '--storage', 'mcap']
    words += ['--family', 'bent', '--sensor', 'planar', '--json', str(tmp_path / 'summary.json')]
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 0
    assert 'bent' in capsys.readouterr().out
    assert list((out / 'bag').glob('*.mcap'))
    assert json.loads((tmp_path / 'summary.json').read_text())['family'] == 'bent'
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 1
    assert 'exists' in capsys.readouterr().err
