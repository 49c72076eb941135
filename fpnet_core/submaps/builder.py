# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The one stateful object of this package: scans in, submaps out."""

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

# Numerical: robot positions that memory is reserved for at first; doubled when they are used up.
_PATH_BLOCK = 1024
# Numerical: rays that begin nearer to one another, about a cell, begin in one place.
_SAME_ORIGIN_M = 0.05
# Numerical: fractional part of the golden ratio: consecutive multiples fill [0, 1) evenly.
_GOLDEN = 0.6180339887498949


@dataclass(frozen=True, eq=False)
class Carving:
    """
    A scan ready to be carved: rays from ``begins (P, 3)`` to ``cloud (P, 3)``, sensor frame [m].

    They end at ``ends (P, 3)``, odom, returns where ``is_return (P,)``. ``is_body (P,)`` are those
    at body height, as of ``bands``; None where there are no rays.
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

        As :meth:`look` and :meth:`add`, in one go.

        Parameters
        ----------
        points : (P, 3) float32, sensor frame [m]; zero points only move the robot's path
        T_odom_sensor : (4, 4), rigid; tilt is allowed
        stamp_ns : sensor time
        viewpoints : (P, 3), where each ray began, sensor frame [m]; None: in its origin

        Raises
        ------
        CloudFormatError
            If a shape is wrong or a coordinate is not finite.
        OdometryError
            If the pose is not a rigid transform or lies absurdly far from the start.
        """
        self.add(self.look(points, T_odom_sensor, viewpoints), stamp_ns)

    def look(
        self, points: ArrayLike, T_odom_sensor: ArrayLike, viewpoints: ArrayLike | None = None
    ) -> Carving:
        """Return what a scan sees, as of :meth:`add_scan`; the submap stays without it."""
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
        """Carve what :meth:`look` has returned, seen at ``stamp_ns``."""
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
        """Return the submap of everything so far; None where nothing came since the last one."""
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
        """Return everything that :meth:`restored` needs to go on, copied."""
        return {
            **self._raster.arrays(),
            **self._heights.arrays(),
            'path': self._path[: self._path_length].copy(),
            'scans': np.array([self._scans, self._id, self._stamp_ns], dtype=np.int64),
        }

    @classmethod
    def restored(cls, config: SubmapConfig, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """
        Return a builder that goes on where another one was; its next ``take`` has the submap.

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
        """Return which rays to keep: not the near ones, an even, changing choice of the others."""
        distance = np.einsum('ij,ij->i', rays, rays)
        far = np.flatnonzero(distance >= self._config.min_range_m**2)
        limit = self._config.max_rays
        if len(far) <= limit:
            return far
        # One point per stratum, at a low-discrepancy place in it: a plain stride would pick
        # the same few rings of a spinning lidar.
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
    """Return the few places (K, 3) where rays begin, and each ray's (P,)."""
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
