# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated sweeps of a planar sensor as LaserScan data: one range per ray."""

from __future__ import annotations

import numpy as np

from fpnet_core.errors import ConfigError
from fpnet_core.io.laserscan import LaserReadings
from fpnet_lab.sim.drives.scanning import SimulatedScan
from fpnet_lab.sim.lidars.sensors import LidarModel, SensorModel


def check_planar(model: SensorModel) -> LidarModel:
    """
    Return the model of a sensor that reports LaserScans.

    Raises
    ------
    ConfigError
        If it has more than one beam, or rays that are not horizontal and evenly spaced.
    """
    is_level = isinstance(model, LidarModel) and model.lowest_rad == model.highest_rad == 0.0
    if not is_level or model.beams != 1 or model.angle_sigma_rad:
        raise ConfigError('only a planar sensor reports LaserScans; choose --sensor planar')
    assert isinstance(model, LidarModel)
    return model


def laser_readings(scan: SimulatedScan, model: LidarModel) -> LaserReadings:
    """
    Return the ranges of all rays of a sweep; rays without a return are infinite.

    Parameters
    ----------
    scan : SimulatedScan
        A sweep of ``model``, with times relative to its start.
    model : LidarModel
        Planar, see :func:`check_planar`.
    """
    step_rad, step_s = 2.0 * np.pi / model.columns, model.period_s / model.columns
    assert scan.time_s is not None  # simulated scans have times
    ray = np.round(scan.time_s / step_s).astype(np.int64)
    azimuth = np.arctan2(scan.points[:, 1], scan.points[:, 0]).astype(np.float64)
    first = np.exp(1j * (azimuth - ray * step_rad)).sum() if len(ray) else 1.0
    ranges = np.full(model.columns, np.inf, dtype=np.float32)
    ranges[ray] = np.hypot(scan.points[:, 0], scan.points[:, 1])
    return LaserReadings(
        float(np.angle(first)), step_rad, step_s, model.min_range_m, model.max_range_m, ranges
    )
