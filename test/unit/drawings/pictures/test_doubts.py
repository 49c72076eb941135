# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What speaks against a reading: figures of rooms and sheets, and where doubts lie."""

from dataclasses import replace

import cv2
import numpy as np
from PIL import Image
from plan_pictures import storey
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.doubt_model import DoubtModel, packaged_doubt_model
from fpnet_core.drawings.pictures.doubting import doubts_of
from fpnet_core.drawings.pictures.looking import WHAT_IFS, Rival, view_reading
from fpnet_core.drawings.pictures.room_figures import ROOM_FIGURES, best_overlap, room_figures
from fpnet_core.drawings.pictures.sheet_figures import (
    SHEET_FIGURES,
    WHOLE_FIGURES,
    lost_spaces,
    sheet_evidence,
    whole_figures,
)
from fpnet_core.drawings.read import read_plan
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

CONFIG = SegmentationConfig()
CELL_M = 0.05
WALL, PAPER = 0, 255


def building():
    """Six rooms along a corridor, 300 x 200 pixels, walls 6 pixels thick, paper around it."""
    picture = np.full((240, 340), PAPER, np.uint8)
    cv2.rectangle(picture, (20, 20), (320, 220), WALL, 6)
    for y in (100, 140):
        cv2.line(picture, (20, y), (320, y), WALL, 6)
    for x in (120, 220):
        cv2.line(picture, (x, 20), (x, 100), WALL, 6)
        cv2.line(picture, (x, 140), (x, 220), WALL, 6)
    for x in (70, 170, 270):
        for y in (100, 140):
            cv2.line(picture, (x - 9, y), (x + 9, y), PAPER, 6)
    return picture


def looked(picture, is_outside=None, rivals=(), walls=None):
    """A look at the picture read with its own black pixels, or ``walls``, as walls."""
    dark = picture < 100 if walls is None else walls
    inside = np.zeros_like(dark)
    inside[17:224, 17:324] = True
    if is_outside is not None:
        inside &= ~is_outside
    cells = np.where(inside, np.where(dark, OCCUPIED, FREE), UNKNOWN).astype(np.int8)
    grid = GridMap(cells[::-1], CELL_M)
    pixels = np.repeat(picture[..., None], 3, axis=2)
    segmentation = segment_floorplan(grid, CONFIG)
    return view_reading(pixels, segmentation, pixel_to_xy(grid).matrix, 0.9, rivals, CONFIG)


def room_at(look, x, y):
    """The room at a pixel."""
    return look.segmentation.labels[::-1][y, x] - 1


def figure(look, name, x, y):
    return room_figures(look)[room_at(look, x, y), ROOM_FIGURES.index(name)]


def whole(look, name):
    return whole_figures(look)[WHOLE_FIGURES.index(name)]


def test_nothing_speaks_against_a_plain_building():
    look = looked(building())
    rooms = room_figures(look)
    assert rooms.shape == (7, len(ROOM_FIGURES))
    for name in ('open', 'thin', 'faint', 'bitten', 'unread', 'strokes', 'furniture'):
        assert rooms[:, ROOM_FIGURES.index(name)].max() < 0.06, name  # corners are thin
    for name in WHAT_IFS:
        assert rooms[:, ROOM_FIGURES.index(name)].min() > 0.9, name
    for name in ('shut_out', 'walls_beside', 'open', 'unread'):
        assert whole(look, name) == pytest.approx(0.0, abs=0.02), name


def test_figures_do_not_depend_on_the_scale():
    look = looked(building())
    grid = replace(look.segmentation.grid, resolution=0.11)
    large = segment_floorplan(grid, CONFIG, CELL_M / 0.11)
    pixels = np.repeat(building()[..., None], 3, axis=2)
    other = view_reading(pixels, large, pixel_to_xy(grid).matrix, 0.9, (), CONFIG)
    np.testing.assert_allclose(room_figures(other), room_figures(look), atol=0.05)
    np.testing.assert_allclose(whole_figures(other), whole_figures(look), atol=0.05)


def test_a_room_that_was_left_outside_is_seen_and_boxed():
    gone = np.zeros((240, 340), np.bool_)
    gone[:98, :118] = True
    look = looked(building(), gone)
    assert whole(look, 'shut_out') > 0.1
    ((top, left, height, width),) = lost_spaces(look)
    rows, cols = look.segmentation.grid.shape
    assert rows == 240
    box = (left, rows - top - height, left + width, rows - top)
    np.testing.assert_allclose(box, (23, 23, 117, 97), atol=4)
    assert cols == 340


def test_what_lies_apart_from_the_building_was_not_left_out():
    picture = np.full((240, 520), PAPER, np.uint8)
    picture[:, :340] = building()
    cv2.rectangle(picture, (380, 60), (480, 160), WALL, 6)  # a legend
    assert lost_spaces(looked(picture)) == []
    framed = building()
    cv2.rectangle(framed, (3, 3), (336, 236), WALL, 2)
    assert lost_spaces(looked(framed)) == []


def test_walls_that_go_on_outside_are_seen():
    gone = np.zeros((240, 340), np.bool_)
    gone[:98] = True
    assert whole(looked(building(), gone), 'walls_beside') > 0.2


def test_an_edge_without_a_wall_is_open():
    bite = np.zeros((240, 340), np.uint8)
    cv2.circle(bite, (20, 60), 30, 1, -1)
    picture = building()
    picture[45:75, 10:26] = PAPER
    look = looked(picture, bite > 0)
    assert figure(look, 'open', 90, 60) > 0.1
    assert figure(look, 'bitten', 90, 60) > 0.1
    assert figure(look, 'open', 270, 180) == 0.0


