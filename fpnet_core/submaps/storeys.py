# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys of a finished cloud: its level layers on which walls stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from fpnet_core.errors import CloudFormatError
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pieces import pieces_of

Array = NDArray[np.float64]

# Numerical: storeys are looked for in columns of this edge and layers of this height [m].
_COLUMN_M, _LAYER_M = 0.2, 0.05
_BLOCK_M = 1.0  # numerical: strays are told by columns of this edge [m]
# Chosen, not measured:
_STRAY_SHARE = 0.03  # blocks with a smaller share of a usual block's points are strays
_APART_BLOCKS = 1  # blocks this near to one another belong together
_PART_SHARE = 0.05  # of the largest part's blocks, below which a part is not the building
_PLANE_SHARE = 0.12  # of the largest layer's ground, from which on a layer is a floor or ceiling
_SAME_PLANE_M = 0.2  # layers nearer than this are one
_STANDS_OUT = 1.3  # a floor covers so many times as much ground as the layers just above it
_HEADROOM_M = (0.15, 1.9)  # above a floor, where no other one hides it
_BELOW = 0.7  # of a ceiling lies below the next floor, of a floor below tables less is seen
_JUST_ABOVE_M = (0.15, 0.6)  # a floor, where walls begin
_STANDING_M = (0.5, 1.7)  # above a floor, where walls are
_LEAST_WALLS = 0.02  # of a floor's ground; a roof has none above
_EMPTY = 0.1  # of the usual layer; one with fewer walls is empty
_WALLS_BEGIN = 0.7  # of what stands on a floor begins just above it at least
_LOWEST_CEILING_M = 2.1
_MOST_STEPS = 8  # numerical: layers from one that walls fill to the next
_MOST_COLUMNS = 100_000_000  # numerical: columns times layers
_MOST_CELLS = 25_000_000  # numerical: of a raster


@dataclass(frozen=True)
class StoreyHeights:
    """A floor and the ceiling above it, None where none was seen [m], and its ground [m2]."""

    floor_m: float
    ceiling_m: float | None
    area_m2: float
    top_m: float


def without_strays(points: Array) -> Array:
    """
    Return ``points (P, 3)`` without those that lie apart from the building.

    Raises
    ------
    CloudFormatError
        If what is left spans more than a building does.
    """
    low = points[:, :2].min(axis=0)
    blocks = np.floor((points[:, :2] - low) / _BLOCK_M).astype(np.int64)
    shape = blocks.max(axis=0) + 1
    key = blocks[:, 0] * shape[1] + blocks[:, 1]
    keys, of_block, count = np.unique(key, return_inverse=True, return_counts=True)
    # Half of all points lie in blocks at least as full as this, however many strays there are.
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
    Refuse a raster that no building needs.

    Raises
    ------
    CloudFormatError
        Saying how large it would be.
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
    of it: the lowest such layer is the floor.

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
            and _bears_walls(walls, ground[layer], layer)
        ):
            floors.append(layer)
    if not floors or len(ground) < _STANDING_M[1] / _LAYER_M:
        raise CloudFormatError(
            'the cloud shows no floor (is it planar, or not gravity-aligned?); give a robot map '
            'image or a recording with poses instead'
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
    """Return the columns that each layer or its next fill: a plane scatters over those."""
    around = filled.copy()
    around[1:] |= filled[:-1]
    around[:-1] |= filled[1:]
    return around


def _planes(ground: Array) -> list[int]:
    """Return the layers that are floors or ceilings, lowest first: walls fill all others."""
    level = ground - np.median(ground)
    strong = np.flatnonzero((level > 0.0) & (level >= _PLANE_SHARE * level.max()))
    planes: list[int] = []
    for layer in strong[np.argsort(-ground[strong], kind='stable')].tolist():
        if all(abs(layer - other) * _LAYER_M >= _SAME_PLANE_M for other in planes):
            planes.append(layer)
    return sorted(planes)


def _is_ceiling(filled: NDArray[np.bool_], planes: list[int], layer: int) -> bool:
    """
    Tell whether most of a layer lies below another one without headroom in between.

    That is a ceiling with the next floor on it. Of a floor below tables less is seen.
    """
    near, far = (layer + metres / _LAYER_M for metres in _HEADROOM_M)
    above = [filled[other] for other in planes if near <= other <= far]
    own = filled[layer]
    return any(np.count_nonzero(own & each) > _BELOW * np.count_nonzero(own) for each in above)


def _bears_walls(walls: Array, ground: float, layer: int) -> bool:
    """
    Tell whether walls stand on a layer that covers ``ground`` columns.

    They fill the layers just above it as they fill those at body height: ``walls (L,)`` is how
    many columns each fills. Between a ceiling and the next floor they are gone.
    """
    low, high = (layer + round(metres / _LAYER_M) for metres in _STANDING_M)
    standing = walls[low:high]
    if high > len(walls) or not standing.any():
        return False
    # Of layers finer than a cloud's voxels, or than its rings on walls, some are empty.
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
