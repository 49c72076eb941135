# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames across corridors part nothing; frames between other spaces do."""

import cv2
import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.geometry import SE2
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.corridors import is_corridor_frame
from fpnet_core.types import FREE, OCCUPIED, GridMap

CELL_M = 0.05
CENTRE_M = np.array([12.0, 12.0])


def space(left_m, right_m, frame_m, angle_deg):
    """
    Two lengths of free space, 8 m each, of two widths, joined by a frame 0.3 m deep.

    Returns the grid, and the ends of the frame's line in rows and columns.
    """
    T = SE2.from_xy_yaw(*CENTRE_M, np.radians(angle_deg))
    cells = np.full((480, 480), OCCUPIED, np.uint8)
    for x0, x1, width in ((-8.0, -0.15, left_m), (0.15, 8.0, right_m), (-0.2, 0.2, frame_m)):
        y = width / 2.0
        corners = T.apply(np.array([[x0, -y], [x1, -y], [x1, y], [x0, y]])) / CELL_M - 0.5
        cv2.fillPoly(cells, [np.rint(corners * 16).astype(np.int32)], int(FREE), shift=4)
    ends = T.apply(np.array([[0.0, -frame_m / 2.0], [0.0, frame_m / 2.0]]))
    grid = GridMap(cells.astype(np.int8), CELL_M)
    return grid, grid.xy_to_rc(ends)


@pytest.mark.parametrize('angle_deg', [0.0, 33.0, 90.0])
@pytest.mark.parametrize(
    ('left_m', 'right_m', 'frame_m', 'is_frame'),
    [
        (1.8, 1.8, 1.5, True),
        (2.4, 2.4, 2.0, True),
        (2.0, 2.0, 0.9, False),  # a door in the middle of a corridor
        (1.8, 6.0, 1.6, False),  # a corridor's mouth at a hall
        (5.0, 5.0, 4.2, False),  # two rooms
    ],
)
def test_a_frame_is_told_by_the_corridor_behind_it(left_m, right_m, frame_m, is_frame, angle_deg):
    grid, ends = space(left_m, right_m, frame_m, angle_deg)
    assert is_corridor_frame(ends, grid.cells == FREE, CELL_M) is is_frame


def test_a_short_space_is_no_corridor():
    grid, ends = space(1.8, 1.8, 1.5, 0.0)
    cells = grid.cells.copy()
    cells[:, 290:] = OCCUPIED
    assert not is_corridor_frame(ends, cells == FREE, CELL_M)
    assert not is_corridor_frame(ends[[0, 0]], grid.cells == FREE, CELL_M)


def test_a_corridor_with_a_fire_door_is_one_room_and_with_a_narrow_door_two():
    counts = [
        len(segment_floorplan(space(1.8, 1.8, frame_m, 20.0)[0], SegmentationConfig()).rooms)
        for frame_m in (1.45, 0.9)
    ]
    assert counts == [1, 2]
