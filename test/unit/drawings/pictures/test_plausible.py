# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What no building is like, told by its rooms and doors."""

import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.plausible import findings
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

CONFIG = SegmentationConfig()


def building(doors=True):
    """A hall of 12 m x 8 m and four rooms beside it, at 5 cm."""
    cells = np.full((240, 440), UNKNOWN, np.int8)
    cells[30:210, 30:380] = OCCUPIED
    cells[36:204, 36:270] = FREE
    for k in range(4):
        cells[36 + 43 * k : 75 + 43 * k, 276:374] = FREE
    for k in range(4) if doors else ():
        rows = slice(44 + 43 * k, 59 + 43 * k)
        cells[rows, 270:276] = FREE
    return cells


def test_a_hall_into_which_rooms_open_is_no_giant():
    segmentation = segment_floorplan(GridMap(np.pad(building(), 1), 0.05), CONFIG)
    shut = segment_floorplan(GridMap(building(doors=False), 0.05), CONFIG)
    assert not [said for said in findings(segmentation) if 'One room' in said]
    areas = sorted(room.area_m2 for room in shut.rooms)
    assert areas[-1] / sum(areas) == pytest.approx(0.7, abs=0.15)


def units(rooms, corridor_doors=0):
    """
    Six units side by side above a corridor of 24 m, each of ``rooms`` that doors join.

    Doors lead from the corridor into the first ``corridor_doors`` of them.
    """
    high = 60 * rooms
    cells = np.full((high + 60, 506), OCCUPIED, np.int8)
    cells[high + 13 : high + 47, 13:493] = FREE
    for unit in range(6):
        left = 13 + 80 * unit
        for room in range(rooms):
            cells[13 + 60 * room : 67 + 60 * room, left : left + 74] = FREE
        for wall in range(rooms if unit < corridor_doors else rooms - 1):
            cells[66 + 60 * wall : 74 + 60 * wall, left + 30 : left + 48] = FREE
    return segment_floorplan(GridMap(np.pad(cells, 8, constant_values=UNKNOWN), 0.05), CONFIG)


@pytest.mark.parametrize(
    ('rooms', 'corridor_doors', 'is_doubted'),
    [(2, 0, True), (2, 3, True), (2, 4, False), (2, 6, False), (3, 0, False)],
)
def test_rooms_that_no_door_joins_are_doubted_and_dwellings_in_a_row_are_not(
    rooms, corridor_doors, is_doubted
):
    segmentation = units(rooms, corridor_doors)
    assert len(segmentation.rooms) == 6 * rooms + 1
    assert len(segmentation.portals) == 6 * (rooms - 1) + corridor_doors
    most = rooms * corridor_doors + 1 if corridor_doors else rooms
    said = f'No more than {most} of {6 * rooms + 1} rooms are joined by doors: '
    assert any(said in finding for finding in findings(segmentation)) == is_doubted
