# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Removal of lines thinner than walls: dimensions, wires, panels of sliding doors.

If such lines are parsed as walls, they close doorways and split rooms into parts without doors.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.hypothesis import PlanHypothesis
from fpnet_core.drawings.pictures.thickness import THIN, thin_walls
from fpnet_core.raster.morphology import Mask, opened_by, shrunk, square
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.types import FREE, OCCUPIED, Segmentation

# Numerical: thicknesses of the lines that are removed, in cells.
_SIDES = (2, 3, 4, 6, 8, 12)
# Chosen, not measured:
_USUAL_SHARE = 0.5  # of the area of walls belongs to walls that are thicker than the removed lines


def without_thin_lines(found: PlanHypothesis, config: SegmentationConfig) -> PlanHypothesis:
    """
    Return a building without thin lines that separate rooms from their doors.

    As few lines as needed are removed, and none if fewer rooms have doors without them: then they
    are walls. Robot maps are returned unchanged.
    """
    if found.seen is None:
        return found
    best, (doored, doorless) = found, _counted(found.segmentation)
    for cells in _thinned(found.cells):
        if not doorless:
            break
        other = found.with_cells(cells, config)
        others = _counted(other.segmentation)
        if others[0] >= doored and others[1] < doorless:
            best, doorless = other, others[1]
    return best


def _thinned(cells: NDArray[np.int8]) -> Iterator[NDArray[np.int8]]:
    """
    Yield cells (H, W) with increasingly thick lines removed, up to the thickness of walls.

    Whole lines are removed: parts of one would look like walls with doors between them.
    """
    walls = cells == OCCUPIED
    sides = [side for side in _SIDES if _is_thin(walls, side)]
    lines = thin_walls(walls, max(sides, default=0))
    labels, figures = pieces_of(lines)
    edge = np.bincount(labels[lines & ~shrunk(lines, 1)], minlength=len(figures))
    thickness = 2.0 * figures[:, 4] / np.maximum(edge, 1)
    thickness[0] = np.inf
    last = np.zeros_like(thickness, np.bool_)
    for side in sides:
        is_removed = thickness <= side
        if (is_removed != last).any():
            yield np.where(is_removed[labels], FREE, cells).astype(np.int8)
        last = is_removed


def _is_thin(walls: Mask, side: int) -> bool:
    """Return whether most of the walls (H, W) are much thicker than ``side`` cells."""
    usual = opened_by(walls, square(round(side / THIN)))
    return bool(np.count_nonzero(usual) >= _USUAL_SHARE * np.count_nonzero(walls))


def _counted(segmentation: Segmentation) -> tuple[int, int]:
    """Return the number of rooms with doors and of those without."""
    doored = {room for portal in segmentation.portals for room in portal.rooms} - {None}
    return len(doored), len(segmentation.rooms) - len(doored)
