# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated scans along a tour, with ground truth poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.scans import Scan
from fpnet_core.stamps import NS_PER_S
from fpnet_lab.sim.drives.driving import Tour
from fpnet_lab.sim.lidars.lidar import LidarSimulator

EPOCH_NS = 1_750_000_000 * NS_PER_S
"""Given: sensor time of a recording's start; ROS treats times near zero as unset."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SimulatedScan(Scan):
    """
    A sweep with all fields that the sensor reports.

    ``stamp_ns`` is the end of the sweep, ``T_truth_sensor`` the sensor's pose in ``building`` at
    that instant; ``time_s`` is relative to the start of the sweep. ``intensity (P,) float32`` is
    in [0, 255], ``ring (P,) uint16``.
    """

    intensity: NDArray[np.float32]
    ring: NDArray[np.uint16]


def scan_stamps_ns(tour: Tour, period_s: float) -> NDArray[np.int64]:
    """Return the stamps ``(S,)`` [ns] of the sweeps that end within a tour."""
    period_ns = round(period_s * NS_PER_S)
    return EPOCH_NS + period_ns * np.arange(1, int(tour.duration_s / period_s) + 1, dtype=np.int64)


def sensor_poses_at(tour: Tour, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return ``T_building_sensor (S, 4, 4)`` at sensor times ``(S,)`` [ns]."""
    R, origin = tour.sensor_poses((stamps_ns - EPOCH_NS) / NS_PER_S)
    poses = np.tile(np.eye(4), (len(R), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = R, origin
    return poses


def cast_scan(
    lidar: LidarSimulator, tour: Tour, index: int, rng: np.random.Generator
) -> SimulatedScan:
    """Cast sweep ``index`` of a tour, starting ``index`` periods after the tour's start."""
    model = lidar.model
    start_s = index * model.period_s
    R, origin = tour.sensor_poses(start_s + model.column_times_s)
    sweep = lidar.sweep(R, origin, start_s, rng)
    stamp_ns = EPOCH_NS + round(model.period_s * NS_PER_S) * (index + 1)
    return SimulatedScan(
        stamp_ns=stamp_ns,
        points=sweep.points,
        time_s=sweep.time_s,
        T_truth_sensor=sensor_poses_at(tour, np.array([stamp_ns]))[0],
        intensity=sweep.intensity,
        ring=sweep.ring,
    )
