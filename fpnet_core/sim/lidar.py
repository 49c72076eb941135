# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A spinning multi-beam lidar, ray-cast in a building with Open3D.

All beams of a column fire at one instant while the sensor turns and moves, so every column has a
pose of its own and the points of a sweep are distorted by the motion as a real sensor's are.
Beams are neither perfectly straight nor perfectly regular: without jitter the rings of points
would travel with the robot, and scan matching would lock on the rings instead of the walls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import open3d as o3d

from fpnet_core.sim.building import Building

Array = NDArray[np.float64]

REFLECTIVITY = (0.7, 0.45, 0.35)
"""Share of light that walls, shell (floor and ceiling) and contents return, in parts' order."""

_FULL_INTENSITY = 255.0
_GRAZING_COSINE = 0.02  # cosine of incidence at which half of the returns get lost


@dataclass(frozen=True)
class LidarModel:
    """
    A lidar's geometry and errors; the default resembles a common 32-beam sensor.

    Parameters
    ----------
    beams : int
        Number of rings, ring 0 lowest, spread evenly over the field of view.
    lowest_rad, highest_rad : float
        Elevation of the first and the last beam [rad].
    columns : int
        Azimuth steps of a sweep, counter-clockwise seen from above.
    period_s : float
        Duration of a sweep [s].
    min_range_m, max_range_m : float
        Returns outside are not reported [m].
    range_sigma_m : float
        Standard deviation of the measured range [m].
    angle_sigma_rad : float
        Standard deviation of every ray's azimuth and elevation around the regular pattern; the
        sensor's calibration knows it, so points are reported where the ray went [rad].
    dropout : float
        Share of returns that get lost whatever they hit.
    """

    beams: int = 32
    lowest_rad: float = float(np.deg2rad(-22.5))
    highest_rad: float = float(np.deg2rad(22.5))
    columns: int = 720
    period_s: float = 0.1
    min_range_m: float = 0.3
    max_range_m: float = 60.0
    range_sigma_m: float = 0.015
    angle_sigma_rad: float = float(np.deg2rad(0.1))
    dropout: float = 0.01

    @property
    def column_times_s(self) -> Array:
        """Time ``(C,)`` at which each column fires, from the start of the sweep [s]."""
        return np.arange(self.columns, dtype=np.float64) * (self.period_s / self.columns)


@dataclass(frozen=True, eq=False)
class Sweep:
    """
    One turn of the sensor, in the order of firing.

    ``points (P, 3) float32`` [m] are relative to the sensor at the instant of each point;
    ``time_s (P,) float64`` counts from the start of the sweep; ``intensity (P,) float32`` is in
    [0, 255]; ``ring (P,) uint16``. P may be 0 where nothing returns.
    """

    points: NDArray[np.float32]
    time_s: Array
    intensity: NDArray[np.float32]
    ring: NDArray[np.uint16]


class LidarSimulator:
    """
    Casts sweeps in one building.

    Parameters
    ----------
    building : Building
    model : LidarModel
    threads : int
        Threads for ray casting; the result does not depend on it. 0 takes all cores.
    """

    def __init__(
        self, building: Building, model: LidarModel | None = None, threads: int = 0
    ) -> None:
        self.model = model or LidarModel()
        self._threads = threads
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=threads)
        # The scene numbers geometries in the order of adding; empty ones keep their number.
        self._reflectivity = np.zeros(len(building.parts), dtype=np.float32)
        for mesh, share in zip(building.parts, REFLECTIVITY, strict=True):
            if len(mesh.triangles):
                index = self._scene.add_triangles(
                    o3d.core.Tensor.from_numpy(mesh.vertices.astype(np.float32)),
                    o3d.core.Tensor.from_numpy(mesh.triangles.astype(np.uint32)),
                )
                self._reflectivity[index] = share
        self._elevations = np.linspace(
            self.model.lowest_rad, self.model.highest_rad, self.model.beams, dtype=np.float32
        )

    def sweep(self, R: Array, origin: Array, rng: np.random.Generator) -> Sweep:
        """
        Cast one sweep.

        Parameters
        ----------
        R : (C, 3, 3)
            Rotation building <- sensor at each column's instant.
        origin : (C, 3)
            Position of the sensor in the building at each column's instant [m].
        rng : numpy.random.Generator
            Draws jitter, noise and dropouts.
        """
        directions = self._directions(rng)
        rays = np.empty((*directions.shape[:2], 6), dtype=np.float32)
        rays[..., :3] = origin[:, None, :]
        rays[..., 3:] = directions @ R.astype(np.float32).transpose(0, 2, 1)
        hits = self._scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=self._threads)
        depth = hits['t_hit'].numpy()
        normals = hits['primitive_normals'].numpy()
        cosine = np.abs(np.einsum('cbi,cbi->cb', normals, rays[..., 3:]))
        measured, is_hit = self._measure(depth, cosine, rng)
        column, ring = np.nonzero(is_hit)
        share = self._reflectivity[hits['geometry_ids'].numpy()[is_hit]]
        return Sweep(
            points=(directions * measured[..., None])[is_hit],
            time_s=self.model.column_times_s[column],
            intensity=_FULL_INTENSITY * share * cosine[is_hit],
            ring=ring.astype(np.uint16),
        )

    def _directions(self, rng: np.random.Generator) -> NDArray[np.float32]:
        """Return unit ray directions ``(C, B, 3)`` in the sensor frame."""
        columns, beams = self.model.columns, self.model.beams
        sigma = np.float32(self.model.angle_sigma_rad)
        noise = sigma * rng.standard_normal((2, columns, beams), dtype=np.float32)
        phase = rng.random()  # the encoder is not synchronised with the sweep
        steps = (np.arange(columns) + phase) * (2.0 * np.pi / columns)
        azimuth = steps.astype(np.float32)[:, None] + noise[0]
        elevation = self._elevations + noise[1]
        level = np.cos(elevation)
        return np.stack(
            [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1
        )

    def _measure(
        self, depth: NDArray[np.float32], cosine: NDArray[np.float32], rng: np.random.Generator
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Return noisy ranges ``(C, B)`` [m] and which of them the sensor reports."""
        model = self.model
        noise = rng.standard_normal(depth.shape, dtype=np.float32)
        measured = depth + np.float32(model.range_sigma_m) * noise
        survival = (1.0 - model.dropout) * cosine / (cosine + np.float32(_GRAZING_COSINE))
        is_returned = rng.random(depth.shape, dtype=np.float32) < survival
        in_range = (measured > model.min_range_m) & (measured < model.max_range_m)
        return measured, is_returned & in_range
