# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detection of storeys in a finished cloud: horizontal layers on which walls stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from fpnet_core.errors import CloudFormatError
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pieces import pieces_of

Array = NDArray[np.float64]

# Numerical: edge of the columns and height of the layers in which storeys are searched for [m].
_COLUMN_M, _LAYER_M = 0.2, 0.05
_BLOCK_M = 1.0  # numerical: edge of the blocks in which strays are detected [m]
# Chosen, not measured:
_STRAY_SHARE = 0.03  # blocks with a smaller share of the usual block's points are strays
_APART_BLOCKS = 1  # blocks within this distance are connected
_PART_SHARE = 0.05  # parts with a smaller share of the largest part's blocks are not the building
_PLANE_SHARE = 0.12  # least ground of a floor or ceiling, over that of the largest layer
_SAME_PLANE_M = 0.2  # layers closer than this are one
_STANDS_OUT = 1.3  # least ground of a floor over that of the layers just above it
_HEADROOM_M = (0.15, 1.9)  # a plane in this range above a layer leaves no headroom
_BELOW = 0.7  # least share of a ceiling below the next floor; a floor below tables has less
_JUST_ABOVE_M = (0.15, 0.6)  # range above a floor where walls begin
_STANDING_M = (0.5, 1.7)  # range above a floor that walls span
_LEAST_WALLS = 0.02  # least wall columns over a floor's ground; a roof has none above it
_EMPTY = 0.1  # layers with a smaller share of the usual wall columns are empty
_WALLS_BEGIN = 0.7  # least share of walls that begin just above the floor
_LOWEST_CEILING_M = 2.1
_MOST_STEPS = 8  # numerical: largest step between layers filled by walls
_MOST_COLUMNS = 100_000_000  # numerical: columns times layers
_MOST_CELLS = 25_000_000  # numerical: of a raster


@dataclass(frozen=True)
class StoreyHeights:
    """A floor, the ceiling above it or None if not seen [m], and its ground area [m2]."""

    floor_m: float
    ceiling_m: float | None
    area_m2: float
    top_m: float


def without_strays(points: Array) -> Array:
    """
    Return ``points (P, 3)`` without those away from the building.

    Raises
    ------
    CloudFormatError
        If the rest is larger than a building.
    """
    low = points[:, :2].min(axis=0)
    blocks = np.floor((points[:, :2] - low) / _BLOCK_M).astype(np.int64)
    shape = blocks.max(axis=0) + 1
    key = blocks[:, 0] * shape[1] + blocks[:, 1]
    keys, of_block, count = np.unique(key, return_inverse=True, return_counts=True)
    # Half of all points lie in blocks at least this full, however many strays there are.
    ascending = np.sort(count)
    usual = ascending[np.searchsorted(np.cumsum(ascending), 0.5 * len(points))]
    is_dense = count >= _STRAY_SHARE * usual
    places = np.stack(np.divmod(keys[is_dense], shape[1]), axis=1)
    corner = places.min(axis=0)
    size = places.max(axis=0) - corner + 1
    check_extent(size * _BLOCK_M, _BLOCK_M)
    mask = np.zeros(size, dtype=np.bool_)
    mask[tuple((places - corner).T)] = True
    pieces, _ = pieces_of(grown(mask, _APART_BLOCKS))
    piece = pieces[tuple((places - corner).T)]
    sizes = np.bincount(piece)
    is_kept = np.zeros(len(keys), dtype=np.bool_)
    is_kept[is_dense] = sizes[piece] >= _PART_SHARE * sizes.max()
    return points[is_kept[of_block]]


def check_extent(size_m: Array, cell_m: float) -> None:
    """
    Check that a raster is not larger than a building needs.

    Raises
    ------
    CloudFormatError
        If it is; the message states its size.
    """
    if float(np.prod(np.asarray(size_m, dtype=np.float64) / cell_m)) > _MOST_CELLS:
        raise CloudFormatError(
            f'the cloud spans {size_m[0]:.0f} x {size_m[1]:.0f} m, too much at '
            f'{cell_m} m per cell; crop it or raise submap.resolution_m'
        )


def find_storeys(points: Array) -> tuple[StoreyHeights, ...]:
    """
    Return the storeys of a gravity-aligned cloud ``points (P, 3)`` [m], lowest first.

    A floor is a layer that covers much ground and on which walls stand. Furniture may cover most
    of it; the lowest such layer is the floor.

    Raises
    ------
    CloudFormatError
        If there is no floor.
    """
    base, filled = _layers(points)
    walls = filled.sum(axis=1).astype(np.float64)
    thick = _around(filled)
    ground = thick.sum(axis=1).astype(np.float64)
    planes = _planes(ground)
    floors: list[int] = []
    for layer in planes:
        is_clear = not floors or layer - floors[-1] >= _LOWEST_CEILING_M / _LAYER_M
        if (
            is_clear
            and not _is_ceiling(thick, planes, layer)
            and _carries_walls(walls, ground[layer], layer)
        ):
            floors.append(layer)
    if not floors or len(ground) < _STANDING_M[1] / _LAYER_M:
        raise CloudFormatError(
            'the cloud shows no floor (is it planar, or not gravity-aligned?); use an occupancy '
            'grid or a recording with poses instead'
        )
    tops = [*floors[1:], len(ground)]
    return tuple(_storey(base, ground, planes, *each) for each in zip(floors, tops, strict=True))


