# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Simulated robots with several lidars and wheels, and their messages during a recording.

:mod:`fpnet_lab.sim.drives.recording` records a single sensor. This module records a robot: its
base, its sensors with their poses on ``/tf_static``, its wheel odometry as messages or in TF, and
the stamps and point times of different drivers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fpnet.bag_writer import BagWriter
from fpnet_core.geometry import SE2, angle_between
from fpnet_core.io.topic_names import TF_TOPIC
from fpnet_core.stamps import NS_PER_S
from fpnet_lab.sim.drives.drift import wheel_odometry
from fpnet_lab.sim.drives.laser_scans import laser_readings
from fpnet_lab.sim.drives.recording import Recording, make_recording
from fpnet_lab.sim.drives.scanning import EPOCH_NS, SimulatedScan, sensor_poses_at
from fpnet_lab.sim.drives.visits import RecordingOptions
from fpnet_lab.sim.lidars.lidar import LidarSimulator
from fpnet_lab.sim.lidars.sensors import LidarModel

Array = NDArray[np.float64]

BASE, WHEELS_FRAME = 'base_link', 'odom'
"""Frames of the robot and of its wheels' odometry. Given: REP-105."""

LIDAR = LidarModel(beams=16, columns=450)
"""A small lidar, sufficient to localize the robots of this benchmark. Chosen."""

PLANAR = LidarModel(
    beams=1, columns=720, lowest_rad=0.0, highest_rad=0.0, max_range_m=25.0, angle_sigma_rad=0.0
)
"""A planar scanner. Chosen."""

_WHEELS_NS = 20_000_000  # chosen: wheels report at 50 Hz
_TOUR_STEPS_PER_S = 100.0  # given by the simulator's tours


