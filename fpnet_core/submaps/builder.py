# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stateful builder that turns scans into submaps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry import SE2
from fpnet_core.geometry.rigid3d import checked_rigid
from fpnet_core.submaps.heights import HeightBands, HeightTracker
from fpnet_core.submaps.raster import CountRaster
from fpnet_core.submaps.recent import RecentReturns, is_last_seen
from fpnet_core.types import Submap

_PATH_SPACING_M = 0.1  # numerical: distance between kept robot positions

# Numerical: initial capacity for robot positions; doubled when full.
_PATH_BLOCK = 1024
# Numerical: rays whose origins are closer than this, about a cell, share one origin.
_SAME_ORIGIN_M = 0.05
# Numerical: fractional part of the golden ratio; its consecutive multiples fill [0, 1) evenly.
_GOLDEN = 0.6180339887498949


@dataclass(frozen=True, eq=False)
class Carving:
    """
    A scan ready to be carved: rays from ``begins (P, 3)`` to ``cloud (P, 3)``, sensor frame [m].

    Rays end at ``ends (P, 3)``, odom; ``is_return (P,)`` marks ends that are returns, ``is_body
    (P,)`` returns at body height according to ``bands``, which is None without rays.
    """

    pose: NDArray[np.float64]
    begins: NDArray[np.float64]
    ends: NDArray[np.float64]
    is_return: NDArray[np.bool_]
    is_body: NDArray[np.bool_]
    bands: HeightBands | None

    @property
    def body_xy(self) -> NDArray[np.float64]:
        """Returns at body height ``(P, 2)``, odom [m]."""
        return self.ends[self.is_body, :2]


