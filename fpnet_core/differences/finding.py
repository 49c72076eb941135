# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detection of differences between two overlaid maps, each with a probability."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from fpnet_core.differences.found import Difference, DifferenceKind, Differences
from fpnet_core.differences.overlay import FAR_M, Overlay, metres_to, overlay
from fpnet_core.geometry import Affine2D
from fpnet_core.pose import PreparedMap
from fpnet_core.raster.morphology import closed, grown
from fpnet_core.raster.pieces import label_windows, pieces_of
from fpnet_core.raster.rays import draw_line, values_at
from fpnet_core.types import GridMap

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

APART_M = 0.3
"""Physical: larger than the inexactness of drawings and than half of a thick wall."""

WALL_WEIGHTS = (3.6, 2.6, 2.2, 3.0, 3.5, -3.0, 2.2)
"""
Log odds that an observed piece that is not drawn is a wall, for :data:`WALL_FIGURES`. Fitted by
``python benchmarks/difference_weights.py`` to 48 generated drives, half of them planar: 1,570 of
1,678 pieces are classified correctly, of which 250 are walls.
"""

MISSING_WEIGHTS = (-4.4, 1.7, 5.7, 1.8)
"""
Log odds that a drawn wall is missing, for :data:`MISSING_FIGURES`. Fitted by
``python benchmarks/difference_weights.py`` to 48 generated drives: 397 of 483 pieces are
classified correctly, of which 245 are missing.
"""

WALL_FIGURES = (
    'one',
    'log_width',
    'log_apart',
    'moved_share',
    'ends_at_walls',
    'open_share',
    'sees_over',
)
"""
Given: features of observed pieces that are not drawn, in the order of the weights. Shares: of the
piece near a missing drawn wall, of its ends at a drawn wall, and of the piece with free space on
both sides, as tables have. A scanner that has detected lintels sees over tables.
"""

MISSING_FIGURES = ('one', 'log_apart', 'free_share', 'passed_share')
"""
Given: features of drawn pieces in free space, in the order of the weights. The last two are
shares: of free cells around it, and of the piece with free space well in front and behind.
"""

# Physical:
_SHORTEST_M = 0.3  # shorter pieces are corners and noise
_GAP_M = 0.25  # largest gap between parts of an observed wall
_DOOR_REACH_M = 0.3  # largest distance of a closed leaf from the opening's line
_JOINED_M = 0.35  # largest gap between the end of a wall and the next wall
_BESIDE_M = (0.2, 0.3, 0.4)  # beyond the thickness of the observed piece, within its room
_PASSED_M = (1.5,)  # in front of and behind a wall: more than the drift of a map
# Chosen, not measured:
_MOVED_M = 1.0  # largest distance by which a wall is moved; farther ones are unrelated
_SHUT = 0.8  # least share of an opening that is observed, and least share that is closed


def find_differences(
    plan: PreparedMap, sub: PreparedMap, A_plan_sub: Affine2D, drawn: GridMap | None = None
) -> Differences:
    """
    Return the differences between a drawing and the observed building.

    Parameters
    ----------
    plan, sub : prepared maps of drawing and submap, in metres
    A_plan_sub : placement of the submap on the drawing; it must be correct
    drawn : the drawing in its nominal metres, for the result; None uses that of ``plan``

    Returns
    -------
    Differences; without pieces if nothing differs or nothing was observed.
    """
    laid = overlay(plan, sub, A_plan_sub)
    grid = drawn or plan.segmentation.grid
    doors, at_doors = _shut_doors(plan, laid)
    new = laid.is_wall & laid.is_inside & (laid.drawn_m > APART_M) & ~at_doors
    missing = laid.is_drawn & laid.is_free & (laid.seen_m > APART_M)
    piece_of = np.zeros(grid.shape, dtype=np.int32)
    pieces: list[Difference] = []
    sees_over = any(portal.has_lintel for portal in sub.segmentation.portals)
    seen = _undrawn(new, missing, sees_over, laid, grid)
    for cells, piece in (*doors, *seen, *_missing(missing, laid, grid)):
        pieces.append(piece)
        piece_of[cells] = len(pieces)
    return Differences(grid, tuple(pieces), piece_of, laid.is_known & laid.is_inside)


