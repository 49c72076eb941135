# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is measured at a line that may part two rooms."""

import cv2
import numpy as np
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.segmentation.door_figures import (
    LINE_FIGURES,
    LineMasks,
    line_figures,
    wall_direction,
)

CELL_M = 0.05


def doorway(angle_deg, width_m=1.0):
    """Two rooms of 4 by 3 m and 4 by 6 m with a doorway in a wall of 0.2 m; the line across it."""
    T = SE2.from_xy_yaw(8.0, 8.5, np.radians(angle_deg))
    free = np.zeros((340, 320), np.uint8)
    half = width_m / 2.0
    for x0, y0, x1, y1 in ((-4.1, -2, -0.1, 1), (0.1, -3, 4.1, 3), (-0.2, -half, 0.2, half)):
        corners = T.apply(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])) / CELL_M - 0.5
        cv2.fillPoly(free, [np.rint(corners * 16).astype(np.int32)], 1, shift=4)
    ends = T.apply(np.array([[0.0, -half], [0.0, half]])) / CELL_M - 0.5
    return free > 0, ends[:, ::-1]


def figures(free, ends, **masks):
    nothing = np.zeros_like(free)
    named = {name: masks.get(name, nothing) for name in ('unseen', 'furniture', 'lintel')}
    around = LineMasks(free, named['unseen'], named['furniture'], named['lintel'], CELL_M)
    (row,) = line_figures(ends[None], around)
    return dict(zip(LINE_FIGURES, row.tolist(), strict=True))


@pytest.mark.parametrize('angle_deg', [0.0, 27.0, 90.0, 211.0])
def test_a_doorway_has_its_width_and_walls_at_both_ends(angle_deg):
    found = figures(*doorway(angle_deg))
    assert found['width'] == pytest.approx(1.0, abs=0.02)
    assert found['met_least'] > 0.6
    assert found['wall_least'] > 0.4  # half a metre of wall, then the corner of the smaller room
    assert found['thick_least'] == pytest.approx(0.2, abs=0.1)
    assert found['ahead_least'] == pytest.approx(4.0, abs=0.2)
    assert found['off_walls'] < 0.05
    # A metre into the smaller room there are 0.5 and 1.5 m beside the doorway.
    assert found['least_narrow_3'] == pytest.approx(0.5, abs=0.15)
    assert found['unseen_most'] == found['furniture'] == found['lintel'] == 0.0


@pytest.mark.parametrize('angle_deg', [0.0, 10.0, 33.0, 60.0])
def test_walls_have_a_direction_but_for_quarter_turns(angle_deg):
    found = np.degrees(wall_direction(doorway(angle_deg)[0])) - angle_deg
    assert (found + 45.0) % 90.0 - 45.0 == pytest.approx(0.0, abs=1.0)
