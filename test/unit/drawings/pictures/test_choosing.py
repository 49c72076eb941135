# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which reading is taken, and what doors and walls say of the spaces that a network saw."""

import cv2
import numpy as np
from plan_pictures import PX_PER_M, ROOM_COUNT, storey
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures import choosing
from fpnet_core.drawings.pictures import found as found_module
from fpnet_core.drawings.pictures.learned import SeenBuilding
from fpnet_core.drawings.pictures.plausible import findings
from fpnet_core.drawings.stated import UNSAID, SaidScale
from fpnet_core.drawings.types import Drawing, DrawingScale, ReadOptions, ScaleSource, Trust
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

CONFIG = SegmentationConfig()


def building(sill=True, doors=True):
    """A hall of 12 m x 8 m and four rooms beside it, at 5 cm: cells, and what is drawn."""
    cells = np.full((240, 440), UNKNOWN, np.int8)
    cells[30:210, 30:380] = OCCUPIED
    cells[36:204, 36:270] = FREE
    for k in range(4):
        cells[36 + 43 * k : 75 + 43 * k, 276:374] = FREE
    ink = cells == OCCUPIED
    for k in range(4) if doors else ():
        rows = slice(44 + 43 * k, 59 + 43 * k)
        cells[rows, 270:276] = FREE
        ink[rows, 270:276] = False
        if sill:
            ink[rows, 272] = True
            cells[rows, 272:275] = OCCUPIED
    return cells, ink


def seen(cells, ink):
    trust = Trust(1.0, 1.0, 0.0, 1.0)
    return SeenBuilding(cells, cells, ink, np.eye(3), ((0, 0, 1, 1),), 0, trust)


def read(cells, ink):
    look = seen(cells, ink)
    return look, choosing._of_cells(cells, look, CONFIG, UNSAID)


def test_sills_that_a_network_takes_for_walls_are_open():
    look, found = read(*building())
    assert not found.segmentation.portals
    opened = choosing._with_doorways(found, look, CONFIG)
    assert len(opened.segmentation.portals) == 4


def test_a_hall_seen_in_part_is_a_room_where_doors_lead_into_it():
    cells, ink = building()
    cells[60:190, 80:240] = UNKNOWN
    look, found = read(cells, ink)
    opened = choosing._with_doorways(found, look, CONFIG)
    assert (opened.cells[36:204, 36:270] == FREE).all()
    shut = building(doors=False)[0]
    shut[60:190, 80:240] = UNKNOWN
    look, found = read(shut, shut == OCCUPIED)
    assert (choosing._with_doorways(found, look, CONFIG).cells == shut).all()


def test_the_ground_before_an_entrance_is_no_room():
    cells, ink = building(sill=False)
    cells[100:120, 30:36] = FREE
    cells[90:135, 8:30] = FREE
    _, found = read(cells, ink)
    kept = choosing._without_forecourts(found, CONFIG)
    assert len(found.segmentation.rooms) == 6
    assert len(kept.segmentation.rooms) == 5
    assert (kept.cells[:, 40:] == cells[:, 40:]).all()
    cells[36:204, 36:270] = UNKNOWN
    cells[36:60, 40:120] = FREE  # a corner of the hall, and the wall above it has a gap
    cells[30:36, 140:160] = UNKNOWN
    _, found = read(cells, ink)
    kept = choosing._without_forecourts(found, CONFIG)
    assert (kept.cells[36:60, 40:120] == FREE).all()

    assert choosing._without_forecourts(kept, CONFIG) is kept


def test_a_hall_into_which_rooms_open_is_no_giant():
    cells, _ = building(sill=False)
    segmentation = segment_floorplan(GridMap(np.pad(cells, 1), 0.05), CONFIG)
    shut = segment_floorplan(GridMap(building(doors=False)[0], 0.05), CONFIG)
    assert not [said for said in findings(segmentation) if 'One room' in said]
    areas = sorted(room.area_m2 for room in shut.rooms)
    assert areas[-1] / sum(areas) == pytest.approx(0.7, abs=0.15)


def units(rooms, corridor_doors=0):
    """
    Six units side by side above a corridor of 24 m, each of ``rooms`` that doors join.

    Doors lead from the corridor into the first ``corridor_doors`` of them.
    """
    high = 60 * rooms
    cells = np.full((high + 60, 506), OCCUPIED, np.int8)
    cells[high + 13 : high + 47, 13:493] = FREE
    for unit in range(6):
        left = 13 + 80 * unit
        for room in range(rooms):
            cells[13 + 60 * room : 67 + 60 * room, left : left + 74] = FREE
        for wall in range(rooms if unit < corridor_doors else rooms - 1):
            cells[66 + 60 * wall : 74 + 60 * wall, left + 30 : left + 48] = FREE
    return segment_floorplan(GridMap(np.pad(cells, 8, constant_values=UNKNOWN), 0.05), CONFIG)


