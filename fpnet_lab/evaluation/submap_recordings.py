# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Short simulated drives, registered by the product's own odometry.

The submap benchmark needs what a robot would have: deskewed sweeps with the poses that KISS-ICP
gave them, drift included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2
from fpnet_core.odometry import KissOdometry
from fpnet_lab.evaluation.localization.drives import KEEP_EVERY
from fpnet_lab.sim.explore import fit_rigid
from fpnet_lab.sim.recording import RecordingOptions, make_recording
from fpnet_lab.sim.sensors import sensor_named
from fpnet_lab.sim.tours import TourLimits
from fpnet_lab.sim.types import BuildingPlan

Array = NDArray[np.float64]

SENSOR_NAMES = ('beams16', 'beams32', 'beams64', 'dome', 'planar')
"""Sensor models that drives are made with; ``dome`` does not repeat its pattern."""

# Chosen, not measured:
_CAST_EVERY = 6  # where poses are not those of KISS-ICP
_DRIFT = (0.002, 0.002, 0.0004)  # steps of a random walk per sweep [m, m, rad]
_LIMITS = TourLimits(rooms=4, shortest_s=30.0, longest_s=60.0)
_ROOMS = (10, 30)


@dataclass(frozen=True, eq=False)
class RegisteredDrive:
    """
    A registered drive and the building it went through.

    ``sweeps`` are points ``(P, 3)`` [m] in the sensor frame, ``T_odom_sensor (4, 4)`` and stamp;
    ``T_building_odom`` takes the odometry's path to the true one best: where its frame lies is no
    property of the map, and what bends the map inside of it still counts.
    """

    plan: BuildingPlan
    T_building_odom: SE2
    sweeps: tuple[tuple[NDArray[np.float32], Array, int], ...]


def drifting_drive(seed: int, sensor: str, rng: np.random.Generator) -> RegisteredDrive:
    """
    Return the drive of ``seed`` with a sensor, with true poses that drift at random.

    Sweeps are deskewed by the truth, and every sixth is cast: a tenth of the time of
    :func:`registered_drive`, which the benchmark's figures are of.

    Raises
    ------
    ConfigError
        If no building with such a tour comes out of the seed.
    """
    recording = make_recording(seed, _options(sensor), threads=1)
    steps = rng.normal(0.0, _DRIFT, (len(recording), 3))
    sweeps = []
    for index, (x, y, yaw) in list(enumerate(np.cumsum(steps, axis=0).tolist()))[::_CAST_EVERY]:
        scan = recording.scan(index)
        T, time_s = scan.T_truth_sensor, scan.time_s
        assert T is not None, 'a simulated scan knows its pose'
        assert isinstance(time_s, np.ndarray), 'and when its points were measured'
        begin_s = index * recording.lidar.model.period_s
        R, origin = recording.tour.sensor_poses(begin_s + time_s)
        points = np.einsum('pij,pj->pi', R, scan.points.astype(np.float64)) + origin - T[:3, 3]
        drifted = T.copy()
        drifted[:2, :3] = SE2.from_xy_yaw(0.0, 0.0, yaw).linear @ T[:2, :3]
        drifted[:2, 3] += x, y
        sweeps.append(((points @ T[:3, :3]).astype(np.float32), drifted, scan.stamp_ns))
    return RegisteredDrive(recording.building.plan, SE2.from_xy_yaw(0.0, 0.0, 0.0), tuple(sweeps))


def _options(sensor: str) -> RecordingOptions:
    return RecordingOptions(rooms=_ROOMS, lidar=sensor_named(sensor), limits=_LIMITS)


def registered_drive(seed: int, sensor: str, config: FpnetConfig) -> RegisteredDrive:
    """
    Return the drive of ``seed`` with a sensor.

    Parameters
    ----------
    seed : equal seeds give the same building, furniture and tour for every sensor
    sensor : one of ``SENSOR_NAMES``
    config : odometry settings

    Raises
    ------
    ConfigError
        If no building with such a tour comes out of the seed.
    """
    recording = make_recording(seed, _options(sensor), threads=1)
    odometry = KissOdometry(config.odometry)
    registered = [(odometry.register_scan(scan), scan.stamp_ns) for scan in recording]
    kept = registered[::KEEP_EVERY]
    poses, truth = np.array([s.T_odom_sensor for s, _ in kept]), recording.truth()[::KEEP_EVERY]
    yaw_true, yaw = (np.arctan2(T[:, 1, 0], T[:, 0, 0]) for T in (truth, poses))
    placed = fit_rigid(poses[:, :2, 3], truth[:, :2, 3], yaw_true - yaw)
    sweeps = tuple((s.points, s.T_odom_sensor, stamp_ns) for s, stamp_ns in kept)
    return RegisteredDrive(recording.building.plan, placed, sweeps)
