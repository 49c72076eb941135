# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real floorplans traced to buildings that can be simulated."""

import cv2
import numpy as np
import pytest
from real_data import DATA, needs
import shapely

from fpnet_core.io.maps import read_map
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import FREE
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.buildings.openings import walkable_area
from fpnet_lab.sim.drawn.render import fill_polygons, render_plan
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.plans.traced import plan_from_grid

BORMANN = DATA / 'bormann'
RESOLUTION_M = 0.05

pytestmark = [
    pytest.mark.real,
    needs('bormann'),
]


@pytest.fixture(scope='module', params=['office_e', 'Freiburg52_scan'])
def labels_and_plan(request):
    grid = read_map(BORMANN / 'floorplan' / f'{request.param}.png', RESOLUTION_M)
    path = BORMANN / 'room_labels' / f'{request.param}.png'
    labels = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[::-1].astype(np.int32)
    return labels, grid, plan_from_grid(grid)


def test_rooms_are_those_that_people_see(labels_and_plan):
    labels, _, plan = labels_and_plan
    traced = np.zeros_like(labels)
    for index, room in enumerate(plan.rooms):
        fill_polygons(traced, [room.polygon / RESOLUTION_M], index + 1)
    agreement = room_agreement(traced, labels)
    assert agreement.f1 > 0.8
    assert agreement.precision > 0.9


def test_its_drawing_shows_the_same_free_space(labels_and_plan):
    _, grid, plan = labels_and_plan
    rc = np.argwhere(render_plan(plan, RESOLUTION_M).cells == FREE)
    xy = render_plan(plan, RESOLUTION_M).rc_to_xy(rc)
    back = np.rint(grid.xy_to_rc(xy)).astype(int)
    assert (grid.cells[back[:, 0], back[:, 1]] == FREE).mean() > 0.95


def test_a_robot_drives_through_it(labels_and_plan):
    _, _, plan = labels_and_plan
    outlines = plan.outlines
    assert all(outline.is_valid for outline in outlines)
    assert extrude(plan, np.random.default_rng(0)).furniture
    limits = TourLimits(rooms=4, shortest_s=20.0, longest_s=200.0)
    tour = plan_tour(plan, np.random.default_rng(3), limits)
    assert shapely.covers(walkable_area(plan), tour.line())
