# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated recording, broken in each way that robots come: found, and nothing else."""

from dataclasses import replace
import json

import numpy as np
import pytest

from fpnet.bag_writer import BagWriter
from fpnet.cli import main
from fpnet.doctor.bag import observe_bag
from fpnet.doctor.examine import examine
from fpnet_core.doctor import Problem
from fpnet_lab.sim.drives.faulty_robots import RIGHT, ShortDrive, record, turned


@pytest.fixture(scope='module')
def drive():
    return ShortDrive.of(0)


@pytest.mark.parametrize(
    ('robot', 'problem', 'where', 'words'),
    [
        (RIGHT, None, '', []),
        (
            replace(RIGHT, scan_clock_s=-0.1),
            Problem.LAG, '/points', ['if its stamps are 0.10 s too early', 'scan_stamp:=start'],
        ),
        (replace(RIGHT, scan_clock_s=-0.1, last_time_s=0.1), None, '', []),
        (replace(RIGHT, scan_clock_s=0.14), Problem.LAG, '/points', ['0.14 s too late']),
        (
            replace(RIGHT, scans='/lidar/map_points', frame='laser_link'),
            Problem.FRAME, 'laser_link',
            ['odometry is of base_link', '--frame-id base_link --child-frame-id laser_link'],
        ),
        (
            replace(RIGHT, frame='lidar_', T_mount_lidar=None),
            Problem.FRAME, 'lidar_', ['did you mean lidar?'],
        ),
        (replace(RIGHT, frame=''), Problem.FRAME, '/points', ['has no frame_id']),
        (replace(RIGHT, child=''), Problem.FRAME, '/odom', ['child_frame_id']),
        (
            replace(RIGHT, more_transforms=(('odom', 'base_link'), ('odom_lidar', 'base_link'))),
            Problem.PARENTS, 'base_link', ['odom and odom_lidar', 'publish_odom_tf: false'],
        ),
        (
            replace(RIGHT, scans='/robot_1/front/points', tf='/robot_1/tf', told_height_m=1.5),
            Problem.HEIGHT, 'lidar', ['1.50 m above'],
        ),
        (
            replace(RIGHT, scans='/points', tf='/robot_1/tf'),
            Problem.FRAME, 'lidar', ['no transform on /tf_static connects them'],
        ),
        (
            replace(RIGHT, more_transforms=(('a', 'b'), ('b', 'c'), ('c', 'a'))),
            Problem.LOOP, 'a', ['a -> c -> b -> a'],
        ),
        (replace(RIGHT, is_static_latched=False), Problem.QOS, '/tf_static', ['volatile']),
        (
            replace(RIGHT, scan_clock_s=-1.6e9),
            Problem.OTHER_CLOCK, '/odom', ['1.6e+09 s ahead', 'one clock'],
        ),
        (replace(RIGHT, jump=(20, -3.03)), Problem.CLOCK_JUMP, '/points', ['goes back by 2.93 s']),
        (replace(RIGHT, jump=(20, 7.0)), Problem.CLOCK_JUMP, '/points', ['skips 7.00 s']),
        (
            replace(RIGHT, has_times=False),
            Problem.POINT_TIMES, '/points', ['no usable time field; its fields are x, y, z'],
        ),
        (
            replace(RIGHT, T_mount_lidar=turned('x', 180.0)),
            Problem.UPSIDE_DOWN, 'lidar', ['0.88 m above', '--roll 3.14159'],
        ),
        (
            replace(RIGHT, T_mount_lidar=turned('y', 15.0)),
            Problem.TILTED, 'lidar', ['after a rotation of 15 degrees', '--pitch'],
        ),
        (
            replace(RIGHT, T_mount_lidar=turned('zyx', (-90.0, 0.0, -90.0))),
            Problem.TILTED, 'lidar', ['degrees or more', '--roll -1.5708 --yaw -1.5708'],
        ),
        (
            replace(RIGHT, told_height_m=1.5),
            Problem.HEIGHT, 'lidar', ['0.87 m below it', '1.50 m above'],
        ),
        (
            replace(RIGHT, scans_per_pose=10),
            Problem.SPARSE, '/odom', ['a pose every 1.0 s', '--odometry kiss'],
        ),
        (replace(RIGHT, gyro_frame='imu'), None, '', []),
        (
            replace(RIGHT, gyro_frame='imu_link'),
            Problem.FRAME, 'imu_link', ['/imu/data is not used', 'static transform'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', gyro_factor=180.0 / np.pi),
            Problem.GYRO, '/imu/data', ['times the rotation of the scans: degrees', 'rad/s'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', gyro_factor=0.6),
            Problem.GYRO, '/imu/data', ['0.58 times', 'scale'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', gyro_offset_deg=5.0),
            Problem.GYRO, '/imu/data', ['5.1 degrees per second', 'stands still'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', T_imu_lidar=turned('x', 180.0)),
            Problem.GYRO, '/imu/data', ['-0.97 times', 'upside down'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', T_imu_lidar=turned('x', 90.0)),
            Problem.GYRO, '/imu/data', ['other axes', 'rotation'],
        ),
        (replace(RIGHT, wheel_scale=1.6), Problem.ODOMETRY, '/odom', ['odometry reports']),
        (
            replace(RIGHT, wheel_scale=1.4),
            Problem.ODOMETRY, '/odom', ['times the distance', 'wheel radius'],
        ),
        (
            replace(RIGHT, T_mount_lidar=turned('z', 20.0)),
            Problem.ODOMETRY, '/odom', ['20 degrees to one side', 'the static transform'],
        ),
        (
            replace(RIGHT, drift_deg_per_m=4.0),
            Problem.ODOMETRY, '/odom', ['degrees per metre'],
        ),
        (replace(RIGHT, flips=True), Problem.ODOMETRY, '/odom', ['impossibly fast', 'two nodes']),
        (
            replace(RIGHT, mirrored_turns=True),
            Problem.ODOMETRY, '/odom', ['opposite rotation', 'wrong sign', '--roll 3.14159'],
        ),
        (
            replace(RIGHT, T_mount_lidar=turned('z', 90.0)),
            Problem.ODOMETRY, '/odom', ['the yaw of the static transform'],
        ),
    ],
)  # fmt: skip
def test_each_fault_is_found_in_the_first_seconds_and_no_other(
    drive, tmp_path, robot, problem, where, words
):
    seen = observe_bag(record(tmp_path / 'bag', drive, robot), 10.0)
    assert seen.scans == robot.scans
    found = examine(seen)
    kinds = [finding.problem for finding in found]
    assert kinds == ([problem] if problem else []), [f.said for f in found]
    if problem:
        said = f'{found[0].said}; {found[0].next}'
        assert found[0].where == where
        assert all(word in said for word in words), said


def test_missing_and_wrong_topics_are_named_with_what_is_there(drive, tmp_path):
    path = record(tmp_path / 'bag', drive, RIGHT)
    for name, words in (
        ('/scan', ['nobody publishes it', 'available: /points', 'points:=/points']),
        ('/odom', ['is a nav_msgs/msg/Odometry', 'available: /points']),
    ):
        found = examine(observe_bag(path, 10.0, name))
        assert found[0].problem is Problem.TOPIC
        assert all(word in f'{found[0].said} {found[0].next}' for word in words), found[0].said
    found = examine(observe_bag(path, 10.0, odometry='/wheels'))
    assert [finding.problem for finding in found] == [Problem.TOPIC]
    assert 'available: /odom' in found[0].said
    empty = tmp_path / 'empty'
    with BagWriter(empty) as bag:
        bag.write_number('/battery', 1, 0.5)
    (finding,) = examine(observe_bag(empty, 10.0))
    assert finding.problem is Problem.TOPIC
    assert 'no topic has scans' in finding.said


def test_scans_that_cannot_be_read_are_told_once(drive, tmp_path, monkeypatch):
    write = BagWriter._write

    def _write(self, topic, msgtype, stamp_ns, message, *rest):
        if topic == '/points':
            message.point_step = 8
        write(self, topic, msgtype, stamp_ns, message, *rest)

    monkeypatch.setattr(BagWriter, '_write', _write)
    found = examine(observe_bag(record(tmp_path / 'bag', drive, RIGHT), 10.0))
    assert [finding.problem for finding in found] == [Problem.FORMAT]
    assert 'point_step' in found[0].said


def test_the_command_prints_what_to_do_and_exits_with_1(drive, tmp_path, capsys):
    good = record(tmp_path / 'good', drive, RIGHT)
    with pytest.raises(SystemExit) as ended:
        main(['doctor', str(good)])
    assert ended.value.code == 0
    assert 'nothing is wrong' in capsys.readouterr().out
    bad = record(tmp_path / 'bad', drive, replace(RIGHT, told_height_m=1.5))
    with pytest.raises(SystemExit) as ended:
        main(['doctor', str(bad), '--json', '-'])
    assert ended.value.code == 1
    out, err = capsys.readouterr()
    (finding,) = json.loads(out)['findings']
    assert finding['problem'] == 'sensor at the wrong height'
    assert f'next: {finding["next"]}' in err
