# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compile what the first tick would otherwise wait for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.localizer.localizer import Localizer
from fpnet_core.types import FREE, OCCUPIED, GridMap, MatchResult, RegionGraph

# Two rooms side by side with a door between them, inner sizes in metres.
_ROOM_M = np.array([6.0, 5.0])
_WALL_M, _DOOR_M, _RESOLUTION_M = 0.2, 1.0, 0.1
_HEIGHTS_M = np.linspace(-0.8, 1.6, 25)
_SPACING_M = 0.05


class _NoMatcher:
    """Finds every pair equally likely: the raster stages get work without a network."""

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        shape = len(plan), len(sub)
        even = np.full(shape, 1.0 / (1.0 + max(*shape, 1)), dtype=np.float32)
        pairs = np.zeros((0, 2), dtype=np.int64)
        return MatchResult(pairs, np.zeros(0, dtype=np.float32), even)


def warm_up(config: FpnetConfig) -> None:
    """
    Run every compiled stage once on a toy floorplan.

    The compiler's cache is keyed by where the package lies, so the first run after an
    installation takes several seconds for this, later ones a fraction of one. A robot that
    starts to drive meanwhile would lose scans.
    """
    localizer = Localizer(config, _NoMatcher())
    localizer.set_plan(_toy_plan())
    scan = _toy_scan()
    for index in range(2):
        localizer.add_scan(scan, np.eye(4), index + 1)
        localizer.tick(index + 1)


def _toy_plan() -> GridMap:
    room, wall, door = (
        np.round(np.asarray(metres) / _RESOLUTION_M).astype(int)
        for metres in (_ROOM_M, _WALL_M, _DOOR_M)
    )
    columns, rows = room
    cells = np.full((rows + 2 * wall, 2 * columns + 3 * wall), OCCUPIED, dtype=np.int8)
    cells[wall:-wall, wall : wall + columns] = FREE
    cells[wall:-wall, -wall - columns : -wall] = FREE
    cells[2 * wall : 2 * wall + door, wall + columns : 2 * wall + columns] = FREE
    return GridMap(cells, _RESOLUTION_M)


def _toy_scan() -> NDArray[np.float32]:
    """Return wall points (P, 3) of the left room, its door open, from the room's centre."""
    width, depth = _ROOM_M
    x, y = (np.arange(0.0, length, _SPACING_M) - length / 2 for length in (width, depth))
    right = y[np.abs(y + depth / 2 - _WALL_M - _DOOR_M / 2) > _DOOR_M / 2]
    outline = np.concatenate(
        [
            np.column_stack([x, np.full_like(x, -depth / 2)]),
            np.column_stack([x, np.full_like(x, depth / 2)]),
            np.column_stack([np.full_like(y, -width / 2), y]),
            np.column_stack([np.full_like(right, width / 2), right]),
        ]
    )
    points = np.empty((len(_HEIGHTS_M), len(outline), 3), dtype=np.float32)
    points[..., :2] = outline
    points[..., 2] = _HEIGHTS_M[:, None]
    return points.reshape(-1, 3)
