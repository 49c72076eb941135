# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From where on storeys can be told apart: walls of either that the other has not."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.pose import map_evidence
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.evaluation.sites.storeys_apart import Parting
from fpnet_lab.sim.drawn.distort import DrawnPlan

CELL_M = 0.05
MARGIN_M = 1.0
WALL_M = 2.0
T_SUBMAP_BUILDING = SE2.from_xy_yaw(-3.0, 7.0, 0.4)


def hall(*walls):
    """Return a hall of 8 by 12 m; inner walls of 2 m stand so many metres from its west side."""
    cells = np.full((160, 240), FREE, dtype=np.int8)
    cells[:2], cells[-2:], cells[:, :2], cells[:, -2:] = (OCCUPIED,) * 4
    for x in walls:
        cells[: round(WALL_M / CELL_M), round(x / CELL_M) : round(x / CELL_M) + 2] = OCCUPIED
    return GridMap(np.pad(cells, round(MARGIN_M / CELL_M), constant_values=UNKNOWN), CELL_M)


def drawn(grid, x, y, yaw):
    T_plan_building = SE2.from_xy_yaw(x, y, yaw)
    return DrawnPlan(replace(grid, T_frame_grid=T_plan_building @ grid.T_frame_grid),
                     T_plan_building)  # fmt: skip


def parting(own, other):
    return Parting.of(drawn(hall(*own), 5.0, -2.0, 1.1), drawn(hall(*other), -9.0, 4.0, 2.6))


def seen(grid, until_m=12.0):
    """Return the evidence of a submap that ends ``until_m`` from the west, in its own frame."""
    cells = grid.cells.copy()
    cells[:, round((MARGIN_M + until_m) / CELL_M) :] = UNKNOWN
    T_frame_grid = T_SUBMAP_BUILDING @ grid.T_frame_grid
    return map_evidence(replace(grid, cells=cells, T_frame_grid=T_frame_grid))


def test_equal_drawings_are_never_told_apart():
    assert parting([4.0], [4.0]).seen_m(seen(hall(4.0)), T_SUBMAP_BUILDING) == 0.0


@pytest.mark.parametrize(('own', 'other'), [([4.0, 8.0], [4.0]), ([4.0], [4.0, 8.0])])
def test_a_wall_tells_once_it_is_seen_or_seen_not_to_be_there(own, other):
    apart = parting(own, other)
    length_m = apart.seen_m(seen(hall(*own)), T_SUBMAP_BUILDING)
    assert 0.6 * WALL_M < length_m < 2.5 * WALL_M  # it has two sides, and an end in the wall
    assert apart.seen_m(seen(hall(*own), until_m=7.5), T_SUBMAP_BUILDING) == 0.0
