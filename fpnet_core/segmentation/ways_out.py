# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doors and gates to the outside: openings in the outer walls to unknown space."""

from __future__ import annotations

import numpy as np

from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pieces import pieces_of, reached_from_edge
from fpnet_core.segmentation.openings import MIN_DOOR_WIDTH_M
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, Segmentation

_GATE_M = 6.0  # physical: gates for lorries are narrower
_WALL_M = 0.8  # physical: outer walls are thinner
_OF_ROOM = 0.5  # chosen: over the root of a room's area; a room with a wider opening lacks a wall


def rooms_with_ways_out(segmentation: Segmentation, metres_per_unit: float = 1.0) -> set[int]:
    """
    Return the ids of rooms from which a door or gate leads outside.

    Such an opening is a group of free cells between walls next to unknown cells that extend to the
    grid's edge. ``metres_per_unit`` is true metres per metre of the segmentation.
    """
    cells = segmentation.grid.cells
    cell_m = segmentation.grid.resolution * metres_per_unit
    outside = reached_from_edge(cells == UNKNOWN)
    pieces, stats = pieces_of((cells == FREE) & grown(outside, 1))
    areas = {room.id: room.area_m2 * metres_per_unit**2 for room in segmentation.rooms}
    reach = max(1, round(_WALL_M / cell_m))
    found: set[int] = set()
    for number, (left, top, width, height) in enumerate(stats[1:, :4].tolist(), start=1):
        width_m = max(width, height) * cell_m
        if not MIN_DOOR_WIDTH_M <= width_m <= _GATE_M:
            continue
        rows = slice(max(top - reach, 0), top + height + reach)
        columns = slice(max(left - reach, 0), left + width + reach)
        end, part = pieces[rows, columns] == number, cells[rows, columns]
        jambs = grown(end, 1) & (part == OCCUPIED)
        inside, _ = pieces_of(part == FREE, connectivity=4)
        behind = segmentation.labels[rows, columns][np.isin(inside, inside[end])]
        near = set((np.unique(behind) - 1).tolist()) & areas.keys()
        if np.count_nonzero(jambs) > 1:
            found |= {room for room in near if width_m <= _OF_ROOM * areas[room] ** 0.5}
    return found
