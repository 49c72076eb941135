# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recordings of misconfigured robots, one per fault type."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet.bag_writer import BagWriter
from fpnet_core.doctor import Problem
from fpnet_core.stamps import NS_PER_S
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording
from fpnet_lab.sim.drives.scanning import SimulatedScan
from fpnet_lab.sim.lidars.sensors import SENSORS

Array = NDArray[np.float64]

_FIRST, _COUNT = 10, 60  # numerical: first scan, after the robot's initial pause, and their number
_HEIGHT_M = 0.9  # chosen
_SWEEP_S = 0.1  # given: sweep duration of the simulated lidars
_GYRO_RATES = 5  # numerical: gyroscope samples per sweep


def turned(axes: str, degrees: float | tuple[float, ...]) -> Array:
    """Return a rotation (4, 4) about axes in SciPy's notation."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler(axes, degrees, degrees=True).as_matrix()
    return T


@dataclass(frozen=True, eq=False)
class ShortDrive:
    """A short recording: scans, and sensor poses ``(S, 4, 4)`` from wheel odometry."""

    scans: tuple[SimulatedScan, ...]
    wheels: Array

    @classmethod
    def of(cls, seed: int, sensor: str = 'beams16') -> ShortDrive:
        """Return the beginning of a generated recording."""
        recording = make_recording(seed, RecordingOptions(lidar=SENSORS[sensor]), 1)
        chosen = range(_FIRST, _FIRST + _COUNT)
        scans = tuple(recording.scan(index) for index in chosen)
        return cls(scans, recording.wheel_odometry()[_FIRST : _FIRST + _COUNT])


@dataclass(frozen=True, eq=False)
class FaultyRobot:
    """
    Configuration of a robot; the defaults are correct.

    ``T_mount_lidar`` is the lidar's true mounting relative to its published transform,
    ``T_imu_lidar`` that of the gyroscope.
    """

    scans: str = '/points'
    tf: str = '/tf'
    frame: str = 'lidar'
    child: str = 'base_link'
    mount_child: str = 'lidar'
    told_height_m: float = _HEIGHT_M
    T_mount_lidar: Array | None = None
    has_times: bool = True
    last_time_s: float = 0.0  # time of the last point relative to the stamp
    scan_clock_s: float = 0.0
    jump: tuple[int, float] = (0, 0.0)  # first affected scan, and the jump of its clock [s]
    wheel_scale: float = 1.0
    drift_deg_per_m: float = 0.0
    mirrored_turns: bool = False
    flips: bool = False  # every second odometry pose is rotated by 180 degrees
    scans_per_pose: int = 1  # number of scans per wheel odometry message
    more_transforms: tuple[tuple[str, str], ...] = ()
    is_static_latched: bool = True
    gyro_frame: str = ''  # '': no gyroscope
    gyro_factor: float = 1.0
    gyro_offset_deg: float = 0.0  # per second
    T_imu_lidar: Array | None = None


RIGHT = FaultyRobot()
"""Given: a robot without a fault."""

FAULTS: dict[str, tuple[FaultyRobot, Problem]] = {
    'stamps at the start of sweeps': (FaultyRobot(scan_clock_s=-0.1), Problem.LAG),
    'stamps late': (FaultyRobot(scan_clock_s=0.14), Problem.LAG),
    'a frame that nothing joins': (
        FaultyRobot(scans='/lidar/map_points', frame='laser_link'),
        Problem.FRAME,
    ),
    'a frame misspelt': (FaultyRobot(frame='lidar_'), Problem.FRAME),
    'clouds without a frame': (FaultyRobot(frame=''), Problem.FRAME),
    'odometry without a child frame': (FaultyRobot(child=''), Problem.FRAME),
    'TF of another robot': (FaultyRobot(tf='/robot_1/tf'), Problem.FRAME),
    'two odometries in TF': (
        FaultyRobot(more_transforms=(('odom', 'base_link'), ('odom_lidar', 'base_link'))),
        Problem.PARENTS,
    ),
    'a loop in TF': (
        FaultyRobot(more_transforms=(('a', 'b'), ('b', 'c'), ('c', 'a'))),
        Problem.LOOP,
    ),
    'static transforms not latched': (FaultyRobot(is_static_latched=False), Problem.QOS),
    'stamps since the start of the sensor': (
        FaultyRobot(scan_clock_s=-1.6e9),
        Problem.OTHER_CLOCK,
    ),
    'a clock that goes back': (FaultyRobot(jump=(20, -3.03)), Problem.CLOCK_JUMP),
    'a clock that skips': (FaultyRobot(jump=(20, 7.0)), Problem.CLOCK_JUMP),
    'no times of points': (FaultyRobot(has_times=False), Problem.POINT_TIMES),
    'a lidar upside down': (FaultyRobot(T_mount_lidar=turned('x', 180.0)), Problem.UPSIDE_DOWN),
    'a lidar tilted': (FaultyRobot(T_mount_lidar=turned('y', 15.0)), Problem.TILTED),
    'a lidar with optical axes': (
        FaultyRobot(T_mount_lidar=turned('zyx', (-90.0, 0.0, -90.0))),
        Problem.TILTED,
    ),
    'a lidar at another height': (FaultyRobot(told_height_m=1.5), Problem.HEIGHT),
    'odometry at 1 Hz': (FaultyRobot(scans_per_pose=10), Problem.SPARSE),
    'wheels that count 1.6 times the way': (FaultyRobot(wheel_scale=1.6), Problem.ODOMETRY),
    'wheels that count 1.4 times the way': (FaultyRobot(wheel_scale=1.4), Problem.ODOMETRY),
    'a lidar 20 degrees off in yaw': (
        FaultyRobot(T_mount_lidar=turned('z', 20.0)),
        Problem.ODOMETRY,
    ),
    'a lidar 90 degrees off in yaw': (
        FaultyRobot(T_mount_lidar=turned('z', 90.0)),
        Problem.ODOMETRY,
    ),
    'wheels that turn 4 degrees a metre': (FaultyRobot(drift_deg_per_m=4.0), Problem.ODOMETRY),
    'odometry of two nodes': (FaultyRobot(flips=True), Problem.ODOMETRY),
    'wheels that turn the other way': (FaultyRobot(mirrored_turns=True), Problem.ODOMETRY),
    'a gyroscope without a place': (FaultyRobot(gyro_frame='imu_link'), Problem.FRAME),
    'a gyroscope in degrees': (
        FaultyRobot(gyro_frame='imu', gyro_factor=180.0 / np.pi),
        Problem.GYRO,
    ),
    'a gyroscope of another scale': (FaultyRobot(gyro_frame='imu', gyro_factor=0.6), Problem.GYRO),
    'a gyroscope with an offset': (
        FaultyRobot(gyro_frame='imu', gyro_offset_deg=5.0),
        Problem.GYRO,
    ),
    'a gyroscope upside down': (
        FaultyRobot(gyro_frame='imu', T_imu_lidar=turned('x', 180.0)),
        Problem.GYRO,
    ),
    'a gyroscope on other axes': (
        FaultyRobot(gyro_frame='imu', T_imu_lidar=turned('x', 90.0)),
        Problem.GYRO,
    ),
}
"""
Given: robots with one fault each, by name, with the problem to detect.
"""


def record(path: Path, drive: ShortDrive, robot: FaultyRobot) -> Path:
    """Write a robot's recording as a bag; receive times are correct even if stamps are not."""
    T_base_lidar = np.eye(4)
    T_base_lidar[2, 3] = _HEIGHT_M
    reported = T_base_lidar.copy()
    reported[2, 3] = robot.told_height_m
    off = np.eye(4) if robot.T_mount_lidar is None else robot.T_mount_lidar
    start_ns, latched = drive.scans[0].stamp_ns, robot.is_static_latched
    with BagWriter(path) as bag:
        static = f'{robot.tf}_static'
        bag.write_transform(static, start_ns, 'base_link', robot.mount_child, reported, latched)
        for parent, child in robot.more_transforms:
            bag.write_transform(robot.tf, start_ns, parent, child, np.eye(4))
        odometry = _odometry(drive, robot) @ np.linalg.inv(T_base_lidar)
        for index, scan in enumerate(drive.scans):
            jump_s = robot.jump[1] if index >= robot.jump[0] else 0.0
            stamp_ns = scan.stamp_ns + round((robot.scan_clock_s + jump_s) * NS_PER_S)
            points = (scan.points @ off[:3, :3]).astype(np.float32)
            times_s = _times_s(scan, robot)
            bag.write_cloud(
                robot.scans, stamp_ns, robot.frame, points, time_s=times_s, heard_ns=scan.stamp_ns
            )
            if index % robot.scans_per_pose == 0:
                bag.write_odometry('/odom', scan.stamp_ns, 'odom', robot.child, odometry[index])
        if robot.gyro_frame:
            _write_gyro(bag, drive, robot)
    return path


