# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A finished point-cloud map, without the poses it was seen from, as a submap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry import SE2
from fpnet_core.raster.morphology import closed
from fpnet_core.submaps.heights import LINTEL_HEIGHT_M, LINTEL_TOP_M
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap

_HEIGHT_BIN_M = 0.05  # numerical
# Chosen, not measured:
_PLANE_SHARE = 0.02  # a floor holds at least this share of the points in its bins
_FLOOR_THICKNESS_M = 0.15
_FLOOR_GAP_M = 0.3  # gaps between floor returns up to this are floor too
_MIN_WALL_POINTS = 2  # a single return at body height is noise
_MAX_CELLS = 25_000_000  # numerical


def submap_from_cloud(points: NDArray[np.float64], config: SubmapConfig) -> Submap:
    """
    Rasterise a gravity-aligned cloud: seen floor is free, returns at body height are walls.

    Without sensor poses no ray can carve free space, so the floor has to be in the cloud.

    Parameters
    ----------
    points : (P, 3) finite, z up, metres
    config : resolution and height bands

    Raises
    ------
    CloudFormatError
        If there are no points, no floor, or the cloud spans an absurd area.
    """
    if len(points) == 0:
        raise CloudFormatError('the cloud holds no points')
    if not np.isfinite(points).all():
        raise CloudFormatError('the cloud holds NaN or infinite points; drop them')
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    shape = tuple(np.ceil((high - low)[::-1] / config.resolution_m).astype(int) + 1)
    if shape[0] * shape[1] > _MAX_CELLS:
        raise CloudFormatError(
            f'the cloud spans {high[0] - low[0]:.0f} x {high[1] - low[1]:.0f} m, too much at '
            f'{config.resolution_m} m per cell; crop it or raise submap.resolution_m'
        )
    floor = _floor_height(points[:, 2])
    rc = np.floor((points[:, 1::-1] - low[::-1]) / config.resolution_m).astype(np.int64)
    height = points[:, 2] - floor

    def counts(lowest: float, highest: float) -> NDArray[np.int64]:
        chosen = rc[(height >= lowest) & (height < highest)]
        flat = chosen[:, 0] * shape[1] + chosen[:, 1]
        return np.bincount(flat, minlength=shape[0] * shape[1]).reshape(shape)

    wall = counts(config.body_low_m, config.body_high_m) >= _MIN_WALL_POINTS
    gap = max(1, round(_FLOOR_GAP_M / config.resolution_m))
    seen_floor = counts(-_FLOOR_THICKNESS_M, _FLOOR_THICKNESS_M) > 0
    free = closed(seen_floor, gap) & ~wall
    cells = np.full(shape, UNKNOWN, dtype=np.int8)
    cells[free] = FREE
    cells[wall] = OCCUPIED
    origin = SE2.from_xy_yaw(float(low[0]), float(low[1]), 0.0)
    grid = GridMap(cells, config.resolution_m, origin, 'submap')
    lintel = free & (counts(LINTEL_HEIGHT_M, LINTEL_TOP_M) >= _MIN_WALL_POINTS)
    return Submap(grid, lintel, np.zeros((0, 2)))


def _floor_height(z: NDArray[np.float64]) -> float:
    """Height of the lowest well-filled layer [m]."""
    low = float(np.quantile(z, 0.001))
    bins = np.floor((z - low) / _HEIGHT_BIN_M).astype(np.int64)
    filled = np.bincount(bins[bins >= 0])
    smooth = np.convolve(filled, np.ones(3), mode='same')
    strong = np.flatnonzero(smooth >= _PLANE_SHARE * len(z))
    if len(strong) == 0 or np.ptp(z) < _FLOOR_THICKNESS_M * 2:
        raise CloudFormatError(
            'the cloud shows no floor (is it planar, or not gravity-aligned?); give a robot map '
            'image or a recording with poses instead'
        )
    first = int(strong[0])
    peak = first + int(np.argmax(smooth[first : first + 4]))
    return low + (peak + 0.5) * _HEIGHT_BIN_M
