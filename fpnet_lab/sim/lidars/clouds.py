# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Finished point clouds of simulated buildings: tripod laser scans, and mobile robot maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import shapely

from fpnet_lab.sim.buildings.building import Building
from fpnet_lab.sim.lidars.lidar import LidarSimulator
from fpnet_lab.sim.lidars.sensors import SENSORS, LidarModel, SensorModel

Array = NDArray[np.float64]

_CLEAR_M = 0.5  # chosen: minimum distance of stations from walls
_CHUNK = 64  # numerical: number of stations between two downsamplings


@dataclass(frozen=True)
class Survey:
    """
    Parameters of a point cloud survey.

    ``sensor`` is ``height_m`` above the floor, at stations ``spacing_m`` apart. Its points get
    noise of ``noise_m`` in every direction; one point per voxel of ``cube_m`` is kept.
    """

    sensor: SensorModel
    height_m: float
    spacing_m: float
    noise_m: float
    cube_m: float


SURVEYS: dict[str, Survey] = {
    'terrestrial': Survey(
        LidarModel(
            beams=300, columns=1200, lowest_rad=float(np.deg2rad(-60.0)),
            highest_rad=float(np.deg2rad(89.0)), range_sigma_m=0.003, angle_sigma_rad=0.0,
        ), 1.6, 5.0, 0.0, 0.025,
    ),
    'slam': Survey(SENSORS['beams64'], 0.9, 1.5, 0.02, 0.05),
}  # fmt: skip
"""A tripod scanner with a station every few metres; a robot's noisy map. Chosen."""


def surveyed_cloud(
    building: Building, survey: Survey, rng: np.random.Generator, threads: int = 0
) -> NDArray[np.float32]:
    """Return the points (P, 3) of a survey from :func:`stations`, frame ``building`` [m]."""
    lidar = LidarSimulator(building, survey.sensor, threads)
    kept: list[NDArray[np.float32]] = []
    for xy in stations(building, survey.spacing_m):
        kept.append(_sweep_at(lidar, np.append(xy, survey.height_m), survey, rng))
        if len(kept) >= _CHUNK:
            kept = [thinned_cloud(np.concatenate(kept), survey.cube_m)]
    return thinned_cloud(np.concatenate(kept), survey.cube_m)


def _sweep_at(
    lidar: LidarSimulator, place: Array, survey: Survey, rng: np.random.Generator
) -> NDArray[np.float32]:
    columns = survey.sensor.columns
    yaw = rng.uniform(-np.pi, np.pi)
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    origin = np.broadcast_to(place, (columns, 3))
    sweep = lidar.sweep(np.broadcast_to(R, (columns, 3, 3)), origin, rng.uniform(0.0, 9.0), rng)
    noise = rng.normal(0.0, survey.noise_m, sweep.points.shape)
    return np.asarray(sweep.points @ R.T + place + noise, dtype=np.float32)


def stations(building: Building, spacing_m: float) -> Array:
    """Return stations (S, 2) clear of walls and furniture, at least one per room if possible."""
    taken = shapely.union_all([piece.footprint for piece in building.furniture])
    places: list[Array] = []
    for outline in building.plan.outlines:
        clear = shapely.difference(shapely.buffer(outline, -_CLEAR_M), taken)
        if clear.is_empty:
            places.append(shapely.get_coordinates(outline.representative_point()))
            continue
        low, high = np.array(clear.bounds).reshape(2, 2)
        axes = [np.arange(a + 0.5 * min(spacing_m, b - a), b, spacing_m) for a, b in
                zip(low, high, strict=True)]  # fmt: skip
        grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        inside = grid[shapely.contains_xy(clear, grid[:, 0], grid[:, 1])]
        if not len(inside):
            inside = shapely.get_coordinates(clear.representative_point())
        places.append(inside)
    return np.concatenate(places)


def thinned_cloud(points: NDArray[np.float32], cube_m: float) -> NDArray[np.float32]:
    """Return the first of ``points (P, 3)`` in each voxel of edge ``cube_m``."""
    cubes = np.floor(points / cube_m).astype(np.int64)
    cubes -= cubes.min(axis=0)
    size = cubes.max(axis=0) + 1
    key = (cubes[:, 0] * size[1] + cubes[:, 1]) * size[2] + cubes[:, 2]
    _, first = np.unique(key, return_index=True)
    return points[np.sort(first)]
