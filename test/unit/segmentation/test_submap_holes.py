# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A hole that scans have left in a wall beside a door is no second door."""

import numpy as np
import pytest

from fpnet_core.segmentation import segment_submap
from fpnet_core.types import FREE, OCCUPIED, GridMap, Submap

CELL_M = 0.05


def two_rooms(hole_m, sees_lintels, doors=1):
    """Two rooms of 4 x 6 m, ``doors`` 0.9 m wide in the wall between them, and a hole."""
    cells = np.full((128, 172), OCCUPIED, dtype=np.int8)
    cells[4:124, 4:84] = cells[4:124, 88:168] = FREE
    lintel = np.zeros(cells.shape, dtype=bool)
    for k in range(doors):
        door = np.s_[20 + 64 * k : 38 + 64 * k, 84:88]
        cells[door], lintel[door] = FREE, sees_lintels
    cells[98 : 98 + round(hole_m / CELL_M), 84:88] = FREE
    return Submap(GridMap(cells, CELL_M), lintel, np.zeros((0, 2)))


@pytest.mark.parametrize(
    ('hole_m', 'sees_lintels', 'count'),
    [
        (0.5, False, 1),  # narrower than a door
        (0.8, False, 2),
        (0.8, True, 1),  # a door would have a lintel
        (0.0, True, 1),
    ],
)
def test_a_hole_beside_a_door_is_no_door(hole_m, sees_lintels, count):
    segmentation = segment_submap(two_rooms(hole_m, sees_lintels))
    assert [room.area_m2 for room in segmentation.rooms] == pytest.approx([24.0, 24.0], rel=0.02)
    assert len(segmentation.portals) == count
    (door, *_) = sorted(segmentation.portals, key=lambda portal: -portal.width_m)
    assert door.width_m == pytest.approx(0.9, abs=0.1)
    assert door.has_lintel == sees_lintels


@pytest.mark.parametrize('sees_lintels', [True, False])
def test_two_doors_between_the_same_rooms_stay(sees_lintels):
    segmentation = segment_submap(two_rooms(0.0, sees_lintels, doors=2))
    assert [portal.width_m for portal in segmentation.portals] == pytest.approx(
        [0.9, 0.9], abs=0.1
    )


def test_a_hole_without_a_door_is_the_opening_of_its_rooms():
    (portal,) = segment_submap(two_rooms(0.8, True, doors=0)).portals
    assert portal.width_m == pytest.approx(0.8, abs=0.1)
