# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Rasterization of a floorplan model to an occupancy grid.

Doors are free, windows are occupied. Without rooms, the floor is the area that walls, windows and
closed doors separate from the outside.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.model import FloorplanModel, ModelDoor, ModelWindow, Rings
from fpnet_core.drawings.types import Array
from fpnet_core.raster.pixels import PIXEL_BITS, fixed_point
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

WALL_M = 0.1
"""Physical: thickness of partitions, and of walls that a model states as single lines [m]."""

_SHUT = 0.5  # of the outline's area: if less floor is enclosed, the walls leak; chosen
_FAR = 4.0  # numerical: corners are clipped to this many raster sizes
_LEAST_M2 = 1.0  # chosen: smaller enclosed areas are hollows of walls

Mask = NDArray[np.bool_]


def model_grid(model: FloorplanModel, cell_m: float, shape: tuple[int, int]) -> GridMap:
    """
    Return a model as a grid of ``shape`` (rows, columns), whose first cell starts at (0, 0).

    The outside and all cells without information are unknown. Without rooms, and with walls that
    leak, the building's outline is the floor. Doors are free if they adjoin floor.
    """
    walls = wall_mask(model, cell_m, shape)
    more_m = 2.0 * cell_m + (0.0 if model.walls else WALL_M)
    doors = _openings(model.doors, cell_m, shape, more_m)
    floor = _areas([room.rings for room in model.rooms], cell_m, shape)
    if not model.rooms:
        floor = _floor(model, walls | doors, cell_m) & ~doors
    cells = np.full(shape, UNKNOWN, np.int8)
    cells[floor] = FREE
    cells[walls] = OCCUPIED
    cells[doors & ~_unconnected(doors, floor & ~walls)] = FREE
    return GridMap(cells, cell_m)


def wall_mask(model: FloorplanModel, cell_m: float, shape: tuple[int, int]) -> Mask:
    """
    Return the mask of walls and windows; doors are not yet subtracted.

    If the model has no walls, they are drawn along the outlines of its rooms.
    """
    walls = _areas([wall.rings for wall in model.walls], cell_m, shape)
    if not model.walls:
        lines = [ring for room in model.rooms for ring in room.rings]
        walls = _drawn(lines, cell_m, shape)
    return walls | _openings(model.windows, cell_m, shape, 0.0)


def _floor(model: FloorplanModel, shut: Mask, cell_m: float) -> Mask:
    """Return the mask of enclosed cells; if walls leak, that of the outline."""
    floor = enclosed(shut, cell_m)
    outline = _areas([(ring,) for ring in model.outline], cell_m, (shut.shape[0], shut.shape[1]))
    leaks = np.count_nonzero(floor & outline) < _SHUT * np.count_nonzero(outline)
    return outline if leaks else floor


def enclosed(shut: Mask, cell_m: float) -> Mask:
    """Return the mask of areas enclosed by ``shut`` cells, without small hollows."""
    open_cells = np.pad(~shut, 1, constant_values=True).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(open_cells, connectivity=4)
    is_room = stats[:, cv2.CC_STAT_AREA] * cell_m**2 >= _LEAST_M2
    is_room[0] = is_room[labels[0, 0]] = False
    inside: Mask = is_room[labels[1:-1, 1:-1]]
    return inside


def _unconnected(doors: Mask, floor: Mask) -> Mask:
    """Return the mask of doors without adjoining floor: those of other parts of the storey."""
    _, labels = cv2.connectedComponents(doors.astype(np.uint8), connectivity=8)
    beside = cv2.dilate(floor.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    is_connected = np.zeros(int(labels.max()) + 1, dtype=np.bool_)
    is_connected[np.unique(labels[beside & doors])] = True
    unconnected: Mask = doors & ~is_connected[labels]
    return unconnected


def _areas(areas: list[Rings], cell_m: float, shape: tuple[int, int]) -> Mask:
    """Return the mask of the union of areas, each given as rings with holes."""
    return painted(areas, cell_m, shape) > 0


def painted(areas: list[Rings], cell_m: float, shape: tuple[int, int]) -> NDArray[np.int32]:
    """Return the 1-based index of the last area that covers each cell; 0 for none."""
    numbers = np.zeros(shape, np.int32)
    for number, rings in enumerate(areas, start=1):
        corners = [_corners(ring, cell_m, shape) for ring in rings]
        low = np.min([each.min(axis=0) for each in corners], axis=0) >> PIXEL_BITS
        high = (np.max([each.max(axis=0) for each in corners], axis=0) >> PIXEL_BITS) + 2
        x0, y0 = np.clip(low, 0, shape[::-1])
        x1, y1 = np.clip(high, 0, shape[::-1])
        if x0 < x1 and y0 < y1:
            part = np.zeros((y1 - y0, x1 - x0), np.uint8)
            offset = np.array([x0, y0], np.int32) << PIXEL_BITS
            moved = [(each - offset).astype(np.int32) for each in corners]
            cv2.fillPoly(part, moved, 1, cv2.LINE_8, PIXEL_BITS)
            numbers[y0:y1, x0:x1][part > 0] = number
    return numbers


def _drawn(lines: list[Array], cell_m: float, shape: tuple[int, int]) -> Mask:
    """Return the mask of closed lines drawn at wall thickness."""
    mask = np.zeros(shape, np.uint8)
    thickness = max(round(WALL_M / cell_m), 1)
    corners = [_corners(line, cell_m, shape) for line in lines]
    cv2.polylines(mask, corners, True, 1, thickness, cv2.LINE_8, PIXEL_BITS)
    return mask > 0


def _corners(ring: Array, cell_m: float, shape: tuple[int, int]) -> NDArray[np.int32]:
    """Return corners [m] in OpenCV's fixed-point pixels, clipped far outside of the raster."""
    far = _FAR * max(shape)
    return fixed_point(np.clip(ring / cell_m - 0.5, -far, far))


def _openings(
    openings: tuple[ModelDoor, ...] | tuple[ModelWindow, ...],
    cell_m: float,
    shape: tuple[int, int],
    more_m: float,
) -> Mask:
    """Return the mask of openings, ``more_m`` deeper than their walls."""
    return _areas([(rectangle(each, more_m, cell_m),) for each in openings], cell_m, shape)


def rectangle(
    opening: ModelDoor | ModelWindow, more_m: float = 0.0, least_m: float = 0.0
) -> Array:
    """Return the corners (4, 2) of an opening: wall depth + ``more_m``, at least ``least_m``."""
    start, end = opening.ends
    along = (end - start) / np.hypot(*(end - start))
    depth = max((opening.depth_m or WALL_M) + more_m, least_m)
    across = 0.5 * depth * np.array([-along[1], along[0]])
    return np.array([start - across, end - across, end + across, start + across])
