# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Raster of ray counts that grows on demand and reclassifies only changed cells."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import OdometryError
from fpnet_core.geometry import SE2
from fpnet_core.submaps.carving import LAYERS, carve_rays, classify
from fpnet_core.submaps.heights import HeightBands
from fpnet_core.types import UNKNOWN, GridMap

# High returns that make a lintel cell; fitted to development recordings (notes/submaps.md).
LINTEL_MIN_HITS = 2
# Least share of returns among rays at its height in a lintel; fitted to development recordings
# (notes/submaps.md).
LINTEL_SHARE = 0.5
# Least share of returns among returns and crossings in a wall; fitted to development recordings
# (notes/submaps.md).
WALL_SHARE = 0.2
# Last stretch before a return that proves no free space; fitted to development recordings
# (notes/submaps.md).
END_MARGIN_M = 0.2
MAX_EXTENT_M = 400.0  # physical: no storey is longer; the odometry has diverged

# Numerical: margin by which the raster grows, so that growth is rare [cells].
_MARGIN_CELLS = 128


class CountRaster:
    """
    Counts of crossings and returns per cell, and the cell values derived from them.

    Memory covers the bounding box of everything in range of the path; ``MAX_EXTENT_M`` limits it.
    Callers cut rays at ``max_range_m``, so outliers do not enlarge the box.
    """

    def __init__(self, config: SubmapConfig) -> None:
        self._config = config
        self._counts = np.zeros((0, 0, LAYERS), dtype=np.uint16)
        self._cells = np.zeros((0, 0), dtype=np.int8)
        self._lintel = np.zeros((0, 0), dtype=np.bool_)
        self._corner = np.zeros(2, dtype=np.int64)  # column, row of cell (0, 0) in odom
        self._seen = _Box()
        self._changed = _Box()
        self._is_marked = False

    def reserve(self, origin: NDArray[np.float64], ends: NDArray[np.float64]) -> None:
        """
        Make room for rays from ``origin (3,)`` to ``ends (P, 3)``, odom [m], P >= 1.

        Raises
        ------
        OdometryError
            If the raster would exceed ``MAX_EXTENT_M``; the state is unchanged.
        """
        corners = np.stack([ends.min(axis=0), ends.max(axis=0), origin])[:, :2]
        cells = np.floor(corners / self._config.resolution_m).astype(np.int64)
        low, high = cells.min(axis=0), cells.max(axis=0) + 1
        self._cover(low, high)
        self._seen.add(low, high)
        self._changed.add(low, high)

    def carve(
        self,
        origin: NDArray[np.float64],
        ends: NDArray[np.float64],
        is_return: NDArray[np.bool_],
        bands: HeightBands,
    ) -> None:
        """
        Count rays after :meth:`reserve` has made room for them.

        ``is_return (P,)`` is False for rays cut at the maximum range; ``bands`` are the heights
        that classify rays and returns.
        """
        resolution = self._config.resolution_m
        scale = np.array([resolution, resolution, 1.0])
        shift = np.array([self._corner[0], self._corner[1], 0.0])
        margin = END_MARGIN_M / resolution
        carve_rays(
            self._counts,
            origin / scale - shift,
            ends / scale - shift,
            is_return,
            bands.limits,
            margin,
        )

    def read(self) -> tuple[GridMap, NDArray[np.bool_]] | None:
        """Return the grid of everything seen and its lintel mask; None before the first count."""
        if not self._changed.is_empty:
            window = self._changed.window(self._corner)
            self._is_marked |= classify(
                self._counts[window],
                self._cells[window],
                self._lintel[window],
                WALL_SHARE,
                LINTEL_SHARE,
                LINTEL_MIN_HITS,
            )
            self._changed = _Box()
        if not self._is_marked:
            return None
        window = self._seen.window(self._corner)
        x, y = (self._seen.low * self._config.resolution_m).tolist()
        grid = GridMap(
            self._cells[window], self._config.resolution_m, SE2.from_xy_yaw(x, y, 0.0), 'submap'
        )
        return grid, self._lintel[window]

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return counts ``(H, W, LAYERS)`` of everything seen and their corner [column, row]."""
        window = self._seen.window(self._corner)
        return {'counts': self._counts[window].copy(), 'corner': self._seen.low.copy()}

    @classmethod
    def restored(
        cls, config: SubmapConfig, counts: NDArray[np.uint16], corner: NDArray[np.int64]
    ) -> Self:
        """
        Return a raster that continues from :meth:`arrays`; its cells are classified again.

        Raises
        ------
        ValueError
            If a shape or type is wrong.
        OdometryError
            If the raster exceeds ``MAX_EXTENT_M``.
        """
        if counts.ndim != 3 or counts.shape[2] != LAYERS or counts.dtype != np.uint16:
            raise ValueError(f'ray counts: expected (H, W, {LAYERS}) uint16, got {counts.shape}')
        if corner.shape != (2,) or corner.dtype != np.int64:
            raise ValueError(f'raster corner: expected (2,) int64, got {corner.shape}')
        raster, size = cls(config), np.array(counts.shape[1::-1])
        raster._check_extent(size)
        raster._counts, raster._corner = counts.copy(), corner.copy()
        raster._cells = np.full(counts.shape[:2], UNKNOWN, dtype=np.int8)
        raster._lintel = np.zeros(counts.shape[:2], dtype=np.bool_)
        raster._seen.add(corner, corner + size)
        raster._changed.add(corner, corner + size)
        return raster

    def _cover(self, low: NDArray[np.int64], high: NDArray[np.int64]) -> None:
        """Grow the raster until it contains cells ``low`` to ``high`` [column, row]."""
        shape = np.array(self._cells.shape[::-1])
        end = self._corner + shape
        if shape.all():
            if (low >= self._corner).all() and (high <= end).all():
                return
            self._check_extent(np.maximum(high, end) - np.minimum(low, self._corner))
            new_low = np.where(low < self._corner, low - _MARGIN_CELLS, self._corner)
            new_high = np.where(high > end, high + _MARGIN_CELLS, end)
        else:
            self._check_extent(high - low)
            new_low, new_high = low - _MARGIN_CELLS, high + _MARGIN_CELLS
        size = tuple((new_high - new_low)[::-1].tolist())
        col, row = (self._corner - new_low if shape.all() else np.zeros(2, dtype=int)).tolist()
        held = np.s_[row : row + shape[1], col : col + shape[0]]
        counts = np.zeros((*size, LAYERS), dtype=np.uint16)
        cells = np.full(size, UNKNOWN, dtype=np.int8)
        lintel = np.zeros(size, dtype=np.bool_)
        counts[held], cells[held], lintel[held] = self._counts, self._cells, self._lintel
        self._counts, self._cells, self._lintel = counts, cells, lintel
        self._corner = new_low

    def _check_extent(self, size: NDArray[np.int64]) -> None:
        extent_m = float(size.max()) * self._config.resolution_m
        if extent_m > MAX_EXTENT_M:
            raise OdometryError(
                f'the submap would be {extent_m:.0f} m long, limit '
                f'{MAX_EXTENT_M:.0f} m: the odometry has '
                'probably diverged; restart it and reset the submap'
            )


class _Box:
    """Bounding box of cells [column, row], ``high`` excluded."""

    def __init__(self) -> None:
        self.low = np.zeros(2, dtype=np.int64)
        self.high = np.zeros(2, dtype=np.int64)

    @property
    def is_empty(self) -> bool:
        return bool((self.low == self.high).any())

    def add(self, low: NDArray[np.int64], high: NDArray[np.int64]) -> None:
        if self.is_empty:
            self.low, self.high = low.copy(), high.copy()
        else:
            self.low, self.high = np.minimum(self.low, low), np.maximum(self.high, high)

    def window(self, corner: NDArray[np.int64]) -> tuple[slice, slice]:
        """Return the box as rows and columns of a raster whose cell (0, 0) is ``corner``."""
        (c0, r0), (c1, r1) = (self.low - corner).tolist(), (self.high - corner).tolist()
        return slice(r0, r1), slice(c0, c1)
