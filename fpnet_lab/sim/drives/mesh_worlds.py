# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Triangle meshes of real or modelled buildings: detection of the floor and of drivable space.

A mesh is in metres with z up. Its floor is the lowest level with a large share of the horizontal
area. A cell is free if it has floor below and nothing between threshold height and the robot's
top; it is indoors if almost all horizontal rays hit something.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
import open3d as o3d
import shapely

from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import SE2
from fpnet_core.raster.distance import clearance_of
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.submaps.raster import MAX_EXTENT_M
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.sim.buildings.meshes import TriangleMesh, horizontal_sheet, merge_meshes
from fpnet_lab.sim.lidars.lidar import add_mesh

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

CELL_M = 0.05
"""Numerical: cell edge of the raster of free space."""

SILL_M, ROBOT_TOP_M = 0.08, 1.2
"""Heights above the floor; objects below the first or above the second are passable. Chosen."""

CEILING_M = 2.8
"""Height above the floor of the ceiling added to meshes without one. Chosen."""

_SLICE_M = 0.05  # numerical: spacing of horizontal slices through the mesh
_LEVEL_M = 0.05  # numerical: height resolution of floor levels
# Chosen, not measured:
_LEVEL_SHARE = 0.3  # minimum share of the largest level's area for a floor
_FLAT_COSINE = 0.95  # cosine of the angle between normal and vertical
_CEILING_FROM_M = 2.0
_CEILING_SHARE = 0.5  # of the floor's area; with less area above, a mesh has no ceiling
_PROBE_M = 0.4  # numerical: spacing of the positions of the indoor test
_PROBE_RAYS = 32  # numerical
_PROBE_REACH_M = 40.0  # numerical
_ENCLOSED_SHARE = 0.7
_ROOMY_M = 0.3  # minimum clearance that some cell of a free region must reach


@dataclass(frozen=True, eq=False)
class MeshWorld:
    """
    A mesh with its floor at z = 0, and its free space.

    ``free (H, W)`` has row 0 at the lowest y, cells of ``CELL_M``, the corner of cell (0, 0) at
    ``origin (2,)`` [m]; only indoor cells are free.
    """

    mesh: TriangleMesh
    ceiling: TriangleMesh
    free: Mask
    origin: Array

    def floorplan(self) -> GridMap:
        """Return a map with the free space free and everything else occupied."""
        cells = np.where(self.free, FREE, OCCUPIED)
        return GridMap(cells, CELL_M, SE2.from_xy_yaw(self.origin[0], self.origin[1], 0.0))

    def to_xy(self, rc: NDArray[np.generic]) -> Array:
        """Convert raster indices (..., 2) to the positions of their cell centres [m]."""
        xy: Array = (np.asarray(rc, dtype=np.float64)[..., ::-1] + 0.5) * CELL_M + self.origin
        return xy


def read_mesh(path: Path | str) -> TriangleMesh:
    """
    Read a PLY, OBJ or STL file.

    Raises
    ------
    MapFormatError
        If the file is missing, contains no triangles, or has non-finite coordinates.
    """
    path = Path(path)
    if not path.is_file():
        raise MapFormatError(f'mesh {path} does not exist')
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        mesh = o3d.io.read_triangle_mesh(path)
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    triangles = np.asarray(mesh.triangles, dtype=np.int64)
    if not len(triangles):
        raise MapFormatError(f'{path} contains no triangles; expected a PLY, OBJ or STL mesh')
    if not np.isfinite(vertices).all():
        raise MapFormatError(f'mesh {path} has non-finite coordinates')
    return TriangleMesh(vertices, triangles)


def survey_mesh(mesh: TriangleMesh) -> MeshWorld:
    """
    Find the floor of a mesh and the indoor space accessible to a robot.

    Parameters
    ----------
    mesh : TriangleMesh
        Metres, z up.

    Raises
    ------
    MapFormatError
        If there is no floor, or no space on it is enclosed by walls.
    """
    corners = mesh.corners
    floor_z = _floor_level(corners)
    corners = corners - (0.0, 0.0, floor_z)
    low, high = corners[..., :2].min(axis=(0, 1)), corners[..., :2].max(axis=(0, 1))
    if (high - low).max() > MAX_EXTENT_M:
        raise MapFormatError(
            f'the mesh is {(high - low).max():.0f} m wide; expected metres and at most '
            f'{MAX_EXTENT_M:.0f} m'
        )
    standing = _floor_mask(corners, low, high) & ~_obstacles(corners, low, high)
    lowered = TriangleMesh(mesh.vertices - (0.0, 0.0, floor_z), mesh.triangles)
    free = _roomy(_indoors(lowered, standing, low))
    if not free.any():
        raise MapFormatError(
            'the mesh has no space enclosed by walls above a floor; expected a building in '
            'metres with z up'
        )
    return MeshWorld(lowered, _missing_ceiling(corners, low, high), free, low)


