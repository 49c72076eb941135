# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scores of submap segmentation on a drawn submap of a known two-room plan."""

import numpy as np
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.segmentation import segment_submap
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap
from fpnet_lab.evaluation.submap_recordings import RegisteredDrive
from fpnet_lab.evaluation.submap_segmentation import (
    score_segmentation,
    summary,
)
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom

T_BUILDING_ODOM = SE2.from_xy_yaw(7.0, -3.0, 0.5)


def box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


PLAN = BuildingPlan(
    rooms=(PlanRoom(box(0, 0, 6, 4)), PlanRoom(box(6.2, 0, 10.2, 4)), PlanRoom(box(20, 0, 24, 4))),
    doors=(
        PlanDoor((0, 1), np.array([[6.1, 1.6], [6.1, 2.5]])),
        PlanDoor((1, 2), np.array([[15.0, 1.6], [15.0, 2.5]])),
    ),
    wall_m=0.2,
    family='drawn',
)


def submap(seen_m=11.0):
    """Both near rooms as the robot saw them up to x = seen_m, in a turned odometry frame."""
    cells = np.full((100, 240), UNKNOWN, dtype=np.int8)
    cells[8:92, 8:216] = OCCUPIED
    cells[10:90, 10:130] = FREE
    cells[10:90, 134:214] = FREE
    cells[42:60, 130:134] = FREE
    cells[:, 10 + round(seen_m / 0.05) :] = UNKNOWN
    T_odom_grid = T_BUILDING_ODOM.inv() @ SE2.from_xy_yaw(-0.5, -0.5, 0.0)
    grid = GridMap(cells, 0.05, T_odom_grid, 'submap')
    return Submap(grid, np.zeros(cells.shape, dtype=bool), np.zeros((0, 2)))


def drive():
    return RegisteredDrive(PLAN, T_BUILDING_ODOM, ())


def score(sub):
    return score_segmentation(segment_submap(sub), drive(), 'drawn', 0)


def test_a_right_segmentation_scores_nearly_one():
    result = score(submap())
    assert result.room_ious == pytest.approx([1.0, 1.0], abs=0.06)
    assert tuple(result.doors) == (1, 1, 1, 1)


def test_unseen_parts_and_glimpsed_rooms_do_not_count():
    assert score(submap(seen_m=9.0)).room_ious == pytest.approx([1.0, 1.0], abs=0.06)
    assert len(score(submap(seen_m=7.0)).room_ious) == 1


def test_a_missed_wall_costs_a_room_and_its_door():
    sub = submap()
    cells = sub.grid.cells.copy()
    cells[10:90, 130:134] = FREE
    joined = Submap(GridMap(cells, 0.05, sub.grid.T_frame_grid, 'submap'), sub.lintel, sub.path_xy)
    result = score(joined)
    assert sorted(result.room_ious) == pytest.approx([0.0, 0.58], abs=0.04)
    assert tuple(result.doors) == (0, 0, 1, 0)


def test_summary_weighs_rooms_and_doors_not_drives():
    figures = summary([score(submap()), score(submap(seen_m=7.0))])
    assert figures['rooms'] == 3
    assert figures['recordings'] == 2
    assert figures['rooms_over_iou50'] == 1.0
    assert figures['doors_recall'] == 1.0
    assert summary([])['room_iou_mean'] == 0.0