def test_lines_that_nobody_read_are_strokes():
    picture = building()
    cv2.line(picture, (60, 60), (110, 60), 60, 3)
    look = looked(picture, walls=building() < 100)
    assert figure(look, 'strokes', 60, 40) > 0.4
    assert figure(look, 'unread', 60, 40) > 0.01
    assert figure(look, 'strokes', 270, 180) == 0.0


def test_without_its_thin_line_a_room_is_another():
    picture = building()
    cv2.line(picture, (70, 20), (70, 100), WALL, 2)
    look = looked(picture)
    assert figure(look, 'thick', 100, 60) < 0.8
    assert figure(look, 'thick', 270, 180) > 0.9
    assert figure(look, 'thin', 100, 60) > 0.1


def test_rivals_that_cut_a_room_otherwise_count():
    other = building()
    other[26:98, 117:124] = PAPER  # a wall less
    rival = looked(other)
    look = looked(building(), rivals=[Rival(rival.segmentation, rival.H_plan_pixel, 0.5)])
    assert figure(look, 'rivals', 60, 60) < 0.6
    assert figure(look, 'rivals', 270, 180) > 0.9
    assert np.isnan(figure(looked(building()), 'rivals', 60, 60))
    assert 0.5 < whole(look, 'top_rival') < 1.0


def test_overlaps_of_rooms():
    labels = np.array([[1, 1, 2, 2], [1, 1, 2, 2]], np.int32)
    np.testing.assert_allclose(best_overlap(labels, labels, 2), [1.0, 1.0])
    np.testing.assert_allclose(best_overlap(labels, np.zeros_like(labels), 2), [0.0, 0.0])
    np.testing.assert_allclose(
        best_overlap(labels, np.array([[1, 1, 1, 1], [0] * 4], np.int32), 3), [1 / 3, 1 / 3, 0.0]
    )


def test_what_rooms_come_to():
    rooms, whole_ = np.zeros((2, len(ROOM_FIGURES))), np.full(len(WHOLE_FIGURES), 0.5)
    evidence = sheet_evidence(whole_, rooms, np.array([0.2, 1.0]))
    found = dict(zip(SHEET_FIGURES, evidence.tolist(), strict=True))
    assert found['expected'] == found['expected_area'] == pytest.approx(np.log(0.6 / 0.4))
    assert found['doubtful'] == 0.5
    assert found['expected_f1'] == pytest.approx(np.log((4 / 7) / (3 / 7)))  # 1.2 of 2.1
    assert found['shut_out'] == pytest.approx(np.log(0.52))
    assert found['plausible'] == pytest.approx(0.0)
    nothing = sheet_evidence(whole_, rooms[:0], np.zeros(0))
    assert np.isfinite(nothing).all()


def test_a_forest_goes_down_to_its_leaves():
    size = len(ROOM_FIGURES)
    tree = {
        'room.usual': np.full(size, 5.0, np.float32),
        'room.feature': np.array([[3, -1, -1]], np.int16),
        'room.limit': np.array([[2.0, 0.0, 0.0]], np.float32),
        'room.below': np.array([[1, 0, 0]], np.int16),
        'room.above': np.array([[2, 0, 0]], np.int16),
        'room.value': np.array([[0.0, 0.25, 0.75]], np.float32),
    }
    rooms = np.zeros((3, size))
    rooms[:, 3] = [2.0, 2.5, np.nan]
    np.testing.assert_allclose(DoubtModel(tree, 0.5).right_rooms(rooms), [0.25, 0.75, 0.75])


def test_the_packaged_model_knows_its_figures():
    model = packaged_doubt_model()
    assert 0.0 < model.doubted_from < 1.0
    assert model.tensors['room.usual'].shape == (len(ROOM_FIGURES),)
    assert model.tensors['sheet.weight'].shape == (len(SHEET_FIGURES),)


def test_a_plain_building_is_believed_and_half_of_one_is_not():
    assert doubts_of(looked(building())).reasons == ()
    gone = np.zeros((240, 340), np.bool_)
    gone[:98, :218] = True
    doubts = doubts_of(looked(building(), gone), replace(packaged_doubt_model(), doubted_from=0))
    assert doubts.reasons[0] == (
        '2 spaces are left outside the building: the outer wall has a gap or was not seen (at the '
        'upper left and at the top): draw that wall in an image editor.'
    )
    assert [place.what for place in doubts.places[:2]] == ['lost', 'lost']


def test_rooms_that_mostly_have_no_door_are_doubted():
    picture = building()
    for x, y in ((170, 100), (270, 100), (70, 140), (170, 140), (270, 140)):
        cv2.line(picture, (x - 9, y), (x + 9, y), WALL, 6)
    reasons = doubts_of(looked(picture)).reasons
    assert any('% of the rooms have no door' in reason for reason in reasons), reasons


def test_nothing_enclosed_is_no_reading():
    picture = np.full((240, 340), PAPER, np.uint8)
    doubts = doubts_of(looked(picture, np.ones((240, 340), np.bool_)))
    assert doubts.wrong == 1.0
    assert doubts.reasons[0].startswith('No room was found')


def test_a_drawing_is_read_with_its_doubts(tmp_path):
    picture, _ = storey()
    Image.fromarray(picture).save(tmp_path / 'plan.png')
    reading = read_plan(tmp_path / 'plan.png')
    assert reading.doubts == ()
    assert reading.doubtful == ()
