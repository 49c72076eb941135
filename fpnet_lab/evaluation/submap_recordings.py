# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Short simulated recordings, registered by the product's own odometry.

The submap benchmark needs a robot's data: deskewed sweeps with drifting KISS-ICP poses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2, rotation
from fpnet_core.io.scans import Scan
from fpnet_lab.evaluation.localization.drives import KEEP_EVERY, kept_scans
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.sim.drives.tours import TourLimits
from fpnet_lab.sim.pairs.explore import fit_rigid
from fpnet_lab.sim.types import BuildingPlan

SENSOR_NAMES = ('beams16', 'beams32', 'beams64', 'dome', 'planar')
"""Sensor models of the recordings; ``dome`` has a scan pattern that does not repeat."""

# Chosen, not measured:
_CAST_EVERY = 6  # sweeps, if the poses are not those of KISS-ICP
_DRIFT = (0.002, 0.002, 0.0004)  # standard deviations of a random walk per sweep [m, m, rad]
_LIMITS = TourLimits(rooms=4, shortest_s=30.0, longest_s=60.0)
_ROOMS = (10, 30)


@dataclass(frozen=True, eq=False)
class RegisteredDrive:
    """
    Registered recording and its building.

    ``T_building_odom`` is the rigid fit of the odometry's path to the true one: the pose of the
    odometry frame is no property of the map, but deformation by drift remains.
    """

    plan: BuildingPlan
    T_building_odom: SE2
    sweeps: tuple[Scan, ...]


def drifting_drive(seed: int, sensor: str, rng: np.random.Generator) -> RegisteredDrive:
    """
    Return the recording of a seed and sensor, with true poses plus random drift.

    Sweeps are deskewed by the true poses and every sixth is ray-cast, in a tenth of the time of
    :func:`registered_drive`, which the benchmark uses.

    Raises
    ------
    ConfigError
        If the seed yields no building with such a tour.
    """
    recording = drive_through(None, sensor, seed, rooms=_ROOMS, limits=_LIMITS)
    steps = rng.normal(0.0, _DRIFT, (len(recording), 3))
    sweeps = []
    for index, (x, y, yaw) in list(enumerate(np.cumsum(steps, axis=0).tolist()))[::_CAST_EVERY]:
        scan = recording.deskewed(index)
        drifted = np.array(scan.T_odom_sensor)
        drifted[:2, :3] = rotation(yaw) @ drifted[:2, :3]
        drifted[:2, 3] += x, y
        sweeps.append(replace(scan, T_odom_sensor=drifted))
    return RegisteredDrive(recording.building.plan, SE2.identity(), tuple(sweeps))


def registered_drive(seed: int, sensor: str, config: FpnetConfig) -> RegisteredDrive:
    """
    Return the recording of ``seed`` with a sensor.

    Parameters
    ----------
    seed : equal seeds give the same building, furniture and tour for every sensor
    sensor : one of ``SENSOR_NAMES``
    config : odometry settings

    Raises
    ------
    ConfigError
        If the seed yields no building with such a tour.
    """
    recording = drive_through(None, sensor, seed, rooms=_ROOMS, limits=_LIMITS)
    kept = kept_scans(recording, config.odometry)
    poses, truth = np.array([s.T_odom_sensor for s in kept]), recording.truth()[::KEEP_EVERY]
    yaw_true, yaw = (np.arctan2(T[:, 1, 0], T[:, 0, 0]) for T in (truth, poses))
    placed = fit_rigid(poses[:, :2, 3], truth[:, :2, 3], yaw_true - yaw)
    return RegisteredDrive(recording.building.plan, placed, tuple(kept))
