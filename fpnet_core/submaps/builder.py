# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The one stateful object of this package: scans in, submaps out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import CloudFormatError, OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.submaps.carving import CROSSED, HIGH_HIT, LAYERS, MID_HIT, carve_rays
from fpnet_core.submaps.heights import HeightTracker
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap

# The raster grows by whole margins, so that growth is rare [cells].
_MARGIN_CELLS = 128
# Fractional part of the golden ratio: consecutive multiples fill [0, 1) evenly.
_GOLDEN = 0.6180339887498949
# Deviation of R^T R from the identity that a rigid transform may have.
_RIGID_TOLERANCE = 1e-3


class SubmapBuilder:
    """
    Accumulates registered scans into height-banded counts and hands out submaps.

    The submap frame is ``odom`` itself, which is gravity-aligned. A cell is free where rays
    crossed it at body height or above the door's lintel, so that furniture does not hide the
    floor below the crossing rays; occupied where returns at body height outnumber a share of
    the crossings, which does not drift while the robot stands still; a lintel where high
    returns lie over free space.
    """

    def __init__(self, config: SubmapConfig | None = None) -> None:
        self._config = config or SubmapConfig()
        self.reset()

    def reset(self) -> None:
        """Forget everything; the next submap has id 1 again."""
        self._counts = np.zeros((0, 0, LAYERS), dtype=np.uint16)
        self._corner = np.zeros(2, dtype=np.int64)
        self._heights = HeightTracker(self._config)
        self._path: list[NDArray[np.float64]] = []
        self._scans = 0
        self._handed_out = 0
        self._id = 0
        self._stamp_ns = 0

    def add_scan(self, points: ArrayLike, T_odom_sensor: ArrayLike, stamp_ns: int) -> None:
        """
        Carve one scan into the raster; state is unchanged when an error is raised.

        Parameters
        ----------
        points : (P, 3) float32, sensor frame [m]; zero points only move the robot's path
        T_odom_sensor : (4, 4), rigid; tilt is allowed
        stamp_ns : sensor time

        Raises
        ------
        CloudFormatError
            If the shape is wrong or a coordinate is not finite.
        OdometryError
            If the pose is not a rigid transform or lies absurdly far from the start.
        """
        cloud = _checked_points(points)
        pose = _checked_pose(T_odom_sensor)
        rays = self._subsample(cloud)
        ends, is_return = self._ray_ends(rays, pose)
        resolution = self._config.resolution_m
        origin = pose[:3, 3] / np.array([resolution, resolution, 1.0])
        cells = ends / np.array([resolution, resolution, 1.0])
        self._cover(np.vstack([cells[:, :2], origin[:2]]))
        if len(rays):
            heights = rays @ pose[2, :3] + pose[2, 3]
            bands = self._heights.update(rays, heights, float(pose[2, 3]))
            shift = np.array([self._corner[0], self._corner[1], 0.0])
            limits = (
                bands.body_low,
                bands.body_high,
                bands.high_low,
                bands.high_high,
                bands.ceiling,
            )
            carve_rays(
                self._counts,
                origin - shift,
                cells - shift,
                is_return,
                limits,
                self._config.end_margin_m / resolution,
            )
        self._extend_path(pose[:2, 3])
        self._scans += 1
        self._stamp_ns = int(stamp_ns)

    def take(self) -> Submap | None:
        """Return the submap of everything so far; None where nothing came since the last one."""
        if self._scans == self._handed_out or not self._counts.any():
            return None
        self._handed_out = self._scans
        self._id += 1
        rows = np.flatnonzero(self._counts.any(axis=(1, 2)))
        cols = np.flatnonzero(self._counts.any(axis=(0, 2)))
        window = np.s_[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
        corner = (self._corner + np.array([cols[0], rows[0]])) * self._config.resolution_m
        cells, lintel = self._classify(self._counts[window])
        grid = GridMap(
            cells,
            self._config.resolution_m,
            SE2.from_xy_yaw(float(corner[0]), float(corner[1]), 0.0),
            'submap',
        )
        return Submap(
            grid,
            lintel,
            np.array(self._path).reshape(-1, 2),
            SE2.identity(),
            self._stamp_ns,
            self._id,
        )

    def _classify(self, counts: NDArray[np.uint16]) -> tuple[NDArray[np.int8], NDArray[np.bool_]]:
        """Turn counts (H, W, LAYERS) into cell values and the lintel mask."""
        crossed = counts[..., CROSSED].astype(np.float32)
        mid = counts[..., MID_HIT].astype(np.float32)
        wall = (mid > 0) & (mid >= self._config.wall_share * (mid + crossed))
        free = (crossed > 0) & ~wall
        cells = np.full(wall.shape, UNKNOWN, dtype=np.int8)
        cells[free] = FREE
        cells[wall] = OCCUPIED
        return cells, free & (counts[..., HIGH_HIT] >= self._config.lintel_min_hits)

    def _subsample(self, cloud: NDArray[np.float64]) -> NDArray[np.float64]:
        """Drop near returns and keep an evenly spread, changing choice of ``max_rays``."""
        distance = np.einsum('ij,ij->i', cloud, cloud)
        cloud = np.asarray(cloud[distance >= self._config.min_range_m**2])
        limit = self._config.max_rays
        if len(cloud) <= limit:
            return cloud
        # One point per stratum, at a low-discrepancy place in it: a plain stride would pick
        # the same few rings of a spinning lidar.
        place = np.mod((np.arange(limit) + self._scans * _GOLDEN**2) * _GOLDEN, 1.0)
        chosen = (np.arange(limit) + place) * (len(cloud) / limit)
        return np.asarray(cloud[np.minimum(chosen.astype(np.int64), len(cloud) - 1)])

    def _ray_ends(
        self, rays: NDArray[np.float64], pose: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return ray ends (P, 3) in odom, cut at the range limit, and which are returns."""
        distance = np.linalg.norm(rays, axis=1)
        is_return = distance <= self._config.max_range_m
        scale = np.where(is_return, 1.0, self._config.max_range_m / np.maximum(distance, 1e-9))
        return (rays * scale[:, None]) @ pose[:3, :3].T + pose[:3, 3], is_return

    def _cover(self, cells: NDArray[np.float64]) -> None:
        """Grow the raster until it holds ``cells (P, 2)`` [column, row]."""
        low = np.floor(cells.min(axis=0)).astype(np.int64)
        high = np.floor(cells.max(axis=0)).astype(np.int64) + 1
        shape = np.array(self._counts.shape[1::-1])
        if shape.all():
            end = self._corner + shape
            if (low >= self._corner).all() and (high <= end).all():
                return
            new_low = np.where(low < self._corner, low - _MARGIN_CELLS, self._corner)
            new_high = np.where(high > end, high + _MARGIN_CELLS, end)
        else:
            new_low, new_high = low - _MARGIN_CELLS, high + _MARGIN_CELLS
        self._check_extent(new_high - new_low)
        grown = np.zeros((*(new_high - new_low)[::-1], LAYERS), dtype=np.uint16)
        at = self._corner - new_low
        if shape.all():
            grown[at[1] : at[1] + shape[1], at[0] : at[0] + shape[0]] = self._counts
        self._counts, self._corner = grown, new_low

    def _check_extent(self, size: NDArray[np.int64]) -> None:
        extent_m = float(size.max()) * self._config.resolution_m
        if extent_m > self._config.max_extent_m:
            raise OdometryError(
                f'the submap would be {extent_m:.0f} m long, limit '
                f'{self._config.max_extent_m:.0f} m (submap.max_extent_m): the odometry has '
                'probably diverged; restart it and reset the submap'
            )

    def _extend_path(self, xy: NDArray[np.float64]) -> None:
        if not self._path or np.hypot(*(xy - self._path[-1])) >= self._config.path_spacing_m:
            self._path.append(xy.copy())


def _checked_points(points: ArrayLike) -> NDArray[np.float64]:
    cloud = np.asarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise CloudFormatError(f'scan: expected points of shape (P, 3), got {cloud.shape}')
    if not np.isfinite(cloud).all():
        raise CloudFormatError('scan: holds NaN or infinite points; drop them before adding it')
    return cloud


def _checked_pose(T_odom_sensor: ArrayLike) -> NDArray[np.float64]:
    pose = np.asarray(T_odom_sensor, dtype=np.float64)
    if pose.shape != (4, 4):
        raise OdometryError(f'sensor pose: expected shape (4, 4), got {pose.shape}')
    R = pose[:3, :3]
    rigid = (
        np.isfinite(pose).all()
        and np.abs(R.T @ R - np.eye(3)).max() < _RIGID_TOLERANCE
        and np.linalg.det(R) > 0.0
        and np.abs(pose[3] - [0.0, 0.0, 0.0, 1.0]).max() < _RIGID_TOLERANCE
    )
    if not rigid:
        raise OdometryError(f'sensor pose is not a rigid transform: {pose.tolist()}')
    return pose
