# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From the walls of a drawing of unknown scale to cells: free inside, else unknown."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.outside import inside_of
from fpnet_core.segmentation.distance import cells_to_nearest
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

Mask = NDArray[np.bool_]

_LOOK_PX = 260  # the longer side of the picture in which the reach is looked for
_REACHES = np.geomspace(0.005, 0.05, 8)  # of the longer side: half the gaps that may be closed
_STEADY = 1.06  # a building that is closed grows no more than this where larger gaps are closed
_MOST = 0.6  # of the largest space that any reach encloses is a building, not a part of it
_SPARE = 1.25  # the reach is so much wider than the widest gap seen
_WALL_SHARE = 0.02  # of the longer side: what is deeper in the ink than this says nothing


def cells_of(walls: Mask, ground: Mask | None = None) -> NDArray[np.int8] | None:
    """
    Return the cells (H, W) of a building with ``walls (H, W)``; None where nothing is enclosed.

    Windows, gates and gaps of the outer wall do not let the outside in, however wide they are:
    the reach that closes them is the least at which what is enclosed stays as it is. Other
    lines of the drawing, whose inside is ``ground (H, W)``, end it where they close a window.
    """
    inside = inside_of_lines(walls)
    if inside is None:
        return None
    if ground is not None:
        inside &= ground
    if not inside.any():
        return None
    inside &= ~walls
    depth = _WALL_SHARE * max(walls.shape)
    is_face = walls & (cells_to_nearest(inside) <= depth)
    return np.select([inside, is_face], [FREE, OCCUPIED], UNKNOWN).astype(np.int8)


def inside_of_lines(lines: Mask) -> Mask | None:
    """Return what lines (H, W) enclose, with the lines; None where they enclose nothing."""
    reach = _closing_reach(lines)
    inside = None if reach is None else inside_of(~lines, reach, _distance)
    return None if inside is None else inside | lines


def _distance(mask: Mask) -> NDArray[np.float32]:
    return cells_to_nearest(~mask)


def _closing_reach(walls: Mask) -> float | None:
    """Return the least reach [px] that closes the building; None where none does."""
    factor = max(1.0, max(walls.shape) / _LOOK_PX)
    small = reduced(walls, factor)
    reaches = _REACHES * max(small.shape)
    areas = np.array([_enclosed_area(small, reach) for reach in reaches])
    if not areas.any():
        return None
    for k in range(len(reaches) - 2):
        is_most = areas[k] > _MOST * areas.max()
        if is_most and areas[k + 2] < _STEADY * areas[k]:
            return float(_SPARE * reaches[k] * factor)
    return float(reaches[-1] * factor)


def _enclosed_area(walls: Mask, reach: float) -> float:
    margin = int(reach) + 2
    free = np.pad(~walls, margin, constant_values=True)
    clear = (cells_to_nearest(~free) > reach).astype(np.uint8)
    _, core = cv2.connectedComponents(clear, connectivity=4)
    outside = cells_to_nearest(core == core[0, 0]) <= reach + 1.0
    return float(np.count_nonzero(free & ~outside))


def reduced(mask: Mask, factor: float) -> Mask:
    """Return which pixels of the picture reduced by ``factor`` hold a line."""
    if factor <= 1.0:
        return mask
    size = [max(1, round(side / factor)) for side in mask.shape[::-1]]
    shares = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    # A line of one pixel anywhere in a block counts.
    return np.asarray(shares > min(0.45, 0.5 / factor))
