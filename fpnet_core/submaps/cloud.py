# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Submap of a finished point-cloud map without sensor poses."""

from __future__ import annotations

from dataclasses import dataclass
import logging
import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry import SE2
from fpnet_core.raster.morphology import Mask, closed, grown
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.windows import border_of
from fpnet_core.submaps.heights import LINTEL_HEIGHT_M, LINTEL_TOP_M
from fpnet_core.submaps.storeys import StoreyHeights, check_extent, find_storeys, without_strays
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap

_log = logging.getLogger(__name__)

_BIN_M = 0.1  # numerical: height bins of a column
# Chosen, not measured:
_FLOOR_M = 0.12  # scatter of floor returns
_CEILING_M = 0.2  # scatter of ceiling returns, beams included
_GAP_M = 0.3  # gaps between floor or ceiling returns up to this are free as well
_SPACING_POINTS = 50_000  # numerical: number of central points whose spacing is measured
_SPACING_MARGIN = 1.1  # numerical: factor within which a surface surely has a neighbouring point
_MIN_BODY_BINS = 2  # a column with fewer filled bins at body height holds noise
_TALL_BINS = 2  # a wall fills this many bins above body height, in its column or an adjacent one
_TALL_SHARE = 0.25  # if fewer obstacles than this reach higher, nothing above body height was seen
_CEILED_SHARE = 0.5  # least share of floor below ceiling in a building with ceilings
_INDOORS_SHARE = 0.25  # least share of an indoor floor component below ceiling


def submap_from_cloud(
    points: NDArray[np.float64], config: SubmapConfig, storey: int | None = None
) -> Submap:
    """
    Rasterise a gravity-aligned cloud: the space between floor and ceiling is free.

    Without sensor poses, rays cannot carve free space. A cell is free if floor or ceiling was seen
    and it has no points at body height, apart from furniture, which is lower than lintels. Returns
    at lintel height over seen floor are lintels. Parts away from the building are dropped, and so
    is ground without a ceiling if the building has one. In a cloud thinned to larger voxels, cells
    between neighbouring points count as seen.

    Parameters
    ----------
    points : (P, 3) finite, z up, metres
    config : resolution and height bands
    storey : number of the storey, the lowest is 1; None: the largest

    Raises
    ------
    CloudFormatError
        If there are no points, no floor, no such storey, or the cloud spans too large an area.
    """
    if len(points) == 0:
        raise CloudFormatError('the cloud holds no points')
    if not np.isfinite(points).all():
        raise CloudFormatError('the cloud holds NaN or infinite points; drop them')
    building = without_strays(points)
    level = _chosen(find_storeys(building), storey)
    return _rasterised(building, level, config)


def _chosen(storeys: tuple[StoreyHeights, ...], number: int | None) -> StoreyHeights:
    if number is None:
        largest = max(storeys, key=lambda storey: storey.area_m2)
        if len(storeys) > 1:
            _log.warning(
                'the cloud shows %d storeys; using storey %d, the largest; for another, pass '
                '--storey N to fpnet segment or --submap-storey N to fpnet match',
                len(storeys),
                storeys.index(largest) + 1,
            )
        return largest
    if not 1 <= number <= len(storeys):
        raise CloudFormatError(
            f'storey {number}: the cloud shows {len(storeys)}; the lowest is storey 1'
        )
    return storeys[number - 1]


@dataclass(frozen=True, eq=False)
class _Columns:
    """
    Cell of each point ``(P,)`` in a raster of ``shape``, and height above the floor [m].

    Neighbouring points are up to ``apart`` cells and ``bin_m`` apart.
    """

    cell: NDArray[np.int64]
    height: NDArray[np.float64]
    shape: tuple[int, int]
    apart: int
    bin_m: float

    def seen(self, low_m: float, high_m: float) -> Mask:
        """Return the cells (H, W) with points between two heights."""
        found = np.zeros(self.shape[0] * self.shape[1], dtype=np.bool_)
        found[self.cell[(self.height >= low_m) & (self.height < high_m)]] = True
        cells = found.reshape(self.shape)
        return cells if self.apart < 2 else closed(cells, self.apart)

    def filled(self, low_m: float, high_m: float) -> NDArray[np.uint8]:
        """Return the number of bins with points between two heights, by cell (H, W)."""
        bins = np.arange(low_m, high_m - 0.5 * self.bin_m, self.bin_m)
        return sum(
            (self.seen(low, low + self.bin_m).astype(np.uint8) for low in bins.tolist()),
            np.zeros(self.shape, dtype=np.uint8),
        )


