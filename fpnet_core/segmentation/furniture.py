# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Free-standing obstacles: furniture, and pieces of wall between doorways."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import filled, looked_up, pieces_of
from fpnet_core.raster.windows import Window, cropped, framed

# Free-standing obstacles smaller than this are furniture;
# fitted to the development split (notes/segmentation.md).
_AREA_M2 = 2.0
# Free-standing obstacles longer than this are walls;
# fitted to the development split (notes/segmentation.md).
_EXTENT_M = 2.5
# A piece of wall between two doorways has at least this length, at most this thickness [m], at
# least this area in squares of its thickness, and this distance to all other walls [m];
# fitted to the development split (notes/segmentation.md).
_LEAST_LENGTH_M, _MOST_THICKNESS_M, _LEAST_SLENDERNESS, _DOORWAY_M = 0.65, 0.4, 2.5, 0.6
# Chosen: reach within which walls beside a piece and beyond its ends are compared [m]; largest
# width of a straight piece over its length.
_BESIDE_M, _STRAIGHT = 1.6, 0.35


def free_standing(free: Mask, cell_m: float) -> Mask:
    """
    Return the cells (H, W) of small obstacles of any kind that ``free (H, W)`` surrounds.

    Their area and bounding-box diagonal are below limits and they touch no border. ``cell_m`` is
    the cell edge [true metres].
    """
    obstacles, figures = pieces_of(~free)
    return looked_up(obstacles, _are_small(figures, free.shape, cell_m))


def furniture_cells(free: Mask, cell_m: float, is_drawn: bool = False) -> Mask:
    """
    Return the cells (H, W) of furniture, which are not ``free (H, W)``.

    Small free-standing obstacles are furniture, unless they look like a piece of wall between two
    doorways: thin, long, and a doorway's width away from the walls. A table drawn by its outline
    is as thick as the table; in a robot map, occlusion fills it. With ``is_drawn``, walls must
    also continue beyond the ends of a wall piece: an arrow through a doorway has them at its
    sides. ``cell_m`` is the cell edge [true metres].
    """
    obstacles, figures = pieces_of(~free)
    is_small = _are_small(figures, free.shape, cell_m)
    is_wall = _are_walls(obstacles, figures, is_small, cell_m, is_drawn)
    return looked_up(obstacles, is_small & ~is_wall)


def _are_small(figures: NDArray[np.int32], shape: tuple[int, ...], cell_m: float) -> Mask:
    """Return which obstacles, ``figures (N, 5)`` of :func:`pieces_of`, are small and inside."""
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
    """Return which of the obstacles ``among (N,)`` are pieces of wall between doorways."""
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
    """Return whether one obstacle is ``cells`` away from all obstacles not in ``among``."""
    walls, own = _walls_near(obstacles, number, among, window, cells)
    return bool(cells_to_nearest(walls, where=own, most=cells)[own].min() >= cells)


def _is_across(
    obstacles: NDArray[np.int32], number: np.int64, among: Mask, window: Window, cells: int
) -> bool:
    """Return whether the walls nearest to a straight piece, within ``cells``, lie beside it."""
    walls, own = _walls_near(obstacles, number, among, window, cells)
    if not walls.any():
        return False
    rc = np.argwhere(own)
    axes = np.linalg.eigh(np.cov(rc.T))[1]  # across, along
    half = np.abs((rc - rc.mean(axis=0)) @ axes).max(axis=0)
    if half[0] > _STRAIGHT * half[1]:  # a junction of walls, which continue in several directions
        return False
    away = np.maximum(np.abs((np.argwhere(walls) - rc.mean(axis=0)) @ axes) - half, 0.0)
    is_beside = away[:, 1] == 0.0
    distance = np.hypot(*away.T)
    beside, beyond = (distance[each].min(initial=np.inf) for each in (is_beside, ~is_beside))
    return bool(beside < beyond)


def _walls_near(
    obstacles: NDArray[np.int32], number: np.int64, among: Mask, window: Window, cells: int
) -> tuple[Mask, Mask]:
    """Return the cells (H, W) of walls, not ``among``, near one obstacle, and its own cells."""
    rows, cols = (slice(side.start - cells, side.stop + cells) for side in window)
    near = cropped(obstacles, (rows, cols), 0)
    return (near > 0) & ~among[near], near == number