def _layers(points: Array) -> tuple[float, NDArray[np.bool_]]:
    """Return the lowest layer's height [m], and which columns each layer fills, ``(L, C)``."""
    low, high = np.quantile(points[:, 2], (0.001, 0.999))
    inside = points[(points[:, 2] >= low - _LAYER_M) & (points[:, 2] <= high + _LAYER_M)]
    base = float(inside[:, 2].min()) - 0.5 * _LAYER_M  # voxels lie in the middle of layers
    corner = inside[:, :2].min(axis=0)
    column = np.floor((inside[:, :2] - corner) / _COLUMN_M).astype(np.int64)
    layer = np.floor((inside[:, 2] - base) / _LAYER_M).astype(np.int64)
    cols, layers = int(column[:, 1].max()) + 1, int(layer.max()) + 1
    flat = column[:, 0] * cols + column[:, 1]
    columns = int(flat.max()) + 1
    if columns * layers > _MOST_COLUMNS:
        raise CloudFormatError(
            f'the cloud is {layers * _LAYER_M:.0f} m high over {columns * _COLUMN_M**2:.0f} m²; '
            'expected a building in metres: crop it'
        )
    is_filled = np.zeros((layers, columns), dtype=np.bool_)
    is_filled[layer, flat] = True
    return base, is_filled


def _around(filled: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the columns filled in each layer or an adjacent one: planes scatter over these."""
    around = filled.copy()
    around[1:] |= filled[:-1]
    around[:-1] |= filled[1:]
    return around


def _planes(ground: Array) -> list[int]:
    """Return the layers that are floors or ceilings, lowest first; the others hold only walls."""
    level = ground - np.median(ground)
    strong = np.flatnonzero((level > 0.0) & (level >= _PLANE_SHARE * level.max()))
    planes: list[int] = []
    for layer in strong[np.argsort(-ground[strong], kind='stable')].tolist():
        if all(abs(layer - other) * _LAYER_M >= _SAME_PLANE_M for other in planes):
            planes.append(layer)
    return sorted(planes)


def _is_ceiling(filled: NDArray[np.bool_], planes: list[int], layer: int) -> bool:
    """
    Return whether most of a layer lies below another one without headroom in between.

    Such a layer is a ceiling with the next floor on it. Under tables, less of a floor is seen.
    """
    near, far = (layer + metres / _LAYER_M for metres in _HEADROOM_M)
    above = [filled[other] for other in planes if near <= other <= far]
    own = filled[layer]
    return any(np.count_nonzero(own & each) > _BELOW * np.count_nonzero(own) for each in above)


def _carries_walls(walls: Array, ground: float, layer: int) -> bool:
    """
    Return whether walls stand on a layer that covers ``ground`` columns.

    Walls fill the layers just above it as much as those at body height; ``walls (L,)`` is the
    number of columns filled per layer. Between a ceiling and the next floor there are none.
    """
    low, high = (layer + round(metres / _LAYER_M) for metres in _STANDING_M)
    standing = walls[low:high]
    if high > len(walls) or not standing.any():
        return False
    # Some layers are empty if they are finer than the cloud's voxels or scan rings on walls.
    is_filled = standing >= _EMPTY * np.median(standing[standing > 0.0])
    steps = np.diff(np.flatnonzero(np.r_[True, is_filled, True]))
    window = min(int(steps.max()), _MOST_STEPS)
    filled = sliding_window_view(walls, window).max(axis=1)
    low, high = (layer + round(metres / _LAYER_M) for metres in _JUST_ABOVE_M)
    begins = float(filled[low : high - window + 1].min())
    usual = float(np.median(standing[is_filled]))
    return bool(
        usual >= _LEAST_WALLS * ground
        and begins >= _WALLS_BEGIN * usual
        and ground >= _STANDS_OUT * begins
    )


def _storey(base: float, ground: Array, planes: list[int], floor: int, top: int) -> StoreyHeights:
    """Return the storey on the layer ``floor``, below the layer ``top``."""
    lowest = floor + _LOWEST_CEILING_M / _LAYER_M
    ceilings = [layer for layer in planes if lowest <= layer < top]
    ceiling = max(ceilings, key=lambda layer: ground[layer], default=None)
    return StoreyHeights(
        base + (floor + 0.5) * _LAYER_M,
        None if ceiling is None else base + (ceiling + 0.5) * _LAYER_M,
        float(ground[floor]) * _COLUMN_M**2,
        base + top * _LAYER_M,
    )
