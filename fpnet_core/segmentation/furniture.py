# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What stands free: furniture, and pieces of wall between doorways."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import filled, looked_up, pieces_of
from fpnet_core.raster.windows import Window, cropped, framed

# Free-standing obstacles smaller than this are furniture;
# fitted to the tune half (notes/segmentation.md).
_AREA_M2 = 2.0
# Free-standing obstacles longer than this are walls;
# fitted to the tune half (notes/segmentation.md).
_EXTENT_M = 2.5
# A piece of wall between two doorways is at least so long and nowhere thicker [m], covers so many
# squares of its thickness, and is a doorway away from all others [m];
# fitted to the tune half (notes/segmentation.md).
_LEAST_LENGTH_M, _MOST_THICKNESS_M, _LEAST_SLENDERNESS, _DOORWAY_M = 0.65, 0.4, 2.5, 0.6
# Chosen: walls as near are looked at for whether they stand beside a piece or go on from it [m],
# one that is straight: so wide at most, over its length.
_BESIDE_M, _STRAIGHT = 1.6, 0.35


def free_standing(free: Mask, cell_m: float) -> Mask:
    """
    Return the cells (H, W) of small pieces that ``free (H, W)`` surrounds, of whatever kind.

    They stay below limits of area and bounding-box diagonal, and touch no border. ``cell_m`` is
    the cell edge [true metres].
    """
    obstacles, figures = pieces_of(~free)
    return looked_up(obstacles, _are_small(figures, free.shape, cell_m))


def furniture_cells(free: Mask, cell_m: float, is_drawn: bool = False) -> Mask:
    """
    Return the cells (H, W) of furniture, which are not ``free (H, W)``.

    Free-standing pieces are, unless they stand as a piece of wall does between two doorways: thin,
    long, and a doorway away from the walls. A table that is drawn by its outline is as thick as
    the table, and what a robot sees of one is filled by what it hides. Where ``is_drawn``, walls
    go on from the ends of such a piece: what points through a doorway, as an arrow does, has them
    at its sides. ``cell_m`` is the cell edge [true metres].
    """
    obstacles, figures = pieces_of(~free)
    is_small = _are_small(figures, free.shape, cell_m)
    is_wall = _are_walls(obstacles, figures, is_small, cell_m, is_drawn)
    return looked_up(obstacles, is_small & ~is_wall)


def _are_small(figures: NDArray[np.int32], shape: tuple[int, ...], cell_m: float) -> Mask:
    """Tell which obstacles, ``figures (N, 5)`` as of :func:`pieces_of`, are small, and inside."""
    left, top, width, height, area = figures.T
    inside = (left > 0) & (top > 0) & (left + width < shape[1]) & (top + height < shape[0])
    small = area * cell_m**2 < _AREA_M2
    short = np.hypot(width, height) * cell_m < _EXTENT_M
    found = inside & small & short
    found[0] = False
    return np.asarray(found)


def _are_walls(
    obstacles: NDArray[np.int32],
    figures: NDArray[np.int32],
    among: Mask,
    cell_m: float,
    is_drawn: bool,
) -> Mask:
    """Tell which obstacles ``among (N,)`` some stand as a piece of wall does."""
    size = figures[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    found = among & (np.hypot(*size.T) * cell_m >= _LEAST_LENGTH_M)
    for number in np.flatnonzero(found):
        left, top, width, height = figures[number, : cv2.CC_STAT_AREA]
        window = (slice(top, top + height), slice(left, left + width))
        piece = framed(filled(obstacles[window] == number), (1, 1), (1, 1))
        thickness = 2.0 * cells_to_nearest(~piece, where=piece).max() - 1.0
        found[number] = (
            thickness * cell_m <= _MOST_THICKNESS_M
            and piece.sum() >= _LEAST_SLENDERNESS * thickness**2
            and _is_apart(obstacles, number, among, window, round(_DOORWAY_M / cell_m))
            and not (
                is_drawn
                and _is_across(obstacles, number, among, window, round(_BESIDE_M / cell_m))
            )
        )
    return np.asarray(found)


def _is_apart(
    obstacles: NDArray[np.int32], number: np.int64, among: Mask, window: Window, cells: int
) -> bool:
    """Tell whether all obstacles but those ``among`` some are so many cells away from one."""
    walls, own = _walls_near(obstacles, number, among, window, cells)
    return bool(cells_to_nearest(walls, where=own, most=cells)[own].min() >= cells)


def _is_across(
    obstacles: NDArray[np.int32], number: np.int64, among: Mask, window: Window, cells: int
) -> bool:
    """Tell whether the nearest walls, within so many cells, lie beside a straight piece."""
    walls, own = _walls_near(obstacles, number, among, window, cells)
    if not walls.any():
        return False
    rc = np.argwhere(own)
    axes = np.linalg.eigh(np.cov(rc.T))[1]  # across, along
    half = np.abs((rc - rc.mean(axis=0)) @ axes).max(axis=0)
    if half[0] > _STRAIGHT * half[1]:  # walls that meet there go on in several directions
        return False
    away = np.maximum(np.abs((np.argwhere(walls) - rc.mean(axis=0)) @ axes) - half, 0.0)
    is_beside = away[:, 1] == 0.0
    distance = np.hypot(*away.T)
    beside, beyond = (distance[each].min(initial=np.inf) for each in (is_beside, ~is_beside))
    return bool(beside < beyond)


def _walls_near(
    obstacles: NDArray[np.int32], number: np.int64, among: Mask, window: Window, cells: int
) -> tuple[Mask, Mask]:
    """Return the obstacles (H, W) but those ``among`` some so near to one, and that one."""
    rows, cols = (slice(side.start - cells, side.stop + cells) for side in window)
    near = cropped(obstacles, (rows, cols), 0)
    return (near > 0) & ~among[near], near == number