class SubmapBuilder:
    """
    Accumulator of registered scans in height-banded counts that yields submaps.

    The submap frame is ``odom`` itself, which is gravity-aligned. A cell is free if rays crossed
    it at body height or above door lintels, so furniture does not hide the floor below the rays.
    It is occupied if returns at body height exceed a share of the crossings; this ratio is stable
    while the robot stands still. It is a lintel if high returns lie over free space.
    """

    def __init__(self, config: SubmapConfig | None = None) -> None:
        self._config = config or SubmapConfig()
        self.reset()

    def reset(self) -> None:
        """Clear all state; the next submap has id 1 again."""
        self._raster = CountRaster(self._config)
        self._heights = HeightTracker(self._config)
        self._recent = RecentReturns()
        self._path = np.zeros((_PATH_BLOCK, 2), dtype=np.float64)
        self._path_length = 0
        self._scans = 0
        self._handed_out = 0
        self._id = 0
        self._stamp_ns = 0

    def add_scan(
        self,
        points: ArrayLike,
        T_odom_sensor: ArrayLike,
        stamp_ns: int,
        viewpoints: ArrayLike | None = None,
    ) -> None:
        """
        Carve one scan into the raster; state is unchanged when an error is raised.

        Combines :meth:`look` and :meth:`add`.

        Parameters
        ----------
        points : (P, 3) float32, sensor frame [m]; an empty scan only extends the robot's path
        T_odom_sensor : (4, 4), rigid; tilt is allowed
        stamp_ns : sensor time
        viewpoints : (P, 3), origin of each ray, sensor frame [m]; None: the frame's origin

        Raises
        ------
        CloudFormatError
            If a shape is wrong or a coordinate is not finite.
        OdometryError
            If the pose is not a rigid transform or is implausibly far from the start.
        """
        self.add(self.look(points, T_odom_sensor, viewpoints), stamp_ns)

    def look(
        self, points: ArrayLike, T_odom_sensor: ArrayLike, viewpoints: ArrayLike | None = None
    ) -> Carving:
        """Prepare a scan as in :meth:`add_scan`, without adding it to the submap."""
        cloud = _checked_points(points)
        begins = np.zeros_like(cloud) if viewpoints is None else _checked_points(viewpoints)
        if begins.shape != cloud.shape:
            raise CloudFormatError(f'scan: {len(cloud)} points but {len(begins)} viewpoints')
        pose = checked_rigid(T_odom_sensor)
        chosen = self._subsample(cloud if viewpoints is None else cloud - begins)
        cloud, begins = cloud[chosen], begins[chosen]
        ends, is_return = self._ray_ends(cloud, begins, pose)
        if not len(chosen):
            return Carving(pose, begins, ends, is_return, is_return, None)
        heights = cloud @ pose[2, :3] + pose[2, 3]
        bands = self._heights.update(cloud - begins, heights, float(pose[2, 3]))
        is_body = is_return & (heights >= bands.body_low) & (heights <= bands.body_high)
        return Carving(pose, begins, ends, is_return, is_body, bands)

    def add(self, scan: Carving, stamp_ns: int) -> None:
        """Carve a scan prepared by :meth:`look`, measured at ``stamp_ns``."""
        if scan.bands is not None:
            self._carve(scan, scan.bands)
        self._extend_path(scan.pose[:2, 3])
        self._scans += 1
        self._stamp_ns = int(stamp_ns)

    @property
    def recent_xy(self) -> NDArray[np.float64]:
        """Returns at body height over the last two metres ``(P, 2)``, odom [m]."""
        return self._recent.unbent

    def take(self) -> Submap | None:
        """Return the submap of all scans; None without a new scan since the last call."""
        if self._scans == self._handed_out:
            return None
        self._handed_out = self._scans
        seen = self._raster.read()
        if seen is None:
            return None
        grid, lintel = seen
        self._id += 1
        path = self._path[: self._path_length]
        return Submap(
            grid,
            lintel,
            path,
            SE2.identity(),
            self._stamp_ns,
            self._id,
            self._recent.points(),
            self._recent.newest(),
            self._recent.newest_walls(),
        )

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return copies of all arrays that :meth:`restored` needs to continue."""
        return {
            **self._raster.arrays(),
            **self._heights.arrays(),
            'path': self._path[: self._path_length].copy(),
            'scans': np.array([self._scans, self._id, self._stamp_ns], dtype=np.int64),
        }

    @classmethod
    def restored(cls, config: SubmapConfig, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """
        Return a builder that continues from :meth:`arrays`; its next ``take`` returns the submap.

        Raises
        ------
        KeyError, ValueError
            If an array is missing or has another shape or type.
        OdometryError
            If the submap exceeds ``MAX_EXTENT_M``.
        """
        builder, path = cls(config), np.array(arrays['path'], dtype=np.float64)
        if path.ndim != 2 or path.shape[1] != 2 or not np.isfinite(path).all():
            raise ValueError(f'path: expected finite (S, 2), got {path.shape}')
        if (scans := arrays['scans']).shape != (3,) or scans.dtype != np.int64:
            raise ValueError(f'scans: expected (3,) int64, got {scans.shape} {scans.dtype}')
        builder._raster = CountRaster.restored(config, arrays['counts'], arrays['corner'])
        builder._heights = HeightTracker.restored(config, arrays['histogram'], arrays['heights_m'])
        builder._path = np.concatenate([path, np.zeros((_PATH_BLOCK, 2))])
        builder._path_length = len(path)
        builder._scans, builder._id, builder._stamp_ns = map(int, scans)
        return builder

    def _carve(self, scan: Carving, bands: HeightBands) -> None:
        ends, pose = scan.ends, scan.pose
        origins, of_ray = _origins(scan.begins)
        origins = origins @ pose[:3, :3].T + pose[:3, 3]
        for number, origin in enumerate(origins):
            self._raster.reserve(origin, ends[of_ray == number])
        is_wall = scan.is_return.copy()
        for number, origin in enumerate(origins):
            own = of_ray == number
            self._raster.carve(origin, ends[own], scan.is_return[own], bands)
            own &= scan.is_return
            is_wall[own] = is_last_seen(ends[own, :2] - origin[:2])
        yaw = float(np.arctan2(pose[1, 0], pose[0, 0]))
        self._recent.add(scan.body_xy, is_wall[scan.is_body], pose[:2, 3], yaw)

    def _subsample(self, rays: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return indices of rays to keep: not too near, evenly sampled, varied by scan."""
        distance = np.einsum('ij,ij->i', rays, rays)
        far = np.flatnonzero(distance >= self._config.min_range_m**2)
        limit = self._config.max_rays
        if len(far) <= limit:
            return far
        # One point per stratum, at a low-discrepancy place in it: a plain stride would pick the
        # same few rings of a spinning lidar.
        place = np.mod((np.arange(limit) + self._scans * _GOLDEN**2) * _GOLDEN, 1.0)
        chosen = (np.arange(limit) + place) * (len(far) / limit)
        return np.asarray(far[np.minimum(chosen.astype(np.int64), len(far) - 1)])

    def _ray_ends(
        self,
        cloud: NDArray[np.float64],
        begins: NDArray[np.float64],
        pose: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return ray ends (P, 3) in odom, cut at the range limit, and which are returns."""
        rays = cloud - begins
        distance = np.linalg.norm(rays, axis=1)
        is_return = distance <= self._config.max_range_m
        scale = np.where(is_return, 1.0, self._config.max_range_m / np.maximum(distance, 1e-9))
        return (begins + rays * scale[:, None]) @ pose[:3, :3].T + pose[:3, 3], is_return

    def _extend_path(self, xy: NDArray[np.float64]) -> None:
        length = self._path_length
        if length and np.hypot(*(xy - self._path[length - 1])) < _PATH_SPACING_M:
            return
        if length == len(self._path):
            self._path = np.concatenate([self._path, np.zeros_like(self._path)])
        self._path[length] = xy
        self._path_length += 1


def _origins(
    begins: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the distinct ray origins (K, 3), and the index of each ray's origin (P,)."""
    places = np.round(begins / _SAME_ORIGIN_M).astype(np.int64)
    if (places == places[0]).all():
        return begins[:1], np.zeros(len(begins), dtype=np.int64)
    _, first, of_ray = np.unique(places, axis=0, return_index=True, return_inverse=True)
    return begins[first], of_ray.ravel()


def _checked_points(points: ArrayLike) -> NDArray[np.float64]:
    cloud = np.asarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise CloudFormatError(f'scan: expected points of shape (P, 3), got {cloud.shape}')
    if not np.isfinite(cloud).all():
        raise CloudFormatError('scan: holds NaN or infinite points; drop them before adding it')
    return cloud
