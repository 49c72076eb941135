# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from array import array
import math

import numpy as np
import pytest

from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import SE2
from fpnet_core.types import GridMap
from msg_adapters.grids import grid_from_msg, grid_to_msg

YAW = math.radians(37.0)


def _grid() -> GridMap:
    cells = np.full((3, 5), -1, dtype=np.int8)
    cells[0, 1:4] = 0
    cells[2, 4] = 100
    return GridMap(cells, 0.05, SE2.from_xy_yaw(-4.5, 11.25, YAW), 'plan')


def test_grid_survives_the_round_trip_with_a_rotated_origin(received):
    grid = _grid()
    msg = received(grid_to_msg(grid, 1_700_000_000_123_456_789, 'floorplan'))
    assert msg.header.frame_id == 'floorplan'
    back = grid_from_msg(msg)
    np.testing.assert_array_equal(back.cells, grid.cells)
    assert back.resolution == 0.05
    assert back.frame == 'plan'
    np.testing.assert_allclose(back.T_frame_grid.matrix, grid.T_frame_grid.matrix, atol=1e-12)
    # Centre of the wall cell (row 2, col 4): (0.225, 0.125) turned by 37 deg, then shifted.
    expected = [
        -4.5 + 0.225 * math.cos(YAW) - 0.125 * math.sin(YAW),
        11.25 + 0.225 * math.sin(YAW) + 0.125 * math.cos(YAW),
    ]
    np.testing.assert_allclose(back.rc_to_xy((2, 4)), expected, atol=1e-9)


def test_probabilities_become_three_values():
    msg = grid_to_msg(GridMap(np.zeros((1, 8), dtype=np.int8), 0.1), 0, 'floorplan')
    msg.data = array('b', [-1, 0, 24, 25, 65, 66, 100, -128])
    assert grid_from_msg(msg).cells[0].tolist() == [-1, 0, 0, -1, -1, 100, 100, -1]


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        (lambda m: setattr(m, 'data', array('b', [0] * 14)), 'data has 14 cells'),
        (lambda m: setattr(m.info, 'width', 0), 'empty'),
        (lambda m: (setattr(m.info, 'width', 2**20), setattr(m.info, 'height', 2**20)), 'large'),
        (lambda m: setattr(m.info, 'resolution', 0.0), 'resolution'),
        (lambda m: setattr(m.info, 'resolution', -0.05), 'resolution'),
        (lambda m: setattr(m.info, 'resolution', math.nan), 'resolution'),
        (lambda m: setattr(m.info.origin.position, 'x', math.inf), 'origin'),
        (lambda m: setattr(m.info.origin.orientation, 'x', 0.7), 'tilted'),
    ],
)
def test_unusable_grids_are_refused(change, message):
    msg = grid_to_msg(_grid(), 0, 'floorplan')
    change(msg)
    with pytest.raises(MapFormatError, match=message):
        grid_from_msg(msg)


def test_origin_without_orientation_is_refused():
    msg = grid_to_msg(_grid(), 0, 'floorplan')
    msg.info.origin.orientation.w = 0.0
    msg.info.origin.orientation.z = 0.0
    with pytest.raises(MapFormatError, match='quaternion'):
        grid_from_msg(msg)
