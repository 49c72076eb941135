# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doorways detected by their lintels: the paper's prior that doors are lower than ceilings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import pieces_of_few
from fpnet_core.raster.rays import cells_at, draw_line, values_at
from fpnet_core.raster.windows import first_of_each
from fpnet_core.segmentation.gaps import labels_beside
from fpnet_core.segmentation.openings import (
    MIN_DOOR_WIDTH_M,
    THICK_WALL_M,
    Opening,
    narrowest_lines,
)

Array = NDArray[np.float64]

# Physical: largest width of a doorway [m].
_MAX_WIDTH_M = 3.0
# Physical: high returns this near to the opening line belong to it [m].
_LINE_REACH_M = THICK_WALL_M / 2.0
# Physical: search range for rooms on both sides of the line, the thickness of outer walls [m].
_ROOM_REACH_M = 0.8
# Chosen, not measured:
# Least share of the opening line with high returns near it.
_MIN_COVERAGE = 0.35
# Free space must extend this far on both sides of a doorway [m].
_PASSAGE_M = 0.4
# Free space must extend between these shares of a doorway's length.
_MIDDLE = 0.35, 0.65
# Numerical: samples along a doorway when its rooms are searched for.
_BESIDE_PLACES = 7


@dataclass(frozen=True, eq=False)
class Doorway:
    """A doorway's closing line ``ends_rc (2, 2)`` in cells of the full raster."""

    ends_rc: Array
    cell_m: float
    has_lintel: bool = True

    def between(self, labels: NDArray[np.int32]) -> Opening:
        """Return the opening with the nearest rooms of ``labels (H, W)`` on both sides."""
        reach = _ROOM_REACH_M / self.cell_m
        low, high = sorted(_first_labels(labels, self.ends_rc, reach))
        half_m = 0.5 * math.dist(*self.ends_rc.tolist()) * self.cell_m
        return Opening((low, high), self.ends_rc, half_m, self.has_lintel)


def _first_labels(labels: NDArray[np.int32], ends: Array, reach: float) -> list[int]:
    """Return, for each side, the most frequent label on the nearest parallel line with a room."""
    along = ends[1] - ends[0]
    places = ends[0] + np.linspace(0.2, 0.8, _BESIDE_PLACES)[:, None] * along
    across = np.array([-along[1], along[0]]) / np.hypot(*along)
    found = []
    for side in labels_beside(labels, places, across, reach - 1.0):
        met = side[(side > 0).any(axis=1)]
        known, votes = np.unique(met[:1][met[:1] > 0], return_counts=True)
        found.append(int(known[votes.argmax()]) if len(known) else 0)
    return found


def find_lintels(
    lintel: Mask,
    free: Mask,
    wall: Mask,
    cell_m: float,
    known: Sequence[Doorway] = (),
    held: Mask | None = None,
) -> tuple[Mask, list[Doorway]]:
    """
    Detect doorways from high returns over free space, and close them.

    Parameters
    ----------
    lintel : (H, W) bool, free cells below a high return
    free : (H, W) bool
    wall : (H, W) bool, cells at or near a wall; both ends of a doorway lie there
    cell_m : cell edge [true metres]
    known : doorways that are already known
    held : (H, W) bool, cells where no further doorway's centre may lie; None for no such cells

    Returns
    -------
    closed (H, W) bool : cells of the closing lines, which no region may cross
    doors : ``known`` and one per further doorway, largest evidence first; high returns that span
        no doorway (shelves, ducts, beams) close nothing
    """
    closed = np.zeros(lintel.shape, dtype=np.uint8)
    doors = list(known)
    for door in known:
        draw_line(closed, door.ends_rc)
    lines = np.array([door.ends_rc for door in doors]).reshape(-1, 2, 2)
    centres = _centres(lintel, cell_m)
    if held is not None:
        centres = centres[~held[tuple(centres.T)]]
    reach, least = (np.full(len(centres), m / cell_m) for m in (_MAX_WIDTH_M, MIN_DOOR_WIDTH_M))
    across = narrowest_lines(
        free, centres.astype(np.float64), reach, _LINE_REACH_M / cell_m, least
    )
    for centre, ends in zip(centres, across, strict=True):
        if _is_beside(lines, centre, cell_m):
            continue
        apart = lines.mean(axis=1) - ends.mean(axis=0)
        is_new = (np.hypot(*apart.T) * cell_m >= MIN_DOOR_WIDTH_M).all()
        if is_new and _is_doorway(ends, lintel, free, wall, cell_m):
            doors.append(Doorway(ends, cell_m))
            lines = np.concatenate([lines, ends[None]])
            draw_line(closed, ends)
    return closed.view(np.bool_) & free, doors


