# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much a reading looks like a building, in figures that need no scale."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.types import FREE, OCCUPIED, GridMap, Segmentation

Array = NDArray[np.float64]

FEATURES = (
    'rooms', 'largest', 'door_to_room', 'doored', 'doors', 'square', 'squarest', 'door_spread',
    'ink', 'wall_to_door', 'specks', 'used', 'small', 'long', 'closed', 'spread',
)  # fmt: skip


def features(segmentation: Segmentation) -> Array:
    """Return the figures (F,) of a reading, in the order of ``FEATURES``; zeros without rooms."""
    rooms = segmentation.rooms
    if not rooms:
        return np.zeros(len(FEATURES))
    grid = segmentation.grid
    area = np.array([room.area_m2 for room in rooms])
    width = np.array([portal.width_m for portal in segmentation.portals])
    doored = {room for portal in segmentation.portals for room in portal.rooms}
    sides = np.array([_sides(room.polygon) for room in rooms])
    square = area / np.maximum(sides.prod(axis=1), area)
    median = float(np.median(area))
    door = float(np.median(width)) if width.size else np.sqrt(median)
    occupied, free = (int(np.count_nonzero(grid.cells == k)) for k in (OCCUPIED, FREE))
    return np.array([
        np.log(len(rooms)),
        area.max() / area.sum(),
        np.log(door / np.sqrt(median)),
        sum(room.id in doored for room in rooms) / len(rooms),
        np.log((len(width) + 1) / len(rooms)),
        float(np.mean(square)),
        float(np.average(square, weights=area)),
        float(np.std(np.log(width))) if width.size else 1.0,
        occupied / (occupied + free),
        np.log(_wall_width(grid) * grid.resolution / door),
        np.log1p(_specks(grid, door) / len(rooms)),
        area.sum() / (free * grid.resolution**2),
        float(np.mean(area < 0.15 * median)),
        float(np.log(np.median(sides.max(axis=1) / sides.min(axis=1)))),
        float(not width.size),
        float(np.std(np.log(area))),
    ])  # fmt: skip


def _sides(ring: Array) -> tuple[float, float]:
    _, size, _ = cv2.minAreaRect(ring.astype(np.float32))
    return max(size[0], 1e-6), max(size[1], 1e-6)


def _wall_width(grid: GridMap) -> float:
    """Return the mean width of walls in cells: twice their area over their outline."""
    walls = (grid.cells == OCCUPIED).astype(np.uint8)
    outline = walls - cv2.erode(walls, np.ones((3, 3), np.uint8))
    return 2.0 * float(walls.sum() + 1) / float(outline.sum() + 1)


def _specks(grid: GridMap, door: float) -> int:
    """Count the pieces of ink that are shorter than a door is wide."""
    walls = (grid.cells == OCCUPIED).astype(np.uint8)
    _, _, stats, _ = cv2.connectedComponentsWithStats(walls, connectivity=8)
    extent = stats[1:, 2:4].max(axis=1, initial=0) * grid.resolution
    return int(np.count_nonzero(extent < door))