def _flat(corners: Array) -> tuple[Array, Array]:
    """Return areas [m^2] of horizontal triangles (0: others), and mean heights [m], (T,) each."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(normals, axis=1)
    is_flat = np.abs(normals[:, 2]) > _FLAT_COSINE * double_area
    return np.where(is_flat, double_area / 2.0, 0.0), corners[..., 2].mean(axis=1)


def _floor_level(corners: Array) -> float:
    area, height = _flat(corners)
    if not area.any():
        raise MapFormatError('the mesh has no horizontal surface, so no floor; expected z up')
    level = np.floor(height / _LEVEL_M).astype(np.int64)
    level -= level.min()
    areas = np.convolve(np.bincount(level, weights=area), np.ones(3), mode='same')
    lowest = int(np.flatnonzero(areas >= _LEVEL_SHARE * areas.max())[0])
    near = np.abs(level - lowest) <= 2
    return float(np.average(height[near], weights=area[near]))


def _raster(low: Array, high: Array) -> NDArray[np.uint8]:
    columns, rows = np.ceil((high - low) / CELL_M).astype(int) + 1
    return np.zeros((rows, columns), np.uint8)


def _pixels(xy: Array, low: Array) -> NDArray[np.int32]:
    return np.floor((xy - low) / CELL_M).astype(np.int32)


def _floor_mask(corners: Array, low: Array, high: Array) -> Mask:
    area, height = _flat(corners)
    mask = _raster(low, high)
    is_floor = (area > 0.0) & (np.abs(height) < SILL_M)
    for triangle in _pixels(corners[is_floor][..., :2], low):
        cv2.fillConvexPoly(mask, triangle, 1)
    return mask.astype(bool)


def _obstacles(corners: Array, low: Array, high: Array) -> Mask:
    """Return the cells with an obstacle, from horizontal slices and horizontal surfaces."""
    mask = _raster(low, high)
    for height in np.arange(SILL_M, ROBOT_TOP_M, _SLICE_M):
        for a, b in _pixels(slice_level(corners, float(height)), low):
            cv2.line(mask, a.tolist(), b.tolist(), 1)
    area, height_m = _flat(corners)
    is_shelf = (area > 0.0) & (height_m > SILL_M) & (height_m < ROBOT_TOP_M)
    for triangle in _pixels(corners[is_shelf][..., :2], low):
        cv2.fillConvexPoly(mask, triangle, 1)
    return mask.astype(bool)


def slice_level(corners: Array, height_m: float) -> Array:
    """Return line segments (S, 2, 2) [m] where triangles (T, 3, 3) cross a height."""
    above = corners[..., 2] > height_m
    crossing = corners[above.any(axis=1) & ~above.all(axis=1)]
    is_above = crossing[..., 2] > height_m
    # The corner alone on its side of the plane goes first: both of its edges cross the plane.
    alone = np.where(is_above.sum(axis=1) == 1, is_above.argmax(axis=1), is_above.argmin(axis=1))
    order = (alone[:, None] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(crossing, order[..., None], axis=1), 1, 0)
    ends = []
    for other in (b, c):
        share = (height_m - a[:, 2]) / (other[:, 2] - a[:, 2])
        ends.append(a[:, :2] + share[:, None] * (other[:, :2] - a[:, :2]))
    return np.stack(ends, axis=1)


def _indoors(mesh: TriangleMesh, standing: Mask, origin: Array) -> Mask:
    """Return ``standing`` where almost all horizontal rays at ``ROBOT_TOP_M`` hit something."""
    scene = o3d.t.geometry.RaycastingScene()
    add_mesh(scene, mesh)
    step = round(_PROBE_M / CELL_M)
    probes = np.argwhere(np.ones_like(standing[::step, ::step])) * step
    xy = (probes[:, ::-1] + 0.5) * CELL_M + origin
    bearing = np.arange(_PROBE_RAYS) * (2.0 * np.pi / _PROBE_RAYS)
    rays = np.zeros((len(xy), _PROBE_RAYS, 6), dtype=np.float32)
    rays[..., :2] = xy[:, None]
    rays[..., 2] = ROBOT_TOP_M
    rays[..., 3], rays[..., 4] = np.cos(bearing), np.sin(bearing)
    depth = scene.cast_rays(o3d.core.Tensor.from_numpy(rays))['t_hit'].numpy()
    enclosed = (depth < _PROBE_REACH_M).mean(axis=1) >= _ENCLOSED_SHARE
    coarse = enclosed.reshape(standing[::step, ::step].shape).astype(np.uint8)
    # The median filter closes gaps in the mesh and removes isolated false positives outside.
    coarse = cv2.medianBlur(coarse, 5)
    fine = cv2.resize(coarse, standing.shape[::-1], interpolation=cv2.INTER_NEAREST)
    return np.asarray(standing & (fine > 0))


def _roomy(free: Mask) -> Mask:
    """Remove regions that are narrow everywhere, like the inside of hollow walls."""
    parts, stats = pieces_of(free, connectivity=4)
    wide = (clearance_of(free) * CELL_M > _ROOMY_M) & free
    is_wide = np.zeros(len(stats), dtype=bool)
    is_wide[parts[wide]] = True
    return np.asarray(is_wide[parts])


def _missing_ceiling(corners: Array, low: Array, high: Array) -> TriangleMesh:
    """Return a ceiling over the whole mesh, or an empty mesh if it has its own ceiling."""
    area, height = _flat(corners)
    floor_m2 = area[np.abs(height) < SILL_M].sum()
    if area[height > _CEILING_FROM_M].sum() > _CEILING_SHARE * floor_m2:
        return merge_meshes([])
    return horizontal_sheet(shapely.box(*low, *high), CEILING_M, faces_up=False)
