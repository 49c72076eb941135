# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Lidar simulation by ray casting in a building with Open3D.

All beams of a column fire at one instant while the sensor turns and moves. Every column therefore
has its own pose, and motion distorts a sweep like that of a real sensor. Beam directions have
jitter: without it, the rings of points would move with the robot, and scan matching would lock
onto the rings instead of the walls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import open3d as o3d

from fpnet_lab.sim.buildings.building import Building
from fpnet_lab.sim.buildings.meshes import TriangleMesh
from fpnet_lab.sim.lidars.sensors import SENSORS, LidarModel, SensorModel

__all__ = ['SENSORS', 'LidarModel', 'LidarSimulator', 'SensorModel', 'Sweep']

Array = NDArray[np.float64]

REFLECTIVITY = (0.7, 0.45, 0.35)
"""
Reflectivity of walls, shell (floor and ceiling) and contents, in the order of ``parts``. Chosen.
"""

# Chosen, not measured:
_GLASS_REFLECTIVITY = 0.1
_MIRROR_COSINE = 0.98  # cosine of incidence above which most rays return from glass
_FACING_RETURNS, _OBLIQUE_RETURNS = 0.7, 0.02

# Chosen, not measured:
_FULL_INTENSITY = 255.0
_GRAZING_COSINE = 0.02  # cosine of incidence at which half of the returns are lost


@dataclass(frozen=True, eq=False)
class Sweep:
    """
    One sweep of the sensor, in firing order.

    ``points (P, 3) float32`` [m] are relative to the sensor at the instant of each point;
    ``time_s (P,) float64`` is relative to the start of the sweep; ``intensity (P,) float32`` is
    in [0, 255]; ``ring (P,) uint16``. P is 0 if nothing returns.
    """

    points: NDArray[np.float32]
    time_s: Array
    intensity: NDArray[np.float32]
    ring: NDArray[np.uint16]


class LidarSimulator:
    """
    A lidar that casts sweeps in one building.

    Parameters
    ----------
    building : Building
    model : SensorModel
        Default: a spinning lidar with 32 beams.
    threads : int
        Threads for ray casting; the result does not depend on it. 0 uses all cores.
    """

    def __init__(
        self, building: Building, model: SensorModel | None = None, threads: int = 0
    ) -> None:
        self.model = model or LidarModel()
        self._threads = threads
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=threads)
        # The scene numbers geometries in the order in which they are added.
        shares = [
            share
            for mesh, share in zip(building.parts, REFLECTIVITY, strict=True)
            if add_mesh(self._scene, mesh)
        ]
        self._reflectivity = np.array([*shares, _GLASS_REFLECTIVITY], dtype=np.float32)
        self._glass: o3d.t.geometry.RaycastingScene | None = None
        if len(building.glass.triangles):
            self._glass = o3d.t.geometry.RaycastingScene(nthreads=threads)
            add_mesh(self._glass, building.glass)

    def sweep(self, R: Array, origin: Array, start_s: float, rng: np.random.Generator) -> Sweep:
        """
        Cast one sweep.

        Parameters
        ----------
        R : (C, 3, 3)
            Rotation from sensor to building at each column's instant.
        origin : (C, 3)
            Position of the sensor in the building at each column's instant [m].
        start_s : float
            Sensor clock at the start of the sweep [s].
        rng : numpy.random.Generator
            Random generator of jitter, noise and dropouts.
        """
        directions = self.model.directions(start_s, rng)
        rays = np.empty((*directions.shape[:2], 6), dtype=np.float32)
        rays[..., :3] = origin[:, None, :]
        rays[..., 3:] = directions @ R.astype(np.float32).transpose(0, 2, 1)
        depth, normals, part = self._cast(rays, rng)
        cosine = np.abs(np.einsum('cbi,cbi->cb', normals, rays[..., 3:]))
        measured, is_hit = self._measure(depth, cosine, rng)
        column, ring = np.nonzero(is_hit)
        return Sweep(
            points=directions[is_hit] * measured[is_hit][:, None],
            time_s=self.model.column_times_s[column],
            intensity=_FULL_INTENSITY * self._reflectivity[part[is_hit]] * cosine[is_hit],
            ring=ring.astype(np.uint16),
        )

    def _cast(
        self, rays: NDArray[np.float32], rng: np.random.Generator
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int64]]:
        """Return depths (C, B) [m], normals (C, B, 3) and parts (C, B) hit by rays (C, B, 6)."""
        tensor = o3d.core.Tensor.from_numpy(rays)
        hits = self._scene.cast_rays(tensor, nthreads=self._threads)
        depth, normals = hits['t_hit'].numpy(), hits['primitive_normals'].numpy()
        part = hits['geometry_ids'].numpy().astype(np.int64)
        if self._glass is not None:
            panes = self._glass.cast_rays(tensor, nthreads=self._threads)
            pane_depth, pane_normals = panes['t_hit'].numpy(), panes['primitive_normals'].numpy()
            cosine = np.abs(np.einsum('cbi,cbi->cb', pane_normals, rays[..., 3:]))
            share = np.where(cosine > _MIRROR_COSINE, _FACING_RETURNS, _OBLIQUE_RETURNS)
            is_seen = (pane_depth < depth) & (rng.random(depth.shape) < share)
            depth = np.where(is_seen, pane_depth, depth)
            normals = np.where(is_seen[..., None], pane_normals, normals)
            part = np.where(is_seen, len(self._reflectivity) - 1, part)
        return depth, normals, part

    def _measure(
        self, depth: NDArray[np.float32], cosine: NDArray[np.float32], rng: np.random.Generator
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Return noisy ranges ``(C, B)`` [m] and a mask of those that the sensor reports."""
        model = self.model
        noise = rng.standard_normal(depth.shape, dtype=np.float32)
        measured = depth + np.float32(model.range_sigma_m) * noise
        survival = (1.0 - model.dropout) * cosine / (cosine + np.float32(_GRAZING_COSINE))
        is_returned = rng.random(depth.shape, dtype=np.float32) < survival
        in_range = (measured > model.min_range_m) & (measured < model.max_range_m)
        return measured, is_returned & in_range


def add_mesh(scene: o3d.t.geometry.RaycastingScene, mesh: TriangleMesh) -> bool:
    """Add a mesh to a scene unless it is empty; return whether it was added."""
    if not len(mesh.triangles):
        return False
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(mesh.vertices.astype(np.float32)),
        o3d.core.Tensor.from_numpy(mesh.triangles.astype(np.uint32)),
    )
    return True
