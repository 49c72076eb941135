# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Openings between labelled rooms, and the line that closes each of them."""

from __future__ import annotations

from dataclasses import dataclass
import math

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.rays import is_inside
from fpnet_core.raster.windows import NEIGHBOURS, first_of_each
from fpnet_core.segmentation.scene import WorkRaster

# Doors between the same rooms nearer than this are one: half a leaf and a jamb;
# fitted to the tune half (docs/segmentation.md).
_DOOR_SEPARATION_M = 0.7

# Chosen, not measured:
# The closing line is looked for within this many clearances of a saddle, on each side.
_LINE_REACH = 3.0
# It may move so far across the wall to find the jambs [m].
_SLIDE_M = 0.3
# Numerical: directions tried for the line across an opening, over half a turn.
DIRECTIONS = 36


@dataclass(frozen=True, eq=False)
class Opening:
    """
    A place where two rooms meet.

    ``rooms`` are room labels (0: unseen or dropped space); ``ends_rc (2, 2)`` are the wall
    points on both sides in fractional cells of the full raster; ``clearance_m`` is half the
    width at the narrowest place [true metres].
    """

    rooms: tuple[int, int]
    ends_rc: NDArray[np.float64]
    clearance_m: float
    has_lintel: bool = False


@njit(cache=True)
def narrowest_chord(
    free: NDArray[np.bool_], row: float, col: float, reach: float, directions: int
) -> tuple[float, float, float, float]:
    """Return the ends (row, col, row, col) of the shortest free chord through a point."""
    best = (row, col, row, col)
    best_length = 1e18
    step = 0.25
    for k in range(directions):
        angle = np.pi * k / directions
        d_row, d_col = np.sin(angle), np.cos(angle)
        ends = np.zeros(2)
        for side in range(2):
            sign = 1.0 if side == 0 else -1.0
            run = 0.0
            while run < reach:
                ahead = sign * (run + step)
                if not is_inside(free, row + ahead * d_row, col + ahead * d_col, False):
                    break
                run += step
            ends[side] = run
        if ends[0] + ends[1] < best_length:
            best_length = ends[0] + ends[1]
            best = (
                row + ends[0] * d_row,
                col + ends[0] * d_col,
                row - ends[1] * d_row,
                col - ends[1] * d_col,
            )
    return best


@dataclass(frozen=True, eq=False)
class Saddle:
    """The widest cell ``rc`` (working cells) of one stretch of boundary between two rooms."""

    rooms: tuple[int, int]
    rc: tuple[int, int]
    clearance_m: float


def find_saddles_of_rooms(labels: NDArray[np.int32], work: WorkRaster) -> list[Saddle]:
    """List one saddle per connected stretch of boundary of ``labels (h, w)``, widest first."""
    boundary, low, high = _boundary(labels)
    cells = np.flatnonzero(boundary)
    if cells.size == 0:
        return []
    _, stretches = cv2.connectedComponents(boundary.astype(np.uint8), connectivity=8)
    base = int(labels.max()) + 1
    key = (stretches.ravel()[cells].astype(np.int64) * base + low.ravel()[cells]) * base
    key += high.ravel()[cells]
    value = work.clearance.ravel()[cells]
    chosen = cells[first_of_each(key, np.lexsort((cells, -value)))]
    return [
        Saddle(
            (int(low.ravel()[cell]), int(high.ravel()[cell])),
            divmod(int(cell), labels.shape[1]),
            float(work.clearance.ravel()[cell]),
        )
        for cell in chosen
    ]


def closing_line(saddle: Saddle, work: WorkRaster, free: Mask) -> NDArray[np.float64]:
    """Return the ends (2, 2) of the line in ``free (H, W)`` that closes a saddle's opening."""
    row, col = ((k + 0.5) * work.stride - 0.5 for k in saddle.rc)
    clearance = saddle.clearance_m / work.cell_m * work.stride
    reach = _LINE_REACH * (clearance + work.stride)
    slide = _SLIDE_M / work.cell_m * work.stride
    return narrowest_line(free, (row, col), reach, slide, clearance)