def _is_doorway(ends: Array, lintel: Mask, free: Mask, wall: Mask, cell_m: float) -> bool:
    """Return whether a line is as wide as a door, under high returns, in a wall, and passable."""
    width_m = math.dist(ends[0], ends[1]) * cell_m
    if not MIN_DOOR_WIDTH_M <= width_m <= _MAX_WIDTH_M:
        return False
    if not wall[cells_at(ends, wall.shape)].all():
        return False
    reach, passage = _LINE_REACH_M / cell_m, _PASSAGE_M / cell_m
    covered, passes = _evidence(lintel, free, ends, reach, passage)
    return bool(covered >= _MIN_COVERAGE and passes)


def _is_beside(lines: Array, place: NDArray[np.int64], cell_m: float) -> bool:
    """Return whether a place (2,) lies near one of the lines with ends ``lines (D, 2, 2)``."""
    along, off = lines[:, 1] - lines[:, 0], place - lines[:, 0]
    share = (off * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), 1e-9)
    apart = off - np.clip(share, 0.0, 1.0)[:, None] * along
    return bool((np.hypot(*apart.T) * cell_m <= _LINE_REACH_M).any())


def _centres(lintel: Mask, cell_m: float) -> NDArray[np.int64]:
    """
    Return the central cell (N, 2) of each component of high returns, largest first.

    Cells with too few high returns around them to cover even the narrowest doorway are ignored.
    """
    window = 2 * round(MIN_DOOR_WIDTH_M / cell_m) + 1
    around = cv2.boxFilter(lintel.view(np.uint8), cv2.CV_16S, (window, window), normalize=False)
    fewest = math.ceil(_MIN_COVERAGE * MIN_DOOR_WIDTH_M / cell_m)
    cells, owner = pieces_of_few(lintel & (np.asarray(around) >= fewest))
    size = np.bincount(owner)
    centroid = np.stack([np.bincount(owner, along) for along in cells.T], axis=1) / size[:, None]
    off_centre = np.hypot(*(cells - centroid[owner]).T)
    # Sorted by owner first: the first of each then follow the order of the components.
    nearest = first_of_each(owner, np.lexsort((off_centre, owner)))
    largest_first = np.argsort(-size, kind='stable')
    return np.asarray(cells[nearest][largest_first])


def _evidence(
    lintel: Mask, free: Mask, ends: Array, reach: float, passage: float
) -> tuple[float, bool]:
    """
    Measure the evidence for a doorway at the line with ``ends (2, 2)``, in cells.

    Returns the share of the line with a high return within ``reach`` across it, and whether free
    space extends for ``passage`` on both sides of its middle.
    """
    along = ends[1] - ends[0]
    length = np.hypot(*along)
    across = np.array([-along[1], along[0]]) / length
    steps, half = int(np.floor(length)) + 1, int(np.ceil(passage))
    shares = (np.arange(steps) + 0.5) / steps
    offsets = np.arange(-max(half, int(reach)), max(half, int(reach)) + 1)
    places = ends[0] + shares[:, None, None] * along + offsets[:, None] * across
    is_covered = values_at(lintel, places[:, np.abs(offsets) <= reach], False).any(axis=1)
    middle = places[(shares >= _MIDDLE[0]) & (shares <= _MIDDLE[1])][:, np.abs(offsets) <= half]
    return float(is_covered.mean()), bool(values_at(free, middle, False).any(axis=0).all())
