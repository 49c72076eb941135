# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated recording, broken in each way that robots come: found, and nothing else."""

from dataclasses import dataclass, replace
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fpnet.cli import main
from fpnet.doctor.bag import observe_bag
from fpnet.doctor.examine import examine
from fpnet_core.doctor import Problem
from fpnet_core.doctor.sensor import upside_down_vote
from fpnet_core.io import bag_writer
from fpnet_core.io.bag_writer import BagWriter
from fpnet_lab.sim.drives.recording import make_recording
from fpnet_lab.sim.drives.visits import RecordingOptions
from fpnet_lab.sim.lidars.sensors import SENSORS

FIRST, COUNT = 10, 60  # the robot drives from the start of these on
HEIGHT_M = 0.9
SECOND = 10**9
SWEEP_S = 0.1


@pytest.fixture(scope='module')
def drive():
    """Return scans, and true poses of the sensor by wheels."""
    recording = make_recording(0, RecordingOptions(lidar=SENSORS['beams16']))
    scans = [recording.scan(index) for index in range(FIRST, FIRST + COUNT)]
    return scans, recording.wheel_odometry()[FIRST : FIRST + COUNT]


def turned(axis: str, degrees: float | tuple[float, ...]) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler(axis, degrees, degrees=True).as_matrix()
    return T


@dataclass(frozen=True)
class Robot:
    """
    How a robot is wired; the defaults are right.

    ``T_mount_lidar`` is how the lidar is really mounted beside what its transform says.
    """

    scans: str = '/points'
    tf: str = '/tf'
    frame: str = 'lidar'
    child: str = 'base_link'
    mount_child: str = 'lidar'
    told_height_m: float = HEIGHT_M
    T_mount_lidar: np.ndarray | None = None
    has_times: bool = True
    last_time_s: float = 0.0  # of the last point, since the stamp
    scan_clock_s: float = 0.0
    jump: tuple[int, float] = (0, 0.0)  # scan, and by how much its clock and later ones' jump [s]
    wheel_scale: float = 1.0
    drift_deg_per_m: float = 0.0
    mirrored_turns: bool = False
    flips: bool = False  # every second message has the robot the other way round
    scans_per_pose: int = 1  # of the wheels
    more_transforms: tuple[tuple[str, str], ...] = ()
    is_static_latched: bool = True
    gyro_frame: str = ''  # '': no gyroscope
    gyro_factor: float = 1.0
    gyro_offset_deg: float = 0.0  # a second
    T_imu_lidar: np.ndarray | None = None  # as it is, beside what the transform says


RIGHT = Robot()


def test_scans_tell_a_lidar_that_hangs_upside_down(drive):
    scans, _ = drive
    over = [replace(scan, points=scan.points * np.float32([1, -1, -1])) for scan in scans]
    told = [replace(scan, T_base_sensor=turned('x', 180.0)) for scan in over]
    flat = [replace(scan, points=scan.points * np.float32([1, 1, 0])) for scan in scans]
    votes = [sum(map(upside_down_vote, each)) for each in (scans, told, flat, over)]
    assert votes[0] == votes[1] < -len(scans) // 2
    assert votes[2] == 0
    assert votes[3] > len(scans) // 2


def record(path: Path, drive, robot: Robot) -> Path:
    T_base_lidar = np.eye(4)
    T_base_lidar[2, 3] = HEIGHT_M
    told = T_base_lidar.copy()
    told[2, 3] = robot.told_height_m
    off = np.eye(4) if robot.T_mount_lidar is None else robot.T_mount_lidar
    scans, wheels = drive
    start_ns = scans[0].stamp_ns
    with pytest.MonkeyPatch.context() as monkeypatch, BagWriter(path) as bag:
        if not robot.is_static_latched:
            monkeypatch.setattr(bag_writer, '_STATIC_QOS', bag_writer._STREAM_QOS)
        bag.write_transform(f'{robot.tf}_static', start_ns, 'base_link', robot.mount_child, told)
        for parent, child in robot.more_transforms:
            bag.write_transform(robot.tf, start_ns, parent, child, np.eye(4))
        T_wheels = wheels[0]
        for index, scan in enumerate(scans):
            jump_s = robot.jump[1] if index >= robot.jump[0] else 0.0
            stamp_ns = scan.stamp_ns + round((robot.scan_clock_s + jump_s) * SECOND)
            points = (scan.points @ off[:3, :3]).astype(np.float32)
            times_s = scan.time_s - SWEEP_S + robot.last_time_s
            bag.write_cloud(
                robot.scans, stamp_ns, robot.frame, points,
                time_s=times_s.astype(np.float32) if robot.has_times else None,
            )  # fmt: skip
            if index:
                step = np.linalg.inv(wheels[index - 1]) @ wheels[index]
                step[:3, 3] *= robot.wheel_scale
                way_m = np.linalg.norm(step[:2, 3])
                step[:3, :3] @= turned('z', robot.drift_deg_per_m * way_m)[:3, :3]
                if robot.mirrored_turns:
                    step[:3, :3] = step[:3, :3].T
                T_wheels = T_wheels @ step
            odometry = T_wheels @ np.linalg.inv(T_base_lidar)
            if robot.flips and index % 2:
                odometry = odometry @ turned('z', 180.0)
            if index % robot.scans_per_pose == 0:
                bag.write_odometry('/odom', scan.stamp_ns, 'odom', robot.child, odometry)
        write_gyro(bag, drive, robot)
    return path


