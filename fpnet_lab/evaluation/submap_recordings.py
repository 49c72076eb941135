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
from fpnet_lab.sim.explore import fit_rigid
from fpnet_lab.sim.recording import RecordingOptions, make_recording
from fpnet_lab.sim.sensors import sensor_named
from fpnet_lab.sim.tours import TourLimits
from fpnet_lab.sim.types import BuildingPlan

Array = NDArray[np.float64]

SENSOR_NAMES = ('beams16', 'beams32', 'beams64', 'dome', 'planar')
"""Sensor models that drives are made with; ``dome`` does not repeat its pattern."""

# Chosen, not measured:
# Every sweep is registered; each of so many is kept for the submap.
_KEEP_EVERY = 3
_LIMITS = TourLimits(rooms=4, shortest_s=30.0, longest_s=60.0)
_ROOMS = (10, 30)


@dataclass(frozen=True, eq=False)
class Drive:
    """
    A registered drive and the building it went through.

    ``sweeps`` are points ``(P, 3)`` [m] in the sensor frame, ``T_odom_sensor (4, 4)`` and stamp;
    ``T_building_odom`` takes the odometry's path to the true one best: where its frame lies is no
    property of the map, and what bends the map inside of it still counts.
    """

    plan: BuildingPlan
    T_building_odom: SE2
    sweeps: tuple[tuple[NDArray[np.float32], Array, int], ...]


def registered_drive(seed: int, sensor: str, config: FpnetConfig) -> Drive:
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
    options = RecordingOptions(rooms=_ROOMS, lidar=sensor_named(sensor), limits=_LIMITS)
    recording = make_recording(seed, options, threads=1)
    odometry = KissOdometry(config.odometry)
    registered = [(odometry.register_scan(scan), scan.stamp_ns) for scan in recording]
    kept = registered[::_KEEP_EVERY]
    poses, truth = np.array([s.T_odom_sensor for s, _ in kept]), recording.truth()[::_KEEP_EVERY]
    yaw_true, yaw = (np.arctan2(T[:, 1, 0], T[:, 0, 0]) for T in (truth, poses))
    placed = fit_rigid(poses[:, :2, 3], truth[:, :2, 3], yaw_true - yaw)
    sweeps = tuple((s.points, s.T_odom_sensor, stamp_ns) for s, stamp_ns in kept)
    return Drive(recording.building.plan, placed, sweeps)