def place(x: float, y: float, z: float, *rpy_deg: float) -> Array:
    """Return ``T_base_sensor (4, 4)`` of a position [m] and roll, pitch and yaw [deg]."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler('xyz', rpy_deg, degrees=True).as_matrix()
    T[:3, 3] = x, y, z
    return T


@dataclass(frozen=True, eq=False)
class Sensor:
    """
    A lidar on the robot.

    ``T_base_sensor`` is (4, 4); ``stamp`` is the share of the sweep completed at the cloud's
    stamp. With ``absolute_times``, point times use the stamp's clock instead of being relative to
    the stamp. Single-beam sensors report LaserScans, stamped at the start of the sweep.
    """

    topic: str
    frame: str
    T_base_sensor: Array
    model: LidarModel = LIDAR
    stamp: float = 1.0
    absolute_times: bool = False


@dataclass(frozen=True, eq=False)
class Robot:
    """
    A robot's equipment; ``seed`` determines its building and tour.

    ``wheels_topic`` is the topic of wheel odometry (empty: none); ``wheels_in_tf`` publishes it
    in TF. ``namespace`` is the TF namespace with a leading slash, or empty.
    """

    seed: int
    sensors: tuple[Sensor, ...]
    wheels_topic: str = ''
    wheels_in_tf: bool = False
    namespace: str = ''


@dataclass(frozen=True, eq=False)
class Drive:
    """A robot on a tour; its base is on the floor, below the recording's sensor."""

    robot: Robot
    recording: Recording

    @classmethod
    def of(cls, robot: Robot, seconds: float) -> Drive:
        """Return the first ``seconds`` of a simulated tour."""
        recording = make_recording(robot.seed, RecordingOptions(lidar=PLANAR), threads=1)
        tour, count = recording.tour, round(seconds * _TOUR_STEPS_PER_S)
        short = replace(
            tour,
            time_s=tour.time_s[:count],
            xy=tour.xy[:count],
            yaw_rad=tour.yaw_rad[:count],
            tilt_rad=np.zeros((count, 2)),
        )
        return cls(robot, replace(recording, tour=short))

    def base_at(self, stamps_ns: NDArray[np.int64]) -> Array:
        """Return ``T_building_base (S, 4, 4)``."""
        poses = sensor_poses_at(self.recording.tour, np.asarray(stamps_ns))
        poses[:, 2, 3] = 0.0
        return poses

    def sweeps(self, number: int) -> Iterator[SimulatedScan]:
        """Yield all sweeps of a sensor, stamped at their ends."""
        sensor = self.robot.sensors[number]
        simulator = LidarSimulator(self.recording.building, sensor.model, threads=1)
        for index, stamp_ns in enumerate(self.recording.stamps_ns):
            start_s = index * sensor.model.period_s
            at_ns = EPOCH_NS + np.round((start_s + sensor.model.column_times_s) * NS_PER_S)
            poses = self.base_at(at_ns.astype(np.int64)) @ sensor.T_base_sensor
            rng = np.random.default_rng((self.robot.seed, number, index))
            sweep = simulator.sweep(poses[:, :3, :3], poses[:, :3, 3], start_s, rng)
            yield SimulatedScan(
                stamp_ns=int(stamp_ns),
                points=sweep.points,
                time_s=sweep.time_s,
                intensity=sweep.intensity,
                ring=sweep.ring,
            )

    def write(self, bag: BagWriter) -> int:
        """Write all of the robot's messages and return the number of sweeps per sensor."""
        tf = self.robot.namespace + TF_TOPIC
        for sensor in self.robot.sensors:
            bag.write_transform(f'{tf}_static', EPOCH_NS, BASE, sensor.frame, sensor.T_base_sensor)
        events: list[tuple[int, Callable[[], None]]] = []
        for number, sensor in enumerate(self.robot.sensors):
            for scan in self.sweeps(number):
                events.append((scan.stamp_ns, _writing(bag, sensor, scan)))
        for stamp_ns, T in self._wheels():
            events.append((stamp_ns, self._reporting(bag, stamp_ns, T)))
        for _, write in sorted(events, key=lambda event: event[0]):
            write()
        return len(self.recording)

    def _wheels(self) -> list[tuple[int, Array]]:
        if not (self.robot.wheels_topic or self.robot.wheels_in_tf):
            return []
        stamps = np.arange(EPOCH_NS, int(self.recording.stamps_ns[-1]) + _WHEELS_NS, _WHEELS_NS)
        drifting = wheel_odometry(self.base_at(stamps), np.random.default_rng(self.robot.seed))
        return list(zip(stamps.tolist(), drifting, strict=True))

    def _reporting(self, bag: BagWriter, stamp_ns: int, T: Array) -> Callable[[], None]:
        def write() -> None:
            if self.robot.wheels_topic:
                bag.write_odometry(self.robot.wheels_topic, stamp_ns, WHEELS_FRAME, BASE, T)
            if self.robot.wheels_in_tf:
                bag.write_transform(TF_TOPIC, stamp_ns, WHEELS_FRAME, BASE, T)

        return write

    def errors(self, stamps_ns: NDArray[np.int64], poses: list[SE2], T_base_body: Array) -> Array:
        """Return errors (S, 2) of poses in the plan frame, measured in the building [m, rad]."""
        A_building_plan = self.recording.A_plan_building.inv()
        truth = self.base_at(stamps_ns) @ T_base_body
        rows = []
        for true, pose in zip(truth, poses, strict=True):
            apart = A_building_plan.apply(pose.translation) - true[:2, 3]
            turned = angle_between(A_building_plan.apply_yaw(pose.yaw), SE2.from_matrix4(true).yaw)
            rows.append((float(np.hypot(*apart)), turned))
        return np.array(rows).reshape(-1, 2)


def _writing(bag: BagWriter, sensor: Sensor, scan: SimulatedScan) -> Callable[[], None]:
    period_ns = round(sensor.model.period_s * NS_PER_S)
    start_ns = scan.stamp_ns - period_ns
    assert scan.time_s is not None
    if sensor.model.beams == 1:
        readings = laser_readings(scan, sensor.model)
        return lambda: bag.write_laser_scan(sensor.topic, start_ns, sensor.frame, readings)
    stamp_ns = start_ns + round(sensor.stamp * period_ns)
    if sensor.absolute_times:
        time_s = scan.time_s + start_ns / NS_PER_S
    else:
        time_s = (scan.time_s + (start_ns - stamp_ns) / NS_PER_S).astype(np.float32)
    return lambda: bag.write_cloud(
        sensor.topic, stamp_ns, sensor.frame, scan.points, scan.intensity, scan.ring, time_s
    )
