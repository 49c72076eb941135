# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sheets from the simulator: pictures, where things lie on them, and what is written."""

import numpy as np
import pytest
import shapely

from fpnet_core.raster.pixels import map_points
from fpnet_lab.sim.sheets import SheetKind, draw_sheet
from fpnet_lab.sim.sheets.looks import Trait
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom

PLAN = BuildingPlan(
    rooms=(
        PlanRoom(np.array([(0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)])),
        PlanRoom(np.array([(5.2, 0.0), (9.2, 0.0), (9.2, 4.0), (5.2, 4.0)])),
        PlanRoom(np.array([(0.0, 4.2), (9.2, 4.2), (9.2, 6.2), (0.0, 6.2)]), 'corridor'),
    ),
    doors=(
        PlanDoor((0, 2), np.array([(2.0, 4.1), (2.9, 4.1)])),
        PlanDoor((1, 2), np.array([(7.0, 4.1), (8.0, 4.1)]), hinge=1, swing=1),
    ),
    wall_m=0.2,
    family='planted',
)
WALL = np.array([5.1, 2.0])
"""In the middle of the wall between the first two rooms."""


def brightness(sheet, xy):
    """Mean grey level of 3 x 3 pixels at a place in the building."""
    x, y = np.rint(map_points(sheet.H_image_building(), xy)).astype(int)
    return float(sheet.pixels[y - 1 : y + 2, x - 1 : x + 2, :3].mean())


def plain(seeds, kind, wanted):
    """The first sheet of PLAN among seeds whose look is as wanted."""
    sheets = (draw_sheet(seed, kind, PLAN) for seed in seeds)
    return next(sheet for sheet in sheets if wanted(sheet.look))


def test_equal_seeds_give_equal_sheets_and_others_do_not():
    first, again, other = (draw_sheet(seed, 'scan', PLAN) for seed in (4, 4, 5))
    np.testing.assert_array_equal(first.pixels, again.pixels)
    assert first.truth() == again.truth()
    assert first.truth() != other.truth()


@pytest.mark.parametrize('kind', list(SheetKind))
def test_walls_are_where_the_truth_says(kind):
    def shows(look):
        return look.walls == 'solid' and not look.traits & {Trait.FURNITURE, Trait.INVERTED}

    sheet = plain(range(20), kind, shows)
    # Empty places near the wall: no text is there, nor a door's arc.
    beside = WALL + np.array([(-0.35, -1.4), (-0.35, 0.0), (0.35, -1.4), (0.35, 0.0)])
    light = min(brightness(sheet, at) for at in beside)
    assert brightness(sheet, WALL) < light - 40.0


@pytest.mark.parametrize('kind', list(SheetKind))
def test_room_labels_lie_in_the_rooms(kind):
    sheet = draw_sheet(2, kind, PLAN)
    labels = sheet.room_labels()
    assert labels.shape == sheet.pixels.shape[:2]
    for number, room in enumerate(PLAN.rooms, start=1):
        x, y = np.rint(map_points(sheet.H_image_building(), room.polygon.mean(axis=0))).astype(int)
        assert labels[y, x] == number
    area_m2 = np.count_nonzero(labels) * sheet.resolution_m() ** 2
    assert area_m2 == pytest.approx(PLAN.floor_area_m2, rel=0.12)


def test_a_metre_has_as_many_pixels_as_the_resolution_says():
    sheet = draw_sheet(1, 'phone', PLAN)
    middle = PLAN.extent.mean(axis=0)
    ends = map_points(sheet.H_image_building(), middle + np.array([[-0.5, 0.0], [0.5, 0.0]]))
    pixels = np.linalg.norm(ends[1] - ends[0])
    # A perspective shortens one direction more than the other, by a quarter at most.
    assert 1.0 / pixels == pytest.approx(sheet.resolution_m(), rel=0.25)


def test_two_storeys_stand_apart_and_are_both_labelled():
    sheet = next(s for s in (draw_sheet(i, 'brochure') for i in range(40)) if len(s.storeys) > 1)
    first, second = (shapely.box(*storey.on_page.extent.ravel()) for storey in sheet.storeys)
    assert first.distance(second) > 0.5
    truth = sheet.truth()
    assert len(truth['storeys']) == 2
    assert sheet.room_labels().max() == truth['rooms']
