# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Overlay of a submap on the raster of the drawing.

The maps are aligned locally (:mod:`fpnet_core.differences.bending`): a part that is drawn half a
metre off as a whole is inexact, not out of date.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.differences.bending import bending
from fpnet_core.geometry import Affine2D
from fpnet_core.pose import PreparedMap
from fpnet_core.pose.evidence import WALL_REACH_M
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pieces import label_windows, looked_up, pieces_of
from fpnet_core.segmentation.furniture import free_standing
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

Mask = NDArray[np.bool_]

FAR_M = 1e3
"""Numerical: distance from walls if there are none."""

_BAR_M, _BAR_FILLED = 1.0, 0.6
"""
Chosen: least length of a free-standing wall [m], and least filled share of the smallest rectangle
around it. Letters, outlines and door leaves with arcs leave most of their rectangle blank.
"""


@dataclass(frozen=True, eq=False)
class Overlay:
    """
    Both maps on the raster of the drawing, ``(H, W)`` each.

    ``drawn_m`` and ``seen_m`` are distances to the nearest ink and observed wall [m]. ``is_drawn``
    marks drawn walls without letters, door leaves and furniture, ``is_wall`` observed walls,
    ``is_free`` and ``is_known`` observed cells, ``is_inside`` cells in the building or its walls.
    ``cell_m`` is in estimated true metres.
    """

    drawn_m: NDArray[np.float32]
    seen_m: NDArray[np.float32]
    is_drawn: Mask
    is_wall: Mask
    is_free: Mask
    is_known: Mask
    is_inside: Mask
    cell_m: float


def overlay(plan: PreparedMap, sub: PreparedMap, A_plan_sub: Affine2D) -> Overlay:
    """
    Return both maps on the drawing's raster.

    Parameters
    ----------
    plan, sub : prepared maps of drawing and submap, in metres
    A_plan_sub : the placement of the submap on the drawing
    """
    grid, seen = plan.segmentation.grid, sub.segmentation.grid
    rc = _positions_in(seen, grid, A_plan_sub, bending(plan.evidence, sub.evidence, A_plan_sub))
    wall = _faced_walls(seen)
    labels = plan.segmentation.labels > 0
    reach = max(1, round(WALL_REACH_M / grid.resolution))
    cells = _looked_up(seen.cells.astype(np.float32), rc, cv2.INTER_NEAREST, float(UNKNOWN))
    seen_m = _looked_up(metres_to(wall, seen.resolution), rc, cv2.INTER_LINEAR, FAR_M)
    drawn = (grid.cells == OCCUPIED) & grown(labels, 2 * reach)
    within = labels | free_standing(labels, grid.resolution)
    return Overlay(
        drawn_m=metres_to(drawn, grid.resolution),
        seen_m=seen_m,
        is_drawn=drawn & ~_symbols(drawn & within, grid.resolution),
        is_wall=seen_m <= grid.resolution,
        is_free=cells == FREE,
        is_known=cells != UNKNOWN,
        is_inside=grown(labels, 2 * reach),
        cell_m=grid.resolution,
    )


def _symbols(marks: Mask, cell_m: float) -> Mask:
    """Return the marks ``(H, W)`` within rooms that are not walls, that is long straight bars."""
    pieces, figures = pieces_of(marks)
    is_symbol = np.ones(len(figures), dtype=np.bool_)
    is_symbol[0] = False
    is_long = np.hypot(figures[:, 2], figures[:, 3]) * cell_m >= _BAR_M
    for piece, window in label_windows(pieces).items():
        if not is_long[piece]:
            continue
        rc = np.argwhere(pieces[window] == piece).astype(np.float32)
        _, sides, _ = cv2.minAreaRect(rc)
        long, short = max(sides) + 1.0, min(sides) + 1.0
        is_symbol[piece] = long * cell_m < _BAR_M or len(rc) < _BAR_FILLED * long * short
    return looked_up(pieces, is_symbol)


def _faced_walls(seen: GridMap) -> Mask:
    """Return the wall cells ``(H, W)`` of a submap that have free space in front of them."""
    reach = max(1, round(WALL_REACH_M / seen.resolution))
    return np.asarray((seen.cells == OCCUPIED) & grown(seen.cells == FREE, reach))


def metres_to(mask: Mask, cell_m: float) -> NDArray[np.float32]:
    """Return the distance ``(H, W)`` from each cell to the nearest one of ``mask`` [m]."""
    if not mask.any():
        return np.full(mask.shape, FAR_M, dtype=np.float32)
    return np.asarray(cells_to_nearest(mask) * np.float32(cell_m), dtype=np.float32)


def _positions_in(
    seen: GridMap, drawn: GridMap, A_plan_sub: Affine2D, bending: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return the submap position of each cell of the drawing, ``(H, W, 2)`` (row, col)."""
    rc = np.stack(np.meshgrid(*map(np.arange, drawn.shape), indexing='ij'), axis=-1)
    xy, back = drawn.rc_to_xy(rc), A_plan_sub.inv()
    at = seen.xy_to_rc(back.apply(xy))
    share = np.array(bending.shape[:2]) / np.array(seen.shape)
    near = np.clip(np.rint(at * share), 0, np.array(bending.shape[:2]) - 1).astype(np.int64)
    shift = bending[near[..., 0], near[..., 1]]
    return np.asarray(seen.xy_to_rc(back.apply(xy - shift)), dtype=np.float32)


def _looked_up(
    values: NDArray[np.float32], rc: NDArray[np.float32], how: int, outside: float
) -> NDArray[np.float32]:
    found = cv2.remap(
        values, rc[..., 1], rc[..., 0], how, borderMode=cv2.BORDER_CONSTANT, borderValue=outside
    )
    return np.asarray(found, dtype=np.float32)
