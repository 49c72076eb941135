# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Openings between labelled rooms, and the line that closes each of them."""

from __future__ import annotations

from dataclasses import dataclass
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import meeting_cells
from fpnet_core.raster.rays import cells_at, run_lengths
from fpnet_core.raster.windows import first_of_each
from fpnet_core.segmentation.scene import WorkRaster

# Doors between the same rooms nearer than this are one: half a leaf and a jamb;
# fitted to the development split (notes/segmentation.md).
_DOOR_SEPARATION_M = 0.7

MIN_DOOR_WIDTH_M = 0.6
"""
Physical: narrower openings are no doors but shelves that look like lintels, cracks between the
ends of walls, holes in a wall that was seen too rarely.
"""

THICK_WALL_M = 0.6
"""Physical: thickness of thick walls."""

# Search range of the closing line on each side of a saddle, in clearances. Chosen.
_LINE_REACH = 3.0
# Numerical: directions tried for the line across an opening, over half a turn.
_DIRECTIONS = 36
_BOUNDING = 6  # numerical: every this many directions are tried first, for a bound
_STEP_CELLS = 0.25  # numerical: step along a line
_SAME_CELLS = 1.0  # numerical: lines whose lengths differ by less count as equal
_ANGLES = np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS  # numerical
# Numerical: their unit vectors.
_UNITS = np.stack([np.sin(_ANGLES), np.cos(_ANGLES)], axis=1)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Opening:
    """
    A place where two rooms meet.

    ``rooms`` are room labels (0: unseen or dropped space); ``ends_rc (2, 2)`` are the wall points
    on both sides in fractional cells of the full raster; ``clearance_m`` is half the width at the
    narrowest place [true metres].
    """

    rooms: tuple[int, int]
    ends_rc: Array
    clearance_m: float
    has_lintel: bool = False


@dataclass(frozen=True, eq=False)
class Saddle:
    """The widest cell ``rc`` (working cells) of one connected boundary between two rooms."""

    rooms: tuple[int, int]
    rc: tuple[int, int]
    clearance_m: float


def find_saddles_of_rooms(labels: NDArray[np.int32], work: WorkRaster) -> list[Saddle]:
    """List one saddle per connected boundary of two labels (h, w), widest first."""
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


def closing_lines(saddles: list[Saddle], work: WorkRaster, free: Mask) -> Array:
    """Return the ends (S, 2, 2) of the lines in ``free (H, W)`` that close saddles' openings."""
    places = (np.array([s.rc for s in saddles]).reshape(-1, 2) + 0.5) * work.stride - 0.5
    clearance = np.array([s.clearance_m for s in saddles]) / work.cell_m * work.stride
    reach = _LINE_REACH * (clearance + work.stride)
    # The line may move across half a wall to find the jambs.
    slide = 0.5 * THICK_WALL_M / work.cell_m * work.stride
    return narrowest_lines(free, places, reach, slide, clearance)


def narrowest_lines(
    free: Mask, places: Array, reach: Array, slide: float, min_length: Array
) -> Array:
    """
    Return the ends (N, 2, 2) of the narrowest lines across doorways near ``places (N, 2)``.

    A line through a place on the wall's face may miss the jambs and run along the wall instead.
    Places up to ``slide`` away across the first line are therefore tried as well. Of the lines
    within a cell of the narrowest, the middle one is taken: it lies in the middle of the wall.

    Parameters
    ----------
    free : (H, W), passable cells
    places : row and column, fractional
    reach, slide, min_length : cells; half the longest line (N,), the least when sliding (N,)
    """
    lines = _narrowest_chords(free, places, reach)[:, None]
    along = lines[:, 0, 1] - lines[:, 0, 0]
    length = np.hypot(*along.T)
    offsets = np.arange(math.floor(2.0 * slide) + 1) - slide
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(1.0, length)[:, None]
    others = places[:, None] + offsets[:, None] * across[:, None]
    others = np.clip(others, 0.0, np.array(free.shape) - 1.0)
    is_free = free[cells_at(others, free.shape)]
    own = np.nonzero(is_free)[0]
    bound = length[own] + _SAME_CELLS + _STEP_CELLS
    chords = np.zeros((*is_free.shape, 2, 2))
    chords[is_free] = _narrowest_chords(free, others[is_free], reach[own], bound)
    lines = np.concatenate([lines, chords], axis=1)
    lengths = np.hypot(*np.moveaxis(lines[:, :, 1] - lines[:, :, 0], -1, 0))
    lengths[:, 1:][~is_free] = np.inf
    lengths[lengths < np.minimum(min_length, length)[:, None]] = np.inf
    is_narrow = lengths <= lengths.min(axis=1, keepdims=True) + _SAME_CELLS
    middle = np.cumsum(is_narrow, axis=1) == is_narrow.sum(axis=1, keepdims=True) // 2 + 1
    return np.asarray(lines[np.arange(len(lines)), np.argmax(middle, axis=1)])


def _narrowest_chords(
    free: Mask, places: Array, reach: Array, bound: Array | None = None
) -> Array:
    """
    Return the ends (P, 2, 2) of the shortest free chord through each of ``places (P, 2)``.

    If all are longer than ``bound (P,)``, the result is some chord longer than that.
    """
    if bound is None:  # a few directions bound the length first
        runs = _chords(free, places, _UNITS[::_BOUNDING], reach, 2.0 * reach)
        bound = np.sum(runs, axis=0).min(axis=1)
    ahead, behind = _chords(free, places, _UNITS, reach, bound)
    each, best = np.arange(len(places)), (ahead + behind).argmin(axis=1)
    unit = _UNITS[best]
    return np.stack(
        [places + ahead[each, best, None] * unit, places - behind[each, best, None] * unit], axis=1
    )


def _chords(
    free: Mask, places: Array, units: Array, reach: Array, bound: Array
) -> tuple[Array, Array]:
    """Return the free distance ahead and behind (P, K); beyond ``bound`` only a lower limit."""
    starts, reach, limit = places[:, None], reach[:, None], bound[:, None] + 2.0 * _STEP_CELLS
    ahead = _free_runs(free, starts, units, np.minimum(reach, limit))
    return ahead, _free_runs(free, starts, -units, np.minimum(reach, limit - ahead))


def _free_runs(free: Mask, starts: Array, units: Array, limits: Array) -> Array:
    """Return the free distance along ``units`` from one step ahead of ``starts``."""
    return run_lengths(free, False, starts + _STEP_CELLS * units, units, limits, _STEP_CELLS)


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
    free : (H, W) bool at full resolution; limits the lines

    Returns
    -------
    list of Opening, widest first; empty if no two rooms touch
    """
    kept: list[Saddle] = []
    separation = _DOOR_SEPARATION_M / work.cell_m
    for saddle in find_saddles_of_rooms(labels, work):
        if not any(
            other.rooms == saddle.rooms and math.dist(other.rc, saddle.rc) < separation
            for other in kept
        ):
            kept.append(saddle)
    lines = closing_lines(kept, work, free)
    return [Opening(s.rooms, ends, s.clearance_m) for s, ends in zip(kept, lines, strict=True)]