@pytest.mark.parametrize(
    ('rooms', 'corridor_doors', 'is_doubted'),
    [(2, 0, True), (2, 3, True), (2, 4, False), (2, 6, False), (3, 0, False)],
)
def test_rooms_that_no_door_joins_are_doubted_and_dwellings_in_a_row_are_not(
    rooms, corridor_doors, is_doubted
):
    segmentation = units(rooms, corridor_doors)
    assert len(segmentation.rooms) == 6 * rooms + 1
    assert len(segmentation.portals) == 6 * (rooms - 1) + corridor_doors
    most = rooms * corridor_doors + 1 if corridor_doors else rooms
    said = f'No more than {most} of {6 * rooms + 1} rooms are joined by doors: '
    assert any(said in finding for finding in findings(segmentation)) == is_doubted


def test_what_no_building_is_like_is_the_last_resort():
    _, found = read(*building(sill=False))
    _, shut = read(*building(doors=False))
    likely = choosing.replace(shut, probability=0.6)
    less = choosing.replace(found, probability=0.3)
    drawing = Drawing(np.full((240, 440, 3), 255, np.uint8), 'a.png', 'png')
    assert likely.is_absurd
    assert not less.is_absurd
    chosen = choosing._likeliest([likely, less], likely, drawing, CONFIG)
    assert len(chosen.segmentation.portals) == 4
    assert [rival.plausible for rival in chosen.rivals] == [0.6]


def test_a_bare_drawing_with_letters_is_looked_at_by_the_network_too(monkeypatch):
    """A map's specks are what a robot saw; a clean plan means what it shows."""
    asked = []
    monkeypatch.setattr(choosing, '_seen', lambda *given: asked.append(given))
    picture, _ = storey()
    drawn = lettered(picture)
    grey = np.where(picture == 255, 205, picture)
    grey[60:-60, 60:-60] = picture[60:-60, 60:-60]
    for pixels, looks in ((picture, 0), (drawn, 1), (lettered(grey), 1)):
        choosing.choose(Drawing(pixels, 'a.png', 'png'), ReadOptions(), CONFIG)
        assert len(asked) == looks


@pytest.mark.parametrize('is_said_by', ['resolution', 'length', 'drawing'])
def test_readings_are_judged_at_the_scale_that_is_said(monkeypatch, is_said_by):
    monkeypatch.setattr(found_module, 'segment_unknown_scale', lambda *_: pytest.fail('guessed'))
    picture, _ = storey()
    width, pixel_m = picture.shape[1], 1.0 / PX_PER_M
    units = DrawingScale(pixel_m, pixel_m, pixel_m, ScaleSource.UNITS)
    options = {
        'resolution': ReadOptions(resolution_m=pixel_m),
        'length': ReadOptions(length=(0.0, 9.0, width, 9.0, width * pixel_m)),
        'drawing': ReadOptions(),
    }[is_said_by]
    drawing = Drawing(picture, 'a.png', 'png', scale=units if is_said_by == 'drawing' else None)
    found = choosing.choose(drawing, options, CONFIG)
    nominal_m = np.sqrt(abs(np.linalg.det(found.H_plan_pixel[:2, :2])))
    assert found.known_factor * nominal_m == pytest.approx(pixel_m)
    assert len(found.segmentation.rooms) == ROOM_COUNT
    assert not choosing.thought_of(found, drawing, CONFIG).reasons


def test_doors_symbols_have_their_size_at_the_scale_that_is_said():
    look, found = read(*building())
    known = DrawingScale(0.05, 0.05, 0.05, ScaleSource.STATED)
    assert choosing._likely_factors(choosing.replace(found, said=SaidScale(known))) == (1.0,)
    assert len(choosing._likely_factors(found)) == 2
    slip = DrawingScale(0.5, 0.5, 0.5, ScaleSource.STATED)
    opened = choosing._with_doorways(choosing.replace(found, said=SaidScale(slip)), look, CONFIG)
    assert len(opened.segmentation.portals) == 4


def lettered(picture):
    """Return the picture with a name in every room."""
    drawn = picture.copy()
    for x in range(60, drawn.shape[1] - 80, 60):
        for y in (90, 240):
            cv2.putText(drawn, 'Lab', (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (0, 0, 0))
    return drawn