def narrowest_line(
    free: Mask, place: tuple[float, float], reach: float, slide: float, min_length: float
) -> NDArray[np.float64]:
    """
    Return the ends (2, 2) of the narrowest line across the doorway near ``place``.

    A line through a place on the wall's face may miss the jambs and run along the wall
    instead: places up to ``slide`` away across the first line are tried as well, and of those
    within a cell of the narrowest the middle one is taken, which is in the middle of the wall.

    Parameters
    ----------
    free : (H, W) bool
    place : row and column, fractional
    reach, slide, min_length : cells; half the longest line, and the shortest line when sliding
    """
    ends = _slide_to_narrowest(
        free, float(place[0]), float(place[1]), reach, slide, min_length, DIRECTIONS
    )
    return np.array(ends).reshape(2, 2)


@njit(cache=True)
def _slide_to_narrowest(
    free: NDArray[np.bool_],
    row: float,
    col: float,
    reach: float,
    slide: float,
    min_length: float,
    directions: int,
) -> tuple[float, float, float, float]:
    """Carry out :func:`narrowest_line` in compiled code; long submaps ask for hundreds."""
    first = narrowest_chord(free, row, col, reach, directions)
    d_row, d_col = first[2] - first[0], first[3] - first[1]
    first_length = np.hypot(d_row, d_col)
    unit = max(1.0, first_length)
    count = int(np.floor(2.0 * slide)) + 2
    lines = np.empty((count, 4))
    lengths = np.full(count, np.inf)
    lines[0, :] = first
    lengths[0] = first_length
    for k in range(1, count):
        offset = k - 1 - slide
        r = min(max(row - offset * d_col / unit, 0.0), free.shape[0] - 1.0)
        c = min(max(col + offset * d_row / unit, 0.0), free.shape[1] - 1.0)
        if free[round(r), round(c)]:
            chord = narrowest_chord(free, r, c, reach, directions)
            lines[k, :] = chord
            lengths[k] = np.hypot(chord[2] - chord[0], chord[3] - chord[1])
    shortest = min(min_length, first_length)
    usable = (lengths >= shortest) & (lengths < np.inf)
    least = lengths[usable].min()
    narrow = np.flatnonzero(usable & (lengths <= least + 1.0))
    chosen = lines[narrow[len(narrow) // 2]]
    return chosen[0], chosen[1], chosen[2], chosen[3]


def find_openings(
    labels: NDArray[np.int32],
    work: WorkRaster,
    free: Mask,
) -> list[Opening]:
    """
    Find the saddles that survived merging, each with the line that closes it.

    Parameters
    ----------
    labels : (h, w) int32, room labels at working resolution
    work : the raster that was labelled
    free : (H, W) bool at full resolution; lines end where it ends

    Returns
    -------
    list of Opening, widest first; empty where no two rooms touch
    """
    kept: list[Saddle] = []
    separation = _DOOR_SEPARATION_M / work.cell_m
    for saddle in find_saddles_of_rooms(labels, work):
        if not any(
            other.rooms == saddle.rooms and math.dist(other.rc, saddle.rc) < separation
            for other in kept
        ):
            kept.append(saddle)
    return [Opening(s.rooms, closing_line(s, work, free), s.clearance_m) for s in kept]


def _boundary(
    labels: NDArray[np.int32],
) -> tuple[Mask, NDArray[np.int32], NDArray[np.int32]]:
    """Mark cells whose right or upper neighbour has another label; give both labels."""
    low, high = np.zeros_like(labels), np.zeros_like(labels)
    for here, there in NEIGHBOURS:
        a, b = labels[here], labels[there]
        meet = (a != b) & (a > 0) & (b > 0) & (high[here] == 0)
        low[here][meet] = np.minimum(a, b)[meet]
        high[here][meet] = np.maximum(a, b)[meet]
    return high > 0, low, high