def _times_s(scan: SimulatedScan, robot: FaultyRobot) -> NDArray[np.float32] | None:
    """Return the point times of a scan relative to its stamp [s]."""
    if not robot.has_times:
        return None
    assert scan.time_s is not None, 'a simulated scan has point times'
    return (scan.time_s - _SWEEP_S + robot.last_time_s).astype(np.float32)


def _odometry(drive: ShortDrive, robot: FaultyRobot) -> Array:
    """Return the sensor poses (S, 4, 4) according to the robot's wheel odometry."""
    poses = [drive.wheels[0]]
    for before, after in zip(drive.wheels, drive.wheels[1:], strict=False):
        step = np.linalg.inv(before) @ after
        step[:3, 3] *= robot.wheel_scale
        way_m = float(np.linalg.norm(step[:2, 3]))
        step[:3, :3] @= turned('z', robot.drift_deg_per_m * way_m)[:3, :3]
        if robot.mirrored_turns:
            step[:3, :3] = step[:3, :3].T
        poses.append(poses[-1] @ step)
    reported = np.array(poses)
    if robot.flips:
        reported[1::2] = reported[1::2] @ turned('z', 180.0)
    return reported


def _write_gyro(bag: BagWriter, drive: ShortDrive, robot: FaultyRobot) -> None:
    """Write gyroscope rates at 50 Hz, constant between two wheel odometry poses."""
    scans, wheels = drive.scans, drive.wheels
    bag.write_transform(f'{robot.tf}_static', scans[0].stamp_ns, 'base_link', 'imu', np.eye(4))
    off = np.eye(3) if robot.T_imu_lidar is None else robot.T_imu_lidar[:3, :3]
    for index in range(1, len(scans)):
        turn = Rotation.from_matrix(wheels[index - 1][:3, :3].T @ wheels[index][:3, :3])
        rate = off @ turn.as_rotvec() / _SWEEP_S * robot.gyro_factor
        rate = rate + np.deg2rad([0.0, 0.0, robot.gyro_offset_deg])
        for part in range(_GYRO_RATES):
            later_s = (_GYRO_RATES - 1 - part) * _SWEEP_S / _GYRO_RATES
            stamp_ns = scans[index].stamp_ns - round(later_s * NS_PER_S)
            bag.write_imu('/imu/data', stamp_ns, robot.gyro_frame, rate)
