# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doorways closed by their lintels: the paper's prior that doors are lower than ceilings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import pieces_of_few
from fpnet_core.raster.rays import cells_at, draw_line
from fpnet_core.raster.windows import first_of_each
from fpnet_core.segmentation.openings import (
    MIN_DOOR_WIDTH_M,
    Opening,
    narrowest_line,
    roominess,
)

# Chosen, not measured:
# No doorway is wider than this [m].
_MAX_WIDTH_M = 3.0
# Share of the opening line under which high returns must have been seen.
_MIN_COVERAGE = 0.35
# High returns this near to the opening line belong to it: half of a thick wall [m].
_LINE_REACH_M = 0.3
# Free space must go on for so far on both sides of a doorway [m].
_PASSAGE_M = 0.4
# How far from the line, in both directions, a room is looked for [m].
_ROOM_REACH_M = 0.8
# Numerical: places along a doorway at which it is looked for.
_BESIDE_PLACES = 7


@dataclass(frozen=True, eq=False)
class Doorway:
    """A doorway's closing line ``ends_rc (2, 2)`` in cells of the full raster."""

    ends_rc: NDArray[np.float64]
    cell_m: float
    has_lintel: bool = True

    def between(self, labels: NDArray[np.int32]) -> Opening:
        """Return the opening with the rooms of ``labels (H, W)`` nearest on both sides."""
        reach = _ROOM_REACH_M / self.cell_m
        low, high = sorted(_first_label(labels, self.ends_rc, side, reach) for side in (1.0, -1.0))
        half_m = 0.5 * math.dist(*self.ends_rc.tolist()) * self.cell_m
        return Opening((low, high), self.ends_rc, half_m, self.has_lintel)


@njit(cache=True, nogil=True)
def _first_label(
    labels: NDArray[np.int32], ends: NDArray[np.float64], side: float, reach: float
) -> int:
    """Return the most frequent label on the first line beside ``ends`` that meets a room."""
    d_row, d_col = ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1]
    length = np.hypot(d_row, d_col)
    seen = np.zeros(_BESIDE_PLACES, dtype=np.int64)
    for step in range(1, int(np.ceil(reach))):
        count = 0
        for k in range(_BESIDE_PLACES):
            share = 0.2 + 0.6 * k / (_BESIDE_PLACES - 1)
            row = np.rint(ends[0, 0] + share * d_row - side * step * d_col / length)
            col = np.rint(ends[0, 1] + share * d_col + side * step * d_row / length)
            r = int(min(max(row, 0), labels.shape[0] - 1))
            c = int(min(max(col, 0), labels.shape[1] - 1))
            if labels[r, c] > 0:
                seen[count] = labels[r, c]
                count += 1
        if count:
            best, votes = np.int64(0), 0
            for k in range(count):
                own = np.sum(seen[:count] == seen[k])
                if own > votes or (own == votes and seen[k] < best):
                    best, votes = seen[k], own
            return int(best)
    return 0


def find_lintels(
    lintel: Mask,
    free: Mask,
    wall: Mask,
    cell_m: float,
    known: Sequence[Doorway] = (),
    held: Mask | None = None,
) -> tuple[Mask, list[Doorway]]:
    """
    Turn high returns over free space into closed doorways.

    Parameters
    ----------
    lintel : (H, W) bool, free cells below a high return
    free : (H, W) bool
    wall : (H, W) bool, cells at or near a wall; both ends of a doorway lie there
    cell_m : cell edge [true metres]
    known : doorways that are closed already
    held : (H, W) bool, cells in whose middle no further doorway is looked for; None: nowhere

    Returns
    -------
    closed (H, W) bool : cells of the closing lines, which no region may cross
    doors : ``known`` and one per further doorway, largest evidence first; high returns that
        span no doorway (shelves, ducts, beams) close nothing
    """
    closed = np.zeros(lintel.shape, dtype=np.uint8)
    doors = list(known)
    for door in known:
        draw_line(closed, door.ends_rc)
    lines = np.array([door.ends_rc for door in doors]).reshape(-1, 2, 2)
    space = roominess(free)
    for row, col in _centres(lintel, cell_m):
        if (held is not None and held[row, col]) or _is_beside(lines, row, col, cell_m):
            continue
        centre = float(row), float(col)
        ends = narrowest_line(
            space, centre, _MAX_WIDTH_M / cell_m, _LINE_REACH_M / cell_m, MIN_DOOR_WIDTH_M / cell_m
        )
        apart = lines.mean(axis=1) - ends.mean(axis=0)
        is_new = (np.hypot(*apart.T) * cell_m >= MIN_DOOR_WIDTH_M).all()
        if is_new and _is_doorway(ends, lintel, free, wall, cell_m):
            doors.append(Doorway(ends, cell_m))
            lines = np.concatenate([lines, ends[None]])
            draw_line(closed, ends)
    return closed.view(np.bool_) & free, doors


