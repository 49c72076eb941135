# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sheets from the simulator: pictures, where things lie on them, and what is written."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from fpnet_core.geometry import SE2
from fpnet_core.raster.pixels import map_points
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.sheets import SheetKind, draw_sheet
from fpnet_lab.sim.sheets import sheet as sheet_module
from fpnet_lab.sim.sheets.artwork import Area, Dimension, Letters, inverted, strokes_of
from fpnet_lab.sim.sheets.lettering import dimension_marks
from fpnet_lab.sim.sheets.looks import Trait, draw_look
from fpnet_lab.sim.sheets.paper import weather
from fpnet_lab.sim.sheets.storeys import PlacedStorey, hatch, storey_marks
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


def ink_of(mark, owner=None):
    """The colour of a mark, of a dimension that of its ``owner``: lines or number."""
    if owner == 'pen' or not hasattr(mark, 'colour'):
        return mark.pen.colour
    return mark.colour


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


def test_sheets_have_a_usual_number_of_pixels():
    for seed in range(6):
        sheet = draw_sheet(seed, 'brochure')
        assert 1200 <= max(sheet.pixels.shape) <= 3501
        assert 0.01 <= sheet.look.resolution_m <= 0.1


def test_dimensions_say_how_long_things_are():
    look = draw_look(np.random.default_rng(0), SheetKind.OFFICE, 10.0)
    storey = PlacedStorey(PLAN, SE2.identity(), 0.2)
    total = 9.2 + 2.0 * look.outer_m
    seen = set()
    for seed in range(12):
        marks = dimension_marks(storey, look, np.random.default_rng(seed))
        assert all(isinstance(mark, Dimension) for mark in marks)
        lengths = [float(np.hypot(*np.subtract(mark.b, mark.a))) for mark in marks]
        text = marks[int(np.argmax(lengths))].text
        unit = 'm' if set(text) & {'.', ','} else 'mm' if len(text) == 5 else 'cm'
        metres = float(text.replace(',', '.')) / {'m': 1.0, 'cm': 100.0, 'mm': 1000.0}[unit]
        assert metres == pytest.approx(total, abs=0.006)
        seen.add(unit + text.strip('0123456789'))
    assert max(lengths) == pytest.approx(total)
    assert seen == {'m.', 'm,', 'cm', 'mm'}


def test_dimensions_are_drawn_as_lines_with_a_number():
    pen = draw_look(np.random.default_rng(0), SheetKind.OFFICE, 10.0).pen(0.2)
    mark = Dimension((1, 1), (1, 4), (0.5, 0), '3.00', 0.2, 0.1, pen, (0, 0, 0), 'DejaVu Sans')
    lines, number = strokes_of(mark)
    assert len(lines.lines) == 5
    assert number.text == '3.00'
    assert number.angle_rad == pytest.approx(np.pi / 2)
    assert number.xy[0] < 1.0  # to the left of a line that goes up


def test_hatching_fills_a_shape_and_keeps_inside():
    ring = shapely.box(0, 0, 4, 3) - shapely.box(1, 1, 2, 2)
    strokes = hatch(ring, np.pi / 4, 0.5)
    length = sum(float(np.linalg.norm(b - a)) for a, b in strokes)
    assert length == pytest.approx(ring.area / 0.5, rel=0.1)
    assert all(shapely.LineString(stroke).within(ring.buffer(1e-9)) for stroke in strokes)
    assert hatch(shapely.Polygon(), 0.0, 1.0) == []


def test_walls_leave_rooms_and_doors_open():
    look = replace(
        draw_look(np.random.default_rng(0), SheetKind.CLEAN, 10.0),
        walls='solid',
        traits=frozenset(),
    )
    storey = PlacedStorey(PLAN, SE2.from_xy_yaw(3.0, -2.0, 0.4), 0.2)
    areas = [
        shapely.Polygon(mark.rings[0], mark.rings[1:])
        for mark in storey_marks(storey, look, np.random.default_rng(0))
        if isinstance(mark, Area)
    ]
    wall = shapely.union_all(areas)
    place = storey.T_page_building.apply
    assert wall.contains(shapely.Point(place(WALL)))
    for door in PLAN.doors:
        assert not wall.intersects(shapely.Point(place(door.ends.mean(axis=0))))
    assert wall.intersection(shapely.Polygon(place(PLAN.rooms[0].polygon))).area < 1e-6


def test_moved_plans_keep_their_shape():
    moved = PLAN.mapped(SE2.from_xy_yaw(7.0, 1.0, 2.0))
    assert moved.floor_area_m2 == pytest.approx(PLAN.floor_area_m2)
    assert moved.doors[1].width_m == pytest.approx(1.0)
    assert not np.allclose(moved.extent, PLAN.extent)


def test_inverted_sheets_have_light_ink_on_dark_paper():
    artwork = replace(draw_sheet(0, 'office', PLAN).artwork, paper=(0.9, 1.0, 0.95))
    dark = inverted(artwork)
    assert np.allclose(np.add(dark.paper, artwork.paper), 1.0)
    for before, after in zip(artwork.marks, dark.marks, strict=True):
        for owner in ('pen', 'colour') if isinstance(before, Dimension) else (None,):
            inks = [ink_of(mark, owner) for mark in (before, after)]
            assert np.allclose(np.sum(inks, axis=0), 1.0)


@pytest.mark.parametrize('kind', [SheetKind.SCAN, SheetKind.PHONE])
def test_paper_goes_where_the_homography_says(kind):
    drawn = np.full((300, 400, 3), 255, np.uint8)
    drawn[80:100, 120:140] = 0
    for seed in range(5):
        shown, H = weather(drawn, kind, np.random.default_rng(seed))
        x, y = np.rint(map_points(H, np.array([129.5, 89.5]))).astype(int)
        dark = shown[y - 4 : y + 5, x - 4 : x + 5].mean()
        around = shown[y - 30 : y - 18, x - 30 : x + 30].mean()
        assert dark < 0.55 * around


def test_storeys_are_in_one_piece(monkeypatch):
    drawn = iter([replace(PLAN, family='disconnected'), PLAN])
    monkeypatch.setattr(sheet_module, 'generate_plan', lambda *_, **__: next(drawn))
    assert draw_sheet(0, 'clean').storeys[0].plan is PLAN


def test_two_storeys_stand_apart_and_are_both_labelled():
    sheet = next(s for s in (draw_sheet(i, 'brochure') for i in range(40)) if len(s.storeys) > 1)
    first, second = (shapely.box(*storey.on_page.extent.ravel()) for storey in sheet.storeys)
    assert first.distance(second) > 0.5
    truth = sheet.truth()
    assert len(truth['storeys']) == 2
    assert sheet.room_labels().max() == truth['rooms']


def test_texts_fit_between_the_walls():
    rng = np.random.default_rng(2)
    plan = generate_plan(rng, 'suites')
    sheet = draw_sheet(3, 'office', plan)
    letters = [mark for mark in sheet.artwork.marks if isinstance(mark, Letters)]
    assert letters
    width, height = sheet.artwork.size_m
    assert all(0.0 < mark.xy[0] < width and 0.0 < mark.xy[1] < height for mark in letters)
