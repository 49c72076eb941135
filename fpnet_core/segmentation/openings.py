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

from fpnet_core.raster.morphology import Mask, square
from fpnet_core.raster.pieces import meeting_cells
from fpnet_core.raster.windows import first_of_each
from fpnet_core.segmentation.scene import WorkRaster

# Doors between the same rooms nearer than this are one: half a leaf and a jamb;
# fitted to the tune half (docs/segmentation.md).
_DOOR_SEPARATION_M = 0.7

MIN_DOOR_WIDTH_M = 0.6
"""
Narrower ones are no doors: shelves that look like lintels, cracks between the ends of walls, holes
in a wall that was seen too rarely. Chosen.
"""

# Chosen, not measured:
# The closing line is looked for within this many clearances of a saddle, on each side.
_LINE_REACH = 3.0
# It may move so far across the wall to find the jambs [m].
_SLIDE_M = 0.3
# Numerical: directions tried for the line across an opening, over half a turn.
_DIRECTIONS = 36
_BOUNDING = 6  # numerical: of which every so many are tried first
_STEP_CELLS = 0.25  # numerical: along a line
_SAME_CELLS = 1.0  # numerical: lines that differ by less are as narrow
_ROOMY_CELLS = 4  # numerical: where all is free within so many cells, lines are looked at in leaps

Space = NDArray[np.uint8]
"""What is free, see :func:`roominess`."""


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


