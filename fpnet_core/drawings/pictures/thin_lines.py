# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Lines that are thinner than walls: dimensions, wires, panels of doors that slide.

A reading that has them for walls is cut by them: pieces of rooms have no door, and what is drawn
in a doorway shuts it.
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

# Numerical: lines go that are as thin as so many cells.
_SIDES = (2, 3, 4, 6, 8, 12)
# Chosen, not measured:
_USUAL_SHARE = 0.5  # of the area of all walls is that of those at least as thick as the usual one


def without_thin_lines(found: PlanHypothesis, config: SegmentationConfig) -> PlanHypothesis:
    """
    Return a building without lines that are thinner than walls, where they take rooms' doors.

    No more are left out than it takes, and none where fewer rooms have doors without them: then
    they are walls. A robot's map is what it shows.
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
    Yield cells (H, W) without ever thicker lines, as long as they are thinner than walls.

    Lines go as wholes: pieces that stay of one look like walls with doors between them.
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
        is_gone = thickness <= side
        if (is_gone != last).any():
            yield np.where(is_gone[labels], FREE, cells).astype(np.int8)
        last = is_gone


def _is_thin(walls: Mask, side: int) -> bool:
    """Tell whether most of the walls (H, W) are much thicker than ``side`` cells."""
    usual = opened_by(walls, square(round(side / THIN)))
    return bool(np.count_nonzero(usual) >= _USUAL_SHARE * np.count_nonzero(walls))


def _counted(segmentation: Segmentation) -> tuple[int, int]:
    """Count the rooms that have doors and those that have none."""
    doored = {room for portal in segmentation.portals for room in portal.rooms} - {None}
    return len(doored), len(segmentation.rooms) - len(doored)