def _undrawn(
    mask: Mask, missing: Mask, sees_over: bool, laid: Overlay, grid: GridMap
) -> Iterator[tuple[Mask, Difference]]:
    """Yield observed pieces that are not drawn: walls and furniture."""
    missing_m = metres_to(missing, laid.cell_m)
    for cells, ends, length_m, width_m in _pieces(mask, laid.cell_m, grid):
        ends_rc = grid.xy_to_rc(ends)
        figures = np.array(
            [
                1.0,
                np.log(width_m),
                np.log(min(float(laid.drawn_m[cells].mean()), 2.0)),
                (missing_m[cells] <= _MOVED_M).mean(),
                (values_at(laid.drawn_m, ends_rc, FAR_M) <= _JOINED_M).mean(),
                _open_share(cells, ends_rc, laid, _BESIDE_M),
                sees_over,
            ]
        )
        p = float(expit(figures @ np.array(WALL_WEIGHTS)))
        is_wall = p >= 1.0 - p
        kind = DifferenceKind.WALL if is_wall else DifferenceKind.FURNITURE
        yield cells, Difference(kind, ends, length_m, p if is_wall else 1.0 - p, figures)


def _missing(mask: Mask, laid: Overlay, grid: GridMap) -> Iterator[tuple[Mask, Difference]]:
    """Yield drawn walls that are missing: free space was observed in their place."""
    reach = max(1, round(APART_M / laid.cell_m))
    for cells, ends, length_m, _ in _pieces(mask, laid.cell_m, grid):
        figures = np.array(
            [
                1.0,
                np.log(min(float(laid.seen_m[cells].mean()), 2.0)),
                laid.is_free[grown(cells, reach)].mean(),
                _open_share(cells, grid.xy_to_rc(ends), laid, _PASSED_M),
            ]
        )
        p = float(expit(figures @ np.array(MISSING_WEIGHTS)))
        yield cells, Difference(DifferenceKind.MISSING, ends, length_m, p, figures)


def _open_share(cells: Mask, ends_rc: Array, laid: Overlay, away_m: tuple[float, ...]) -> float:
    """Return the share of a piece with free space on both sides, at any distance ``away_m``."""
    along = ends_rc[1] - ends_rc[0]
    normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    off = np.outer(away_m, normal / laid.cell_m)
    sides = [np.argwhere(cells)[:, None] + sign * off for sign in (1.0, -1.0)]
    one, other = (values_at(laid.is_free, side, outside=False).any(axis=1) for side in sides)
    return float((one & other).mean())


def _shut_doors(plan: PreparedMap, laid: Overlay) -> tuple[list[tuple[Mask, Difference]], Mask]:
    """Return the drawn doors that were observed closed, and the cells of all drawn doors."""
    grid, reach = plan.segmentation.grid, max(1, round(_DOOR_REACH_M / laid.cell_m))
    at_doors, found = np.zeros(grid.shape, dtype=np.bool_), []
    for portal in plan.segmentation.portals:
        line = np.zeros(grid.shape, dtype=np.uint8)
        draw_line(line, grid.xy_to_rc(portal.ends))
        cells = line > 0
        closed_share = float((laid.seen_m[cells] <= _DOOR_REACH_M / 2.0).mean())
        known_share = float(laid.is_known[grown(cells, 1)].mean())
        if closed_share >= _SHUT and known_share >= _SHUT:
            figures = np.array([closed_share, known_share])
            confidence = closed_share * known_share
            ends = grid.rc_to_xy(grid.xy_to_rc(portal.ends))
            width_m = portal.width_m
            found.append(
                (cells, Difference(DifferenceKind.SHUT, ends, width_m, confidence, figures))
            )
        at_doors |= grown(cells, reach)
    return found, at_doors


def _pieces(
    mask: Mask, cell_m: float, grid: GridMap
) -> Iterator[tuple[Mask, Array, float, float]]:
    """Yield the connected pieces of a mask: cells, ends in the frame, length and width [m]."""
    joined = closed(mask, 1 + 2 * max(1, round(0.5 * _GAP_M / cell_m)))
    labels, _ = pieces_of(joined)
    for label, window in label_windows(labels).items():
        cells = np.zeros_like(mask)
        cells[window] = mask[window] & (labels[window] == label)
        rc = np.argwhere(cells)
        if len(rc) < 2:
            continue
        (col, row), size, turn = cv2.minAreaRect(rc[:, ::-1].astype(np.float32))
        along = np.deg2rad(turn) + (0.0 if size[0] >= size[1] else np.pi / 2.0)
        half = 0.5 * max(size) * np.array([np.sin(along), np.cos(along)])
        ends = grid.rc_to_xy(np.array([row, col]) + np.stack([-half, half]))
        length = _length_of(labels[window] == label)
        if length * cell_m >= _SHORTEST_M:
            yield cells, ends, float(length * cell_m), float(len(rc) / length * cell_m)


def _length_of(piece: Mask) -> float:
    """Return the length of a thin, possibly curved piece in cells: half of its outline."""
    outlines, _ = cv2.findContours(
        piece.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    around = max(cv2.arcLength(outline, True) for outline in outlines)
    return max(0.5 * float(around) + 1.0, float(np.hypot(*piece.shape)))