def _is_doorway(
    ends: NDArray[np.float64], lintel: Mask, free: Mask, wall: Mask, cell_m: float
) -> bool:
    """Tell whether a line is as wide as a door, under high returns, in a wall, and passable."""
    width_m = math.dist(ends[0], ends[1]) * cell_m
    if not MIN_DOOR_WIDTH_M <= width_m <= _MAX_WIDTH_M:
        return False
    if not wall[cells_at(ends, wall.shape)].all():
        return False
    (r0, c0), (r1, c1) = ends.tolist()
    reach, passage = _LINE_REACH_M / cell_m, _PASSAGE_M / cell_m
    covered, passes = _evidence(lintel, free, r0, c0, r1, c1, reach, passage)
    return bool(covered >= _MIN_COVERAGE and passes)


@njit(cache=True, nogil=True)
def _is_beside(lines: NDArray[np.float64], row: float, col: float, cell_m: float) -> bool:
    """Tell whether a place belongs to one of the lines with ends ``lines (D, 2, 2)``."""
    for k in range(len(lines)):
        d_row, d_col = lines[k, 1, 0] - lines[k, 0, 0], lines[k, 1, 1] - lines[k, 0, 1]
        r, c = row - lines[k, 0, 0], col - lines[k, 0, 1]
        share = (r * d_row + c * d_col) / max(d_row * d_row + d_col * d_col, 1e-9)
        share = min(max(share, 0.0), 1.0)
        if np.hypot(r - share * d_row, c - share * d_col) * cell_m <= _LINE_REACH_M:
            return True
    return False


def _centres(lintel: Mask, cell_m: float) -> list[tuple[int, int]]:
    """
    Return a cell in the middle of each piece of high returns, largest first.

    Pieces with too few high returns around them to cover even the narrowest doorway are left
    out.
    """
    window = 2 * round(MIN_DOOR_WIDTH_M / cell_m) + 1
    around = cv2.boxFilter(lintel.view(np.uint8), cv2.CV_16S, (window, window), normalize=False)
    fewest = math.ceil(_MIN_COVERAGE * MIN_DOOR_WIDTH_M / cell_m)
    cells, owner = pieces_of_few(lintel & (np.asarray(around) >= fewest))
    size = np.bincount(owner)
    centroid = np.stack([np.bincount(owner, along) for along in cells.T], axis=1) / size[:, None]
    off_centre = np.hypot(*(cells - centroid[owner]).T)
    # Sorted by owner first, so that the first of each are in the order of the pieces.
    nearest = first_of_each(owner, np.lexsort((off_centre, owner)))
    largest_first = np.argsort(-size, kind='stable')
    return [(row, col) for row, col in cells[nearest][largest_first].tolist()]


@njit(cache=True, nogil=True)
def _evidence(
    lintel: NDArray[np.bool_],
    free: NDArray[np.bool_],
    r0: float,
    c0: float,
    r1: float,
    c1: float,
    reach: float,
    passage: float,
) -> tuple[float, bool]:
    """
    Look at the surroundings of the line from (r0, c0) to (r1, c1), in cells.

    Returns the share of the line with a high return within ``reach`` across it, and whether
    free space goes on in its middle for ``passage`` on both sides.
    """
    length = np.hypot(r1 - r0, c1 - c0)
    d_row, d_col = (r1 - r0) / length, (c1 - c0) / length
    steps = int(np.floor(length)) + 1
    covered = 0
    is_open = np.zeros(2 * int(np.ceil(passage)) + 1, dtype=np.bool_)
    half = len(is_open) // 2
    for k in range(steps):
        along = length * (k + 0.5) / steps
        is_covered = False
        for offset in range(-max(half, int(reach)), max(half, int(reach)) + 1):
            row = int(np.rint(r0 + along * d_row - offset * d_col))
            col = int(np.rint(c0 + along * d_col + offset * d_row))
            if row < 0 or col < 0 or row >= free.shape[0] or col >= free.shape[1]:
                continue
            if abs(offset) <= reach and lintel[row, col]:
                is_covered = True
            if abs(offset) <= half and 0.35 * length <= along <= 0.65 * length:
                is_open[offset + half] |= free[row, col]
        covered += is_covered
    return covered / steps, bool(is_open.all())
