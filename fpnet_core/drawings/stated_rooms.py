# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Segmentation from the rooms and doors that a file states."""

from __future__ import annotations

import numpy as np

from fpnet_core.drawings.model import FloorplanModel
from fpnet_core.drawings.model_raster import painted
from fpnet_core.segmentation.assemble import assemble
from fpnet_core.segmentation.gaps import openings_across
from fpnet_core.segmentation.openings import MIN_DOOR_WIDTH_M, Opening, find_openings
from fpnet_core.segmentation.scene import WorkRaster, clearance_m
from fpnet_core.types import FREE, GridMap, Segmentation


def stated_rooms(model: FloorplanModel, grid: GridMap) -> Segmentation:
    """
    Return the segmentation of a model's grid from its rooms and doors.

    A door joins the rooms on both sides of its line. Rooms that meet on free floor get an opening
    there even if no door is stated.
    """
    local = model.moved(grid.T_frame_grid.inv().matrix[:2])
    largest_first = sorted(local.rooms, key=lambda room: -room.area_m2)
    free = grid.cells == FREE
    labels = painted([room.rings for room in largest_first], grid.resolution, grid.shape)
    labels[~free] = 0
    lines = [grid.xy_to_rc(door.ends) for door in model.doors]
    doors = openings_across(lines, labels, grid.resolution)
    clearance = clearance_m(~free, grid.resolution)
    work = WorkRaster(free, clearance, np.zeros_like(free), 1, grid.resolution)
    others = find_openings(labels, work, free)
    least, known = MIN_DOOR_WIDTH_M / grid.resolution, [*doors]
    known += [each for each in others if _width(each) >= least and not _is_known(each, doors)]
    return assemble(grid, labels, known)


def _width(opening: Opening) -> float:
    """Return the width of an opening in cells."""
    return float(np.hypot(*(opening.ends_rc[1] - opening.ends_rc[0])))


def _is_known(opening: Opening, doors: list[Opening]) -> bool:
    """Return whether an opening coincides with a door between the same rooms."""
    middle = opening.ends_rc.mean(axis=0)
    return any(
        opening.rooms == door.rooms
        and np.hypot(*(door.ends_rc.mean(axis=0) - middle)) < _width(door)
        for door in doors
    )
