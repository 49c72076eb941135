# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The class of every pixel of a sheet."""

import numpy as np
import pytest

from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_lab.sim.sheets import draw_sheet
from fpnet_lab.sim.sheets.classes import sheet_classes
from fpnet_lab.sim.sheets.looks import Trait


@pytest.fixture(scope='module', params=['office', 'phone'])
def sheet(request):
    return next(
        found
        for seed in range(50, 80)
        if Trait.WINDOWS in (found := draw_sheet(seed, request.param)).look.traits
    )


def test_true_rooms_are_floor_and_what_is_beside_the_building_is_outside(sheet):
    classes, rooms = sheet_classes(sheet), sheet.room_labels()
    assert classes.shape == rooms.shape
    # Walls as drawn are thicker than true ones, and columns stand in rooms.
    assert (classes[rooms > 0] == FLOOR).mean() > 0.85
    assert (classes[rooms == 0] == FLOOR).mean() < 0.05
    assert (classes == OUTSIDE).mean() > 0.2


def test_walls_doors_and_windows_are_where_they_are_drawn(sheet):
    classes = sheet_classes(sheet)
    assert {OUTSIDE, FLOOR, WALL, DOOR, WINDOW} == set(np.unique(classes))
    grey = sheet.pixels[..., :3].mean(axis=2)
    if sheet.look.walls in {'solid', 'thin'}:
        assert grey[classes == WALL].mean() < grey[classes == DOOR].mean() - 20.0