def write_gyro(bag: BagWriter, drive, robot: Robot) -> None:
    """Write rates at 50 Hz, steady between two poses of the wheels."""
    if not robot.gyro_frame:
        return
    scans, wheels = drive
    bag.write_transform(f'{robot.tf}_static', scans[0].stamp_ns, 'base_link', 'imu', np.eye(4))
    off = np.eye(3) if robot.T_imu_lidar is None else robot.T_imu_lidar[:3, :3]
    for index in range(1, len(scans)):
        turn = Rotation.from_matrix(wheels[index - 1][:3, :3].T @ wheels[index][:3, :3])
        rate = off @ turn.as_rotvec() / SWEEP_S * robot.gyro_factor
        rate = rate + np.deg2rad([0.0, 0.0, robot.gyro_offset_deg])
        for part in range(5):
            stamp_ns = scans[index].stamp_ns - round((4 - part) * SWEEP_S / 5 * SECOND)
            bag.write_imu('/imu/data', stamp_ns, robot.gyro_frame, rate)


def at_arrival(path: Path, drive, robot: Robot, monkeypatch) -> Path:
    """Record with the times of arrival of the right clock, whatever the stamps say."""
    scans, _ = drive
    times = {}
    shifted = robot.scan_clock_s or robot.jump[1]
    for index, scan in enumerate(scans):
        jump_s = robot.jump[1] if index >= robot.jump[0] else 0.0
        stamp_ns = scan.stamp_ns + round((robot.scan_clock_s + jump_s) * SECOND)
        times[stamp_ns] = scan.stamp_ns
    write = BagWriter._write

    def _write(self, topic, msgtype, stamp_ns, message, *rest):
        heard_ns = times.get(stamp_ns, stamp_ns) if shifted and topic == robot.scans else stamp_ns
        write(self, topic, msgtype, heard_ns, message, *rest)

    monkeypatch.setattr(BagWriter, '_write', _write)
    return record(path, drive, robot)


@pytest.mark.parametrize(
    ('robot', 'problem', 'where', 'words'),
    [
        (RIGHT, None, '', []),
        (
            replace(RIGHT, scan_clock_s=-0.1),
            Problem.LAG, '/points', ['if its stamps are 0.10 s early', 'scan_stamp:=start'],
        ),
        (replace(RIGHT, scan_clock_s=-0.1, last_time_s=0.1), None, '', []),
        (replace(RIGHT, scan_clock_s=0.14), Problem.LAG, '/points', ['0.14 s late']),
        (
            replace(RIGHT, scans='/lidar/map_points', frame='laser_link'),
            Problem.FRAME, 'laser_link',
            ['odometry is of base_link', '--frame-id base_link --child-frame-id laser_link'],
        ),
        (
            replace(RIGHT, frame='lidar_', T_mount_lidar=None),
            Problem.FRAME, 'lidar_', ['there is lidar'],
        ),
        (replace(RIGHT, frame=''), Problem.FRAME, '/points', ['names no frame']),
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
            Problem.FRAME, 'lidar', ['nothing on /tf_static joins both'],
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
            Problem.TILTED, 'lidar', ['after a turn of 15 degrees', '--pitch'],
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
            Problem.GYRO, '/imu/data', ['times the turns that the scans tell: degrees', 'rad/s'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', gyro_factor=0.6),
            Problem.GYRO, '/imu/data', ['0.58 times', 'scale'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', gyro_offset_deg=5.0),
            Problem.GYRO, '/imu/data', ['5.1 degrees a second', 'stands still'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', T_imu_lidar=turned('x', 180.0)),
            Problem.GYRO, '/imu/data', ['-0.97 times', 'upside down'],
        ),
        (
            replace(RIGHT, gyro_frame='imu', T_imu_lidar=turned('x', 90.0)),
            Problem.GYRO, '/imu/data', ['other axes', 'rotation'],
        ),
        (replace(RIGHT, wheel_scale=1.6), Problem.ODOMETRY, '/odom', ['odometry says']),
        (
            replace(RIGHT, wheel_scale=1.4),
            Problem.ODOMETRY, '/odom', ['times the way', 'radius of the wheels'],
        ),
        (
            replace(RIGHT, T_mount_lidar=turned('z', 20.0)),
            Problem.ODOMETRY, '/odom', ['20 degrees to one side', 'the static transform'],
        ),
        (
            replace(RIGHT, drift_deg_per_m=4.0),
            Problem.ODOMETRY, '/odom', ['degrees a metre that nobody drove'],
        ),
        (replace(RIGHT, flips=True), Problem.ODOMETRY, '/odom', ['as no robot does', 'two nodes']),
        (replace(RIGHT, mirrored_turns=True), Problem.ODOMETRY, '/odom', ['degrees, the scans']),
        (
            replace(RIGHT, T_mount_lidar=turned('z', 90.0)),
            Problem.ODOMETRY, '/odom', ['the yaw of the static transform'],
        ),
    ],
)  # fmt: skip
def test_each_fault_is_found_in_the_first_seconds_and_no_other(
    drive, tmp_path, monkeypatch, robot, problem, where, words
):
    seen = observe_bag(at_arrival(tmp_path / 'bag', drive, robot, monkeypatch), 10.0)
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
        ('/scan', ['nobody publishes it', 'there is /points', 'points:=/points']),
        ('/odom', ['is a nav_msgs/msg/Odometry', 'there is /points']),
    ):
        found = examine(observe_bag(path, 10.0, name))
        assert found[0].problem is Problem.TOPIC
        assert all(word in f'{found[0].said} {found[0].next}' for word in words), found[0].said
    found = examine(observe_bag(path, 10.0, odometry='/wheels'))
    assert [finding.problem for finding in found] == [Problem.TOPIC]
    assert 'there is /odom' in found[0].said
    empty = tmp_path / 'empty'
    with BagWriter(empty) as bag:
        bag.write_number('/battery', 1, 0.5)
    (finding,) = examine(observe_bag(empty, 10.0))
    assert finding.problem is Problem.TOPIC
    assert 'nothing here carries scans' in finding.said


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