def _rasterised(points: NDArray[np.float64], level: StoreyHeights, config: SubmapConfig) -> Submap:
    """Return the submap of one storey."""
    own = points[(points[:, 2] > level.floor_m - _FLOOR_M) & (points[:, 2] < level.top_m)]
    corner = np.floor(own[:, :2].min(axis=0) / config.resolution_m).astype(np.int64)
    col_row = np.floor(own[:, :2] / config.resolution_m).astype(np.int64) - corner
    cols, rows = (col_row.max(axis=0) + 1).tolist()
    check_extent(np.array([cols, rows]) * config.resolution_m, config.resolution_m)
    apart_m = _SPACING_MARGIN * _spacing_m(own)
    columns = _Columns(
        col_row[:, 1] * cols + col_row[:, 0],
        own[:, 2] - level.floor_m,
        (rows, cols),
        math.ceil(apart_m / config.resolution_m),
        max(_BIN_M, apart_m),
    )
    free, wall, lintel = _classified(columns, level, config)
    cells = np.full((rows, cols), UNKNOWN, dtype=np.int8)
    cells[free], cells[wall] = FREE, OCCUPIED
    x, y = (corner * config.resolution_m).tolist()
    grid = GridMap(cells, config.resolution_m, SE2.from_xy_yaw(x, y, 0.0), 'submap')
    return Submap(grid, lintel, np.zeros((0, 2)))


def _spacing_m(points: NDArray[np.float64]) -> float:
    """Return the median spacing of points: the voxel edge of a thinned cloud."""
    away = np.abs(points - np.median(points, axis=0)).max(axis=1)
    count = min(_SPACING_POINTS, len(points))
    near = points[np.argpartition(away, count - 1)[:count]]
    return float(np.median(cKDTree(near).query(near, k=2)[0][:, 1])) if count > 1 else 0.0


def _classified(
    columns: _Columns, level: StoreyHeights, config: SubmapConfig
) -> tuple[Mask, Mask, Mask]:
    """Return masks of free space, walls and lintels (H, W)."""
    ceiling = np.inf if level.ceiling_m is None else level.ceiling_m - level.floor_m
    top = min(LINTEL_TOP_M, ceiling - _CEILING_M)
    floor = columns.seen(-_FLOOR_M, _FLOOR_M)
    roofed = columns.seen(ceiling - _CEILING_M, ceiling + _CEILING_M)
    body = columns.filled(config.body_low_m, config.body_high_m)
    high = columns.filled(config.body_high_m, top)
    obstacle = body >= _MIN_BODY_BINS
    tall = _box_max(high) >= _TALL_BINS
    if np.count_nonzero(obstacle & tall) < _TALL_SHARE * np.count_nonzero(obstacle):
        tall[:] = True  # nothing higher was seen: every obstacle may be a wall
    # Where furniture hides a wall's lower part and the floor, its upper part is the wall.
    wall = tall & (obstacle | ((high >= _TALL_BINS) & ~grown(floor, 1)))
    seen = floor | roofed | (body > 0)
    free = closed(seen | wall, max(1, round(_GAP_M / config.resolution_m))) & ~wall
    free |= _blind_spots(free, wall)
    over = columns.filled(LINTEL_HEIGHT_M, top) > 0
    if np.count_nonzero(floor & roofed) >= _CEILED_SHARE * np.count_nonzero(floor):
        free = _indoors(free, roofed)
    return free, wall, free & over


def _box_max(values: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the largest value (H, W) in each cell and its eight neighbours."""
    return np.asarray(cv2.dilate(values, np.ones((3, 3), np.uint8)))


def _blind_spots(free: Mask, wall: Mask) -> Mask:
    """
    Return the unseen holes (H, W) in free space that no wall touches.

    A scanner sees neither the floor below it nor the ceiling straight above. An obstacle in such a
    hole would have been seen.
    """
    pieces, figures = pieces_of(~free & ~wall)
    is_hole = np.ones(len(figures), dtype=np.bool_)
    is_hole[pieces[grown(wall, 1)]] = False
    is_hole[np.unique(border_of(pieces))] = False
    is_hole[0] = False
    return np.asarray(is_hole[pieces])


def _indoors(free: Mask, roofed: Mask) -> Mask:
    """Return the components of ``free`` (H, W) that lie below a ceiling."""
    pieces, figures = pieces_of(free, connectivity=4)
    covered = np.bincount(pieces[roofed & free], minlength=len(figures))
    is_inside = covered >= _INDOORS_SHARE * figures[:, -1]
    is_inside[0] = False
    return np.asarray(is_inside[pieces])
