# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The class of every pixel of a sheet, varied ones included, and pictures of no floorplan."""

import numpy as np
import pytest

from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.pixels import map_points, shrinking
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.special import special_plan
from fpnet_lab.sim.sheets import draw_sheet
from fpnet_lab.sim.sheets.classes import SYMBOL_BIT, TEXT_BIT, sheet_classes, sheet_overlays
from fpnet_lab.sim.sheets.looks import Trait
from fpnet_lab.sim.sheets.negatives import NEGATIVES, negative


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


def plan_with_gates():
    plans = (special_plan(np.random.default_rng(seed), 'hall') for seed in range(20))
    return next(plan for plan in plans if sum(door.is_outside for door in plan.doors) > 1)


@pytest.mark.parametrize('seed', [1, 2])
def test_a_gate_is_a_door_from_the_floor_to_the_outside(seed):
    sheet = draw_sheet(seed, 'varied', plan_with_gates())
    classes = sheet_classes(sheet)
    H, storey = sheet.H_image_page, sheet.storeys[0].on_page
    seen = 0
    for door in storey.doors:
        if not door.is_outside:
            continue
        middle = door.ends.mean(axis=0)
        places = middle + np.outer([-1.0, 0.0, door.reach_m + 1.0], door.normal)
        for (x, y), wanted in zip(
            np.rint(map_points(H, places)).astype(int).tolist(),
            (FLOOR, DOOR, OUTSIDE),
            strict=True,
        ):
            if 0 <= y < classes.shape[0] and 0 <= x < classes.shape[1]:
                seen += classes[y, x] == wanted
    assert seen > 3
    assert (classes == WALL).any()


def test_walls_are_where_the_picture_shows_them_after_all_that_happened_to_it():
    contrasts = []
    for seed in range(20, 24):
        sheet = draw_sheet(seed, 'varied')
        classes, grey = sheet_classes(sheet), sheet.pixels[..., :3].mean(axis=2)
        assert classes.shape == grey.shape
        contrasts.append(abs(grey[classes == WALL].mean() - grey[classes == FLOOR].mean()))
    assert np.median(contrasts) > 15.0


@pytest.mark.parametrize('name', list(NEGATIVES))
def test_a_negative_of_every_kind_can_be_drawn(name):
    pixels = negative(name, (200, 260), np.random.default_rng(3))
    assert pixels.shape == (200, 260, 3)
    assert pixels.dtype == np.uint8


_SEEDS = (5, 10)


@pytest.fixture(scope='module')
def plan():
    return generate_plan(np.random.default_rng(3), max_rooms=25, max_area_m2=900.0)


@pytest.mark.parametrize('seed', _SEEDS)
def test_equal_seeds_give_equal_sheets(seed, plan):
    a, b = (draw_sheet(seed, 'varied', plan) for _ in range(2))
    np.testing.assert_array_equal(a.pixels, b.pixels)
    np.testing.assert_array_equal(sheet_classes(a), sheet_classes(b))
    np.testing.assert_array_equal(sheet_overlays(a), sheet_overlays(b))


def test_overlays_have_letters_and_symbols(plan):
    bits = 0
    for seed in _SEEDS:
        sheet = draw_sheet(seed, 'varied', plan)
        rows, cols = sheet.pixels.shape[0] // 2, sheet.pixels.shape[1] // 2
        overlays = sheet_overlays(sheet, shrinking(0.5), (rows, cols))
        assert overlays.shape == (rows, cols)
        assert set(np.unique(overlays)) <= {0, TEXT_BIT, SYMBOL_BIT, TEXT_BIT | SYMBOL_BIT}
        bits |= int(np.bitwise_or.reduce(overlays, axis=None))
    assert bits == TEXT_BIT | SYMBOL_BIT