def roominess(free: Mask) -> Space:
    """Return 0 (H, W) where cells are not ``free``, 2 where all within some cells are, else 1."""
    cells = free.view(np.uint8)
    kernel = square(2 * _ROOMY_CELLS + 1)
    roomy = cv2.erode(cells, kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    return np.asarray(cells + roomy)


@njit(cache=True)
def _narrowest_chord(
    space: Space,
    row: float,
    col: float,
    reach: float,
    units: NDArray[np.float64],
    bound: float,
) -> tuple[float, float, float, float]:
    """
    Return the ends (row, col, row, col) of the shortest free chord through a point.

    Where all are longer than ``bound``, it is only some chord that is. ``units (K, 2)`` are the
    directions to try.
    """
    best = (row, col, row, col)
    best_length = 1e18
    # A few directions bound the length first, if nothing does: most are then given up early.
    if bound == np.inf:
        for k in range(0, len(units), _BOUNDING):
            bound = min(bound, sum(_runs(space, row, col, reach, units[k, 0], units[k, 1], bound)))
    for k in range(len(units)):
        d_row, d_col = units[k, 0], units[k, 1]
        limit = min(bound, best_length)
        ahead, behind = _runs(space, row, col, reach, d_row, d_col, limit)
        if ahead + behind < best_length:
            best_length = ahead + behind
            best = (
                row + ahead * d_row,
                col + ahead * d_col,
                row - behind * d_row,
                col - behind * d_col,
            )
    return best


@njit(cache=True, inline='always')
def _runs(
    space: Space, row: float, col: float, reach: float, d_row: float, d_col: float, bound: float
) -> tuple[float, float]:
    """
    Return how far a place's line is free ahead and behind, up to ``reach`` [cells].

    Nothing is exact of a line longer than ``bound``, but that it is.
    """
    ahead = _run(space, row, col, d_row, d_col, reach, bound, 0.0)
    return ahead, _run(space, row, col, -d_row, -d_col, reach, bound, ahead)


@njit(cache=True, inline='always')
def _run(
    space: Space, row: float, col: float, d_row: float, d_col: float, reach: float,
    bound: float, before: float,
) -> float:  # fmt: skip
    """Return how far it is free from a place on, up to ``reach``, ``before`` more to ``bound``."""
    rows, cols = space.shape
    leap = _ROOMY_CELLS - 1.0
    run = 0.0
    while run < reach and before + run <= bound:
        r = int(np.floor(row + (run + _STEP_CELLS) * d_row + 0.5))
        c = int(np.floor(col + (run + _STEP_CELLS) * d_col + 0.5))
        if r < 0 or c < 0 or r >= rows or c >= cols or space[r, c] == 0:
            break
        run += _STEP_CELLS
        # Where all is free around, so are the next places on the line.
        while space[r, c] > 1 and run + leap < reach and before + run + leap <= bound:
            run += leap
            r, c = int(np.floor(row + run * d_row + 0.5)), int(np.floor(col + run * d_col + 0.5))
    return run


@dataclass(frozen=True, eq=False)
class Saddle:
    """The widest cell ``rc`` (working cells) of one stretch of boundary between two rooms."""

    rooms: tuple[int, int]
    rc: tuple[int, int]
    clearance_m: float


def find_saddles_of_rooms(labels: NDArray[np.int32], work: WorkRaster) -> list[Saddle]:
    """List one saddle per connected stretch of boundary of ``labels (h, w)``, widest first."""
    here, there = meeting_cells(labels)
    if here.size == 0:
        return []
    cells, first = np.unique(here, return_index=True)
    low, high = np.sort(labels.ravel()[[here[first], there[first]]], axis=0).astype(np.int64)
    boundary = np.zeros(labels.shape, np.uint8)
    boundary.ravel()[cells] = 1
    _, stretches = cv2.connectedComponents(boundary, connectivity=8)
    base = int(labels.max()) + 1
    key = (stretches.ravel()[cells].astype(np.int64) * base + low) * base + high
    value = work.clearance.ravel()[cells]
    return [
        Saddle(
            (int(low[k]), int(high[k])),
            divmod(int(cells[k]), labels.shape[1]),
            float(value[k]),
        )
        for k in first_of_each(key, np.lexsort((cells, -value)))
    ]


def closing_line(saddle: Saddle, work: WorkRaster, space: Space) -> NDArray[np.float64]:
    """Return the ends (2, 2) of the line in ``space (H, W)`` that closes a saddle's opening."""
    row, col = ((k + 0.5) * work.stride - 0.5 for k in saddle.rc)
    clearance = saddle.clearance_m / work.cell_m * work.stride
    reach = _LINE_REACH * (clearance + work.stride)
    slide = _SLIDE_M / work.cell_m * work.stride
    return narrowest_line(space, (row, col), reach, slide, clearance)


def narrowest_line(
    space: Space, place: tuple[float, float], reach: float, slide: float, min_length: float
) -> NDArray[np.float64]:
    """
    Return the ends (2, 2) of the narrowest line across the doorway near ``place``.

    A line through a place on the wall's face may miss the jambs and run along the wall
    instead: places up to ``slide`` away across the first line are tried as well, and of those
    within a cell of the narrowest the middle one is taken, which is in the middle of the wall.

    Parameters
    ----------
    space : (H, W) what is free, see :func:`roominess`
    place : row and column, fractional
    reach, slide, min_length : cells; half the longest line, and the shortest line when sliding
    """
    ends = _slide_to_narrowest(space, float(place[0]), float(place[1]), reach, slide, min_length)
    return np.array(ends).reshape(2, 2)


@njit(cache=True)
def _slide_to_narrowest(
    space: Space, row: float, col: float, reach: float, slide: float, min_length: float
) -> tuple[float, float, float, float]:
    """Carry out :func:`narrowest_line` in compiled code; long submaps ask for hundreds."""
    units = np.empty((_DIRECTIONS, 2))
    for k in range(_DIRECTIONS):
        angle = np.pi * k / _DIRECTIONS
        units[k] = np.sin(angle), np.cos(angle)
    # As the bound of later ones is: Numba would compile a default apart.
    first = _narrowest_chord(space, row, col, reach, units, np.inf)
    d_row, d_col = first[2] - first[0], first[3] - first[1]
    first_length = np.hypot(d_row, d_col)
    unit = max(1.0, first_length)
    count = int(np.floor(2.0 * slide)) + 2
    lines = np.empty((count, 4))
    lengths = np.full(count, np.inf)
    lines[0, :] = first
    lengths[0] = first_length
    shortest = min(min_length, first_length)
    least = first_length
    for k in range(1, count):
        offset = k - 1 - slide
        r = min(max(row - offset * d_col / unit, 0.0), space.shape[0] - 1.0)
        c = min(max(col + offset * d_row / unit, 0.0), space.shape[1] - 1.0)
        if space[round(r), round(c)]:
            chord = _narrowest_chord(space, r, c, reach, units, least + _SAME_CELLS + 1e-6)
            lines[k, :] = chord
            lengths[k] = np.hypot(chord[2] - chord[0], chord[3] - chord[1])
            if lengths[k] >= shortest:
                least = min(least, lengths[k])
    usable = (lengths >= shortest) & (lengths < np.inf)
    least = lengths[usable].min()
    narrow = np.flatnonzero(usable & (lengths <= least + _SAME_CELLS))
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
    space = roominess(free)
    return [Opening(s.rooms, closing_line(s, work, space), s.clearance_m) for s in kept]
