# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A floorplan model refuses what it is not, moves as a whole, and becomes a raster."""

import json

import numpy as np
import pytest

from fpnet_core.drawings.model import (
    DoorKind,
    FloorplanModel,
    ModelDoor,
    ModelRoom,
    ModelStorey,
    ModelWall,
    ModelWindow,
    model_from_json,
    model_to_json,
)
from fpnet_core.drawings.model_raster import model_grid
from fpnet_core.drawings.types import DrawingScale, ScaleSource
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
HOLE = np.array([[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]])
LINE = np.array([[1.0, 0.0], [1.9, 0.0]])


def model(**others):
    return FloorplanModel(
        walls=(ModelWall((SQUARE - 1.0,)),),
        doors=(ModelDoor(LINE, 0.2, DoorKind.SWING, 1, np.array([1.9, 0.9]), 'D', 0.8, 'IFC'),),
        windows=(ModelWindow(np.add(LINE, (0.0, 3.0)), 0.3),),
        rooms=(ModelRoom((SQUARE, HOLE), '2.14', 11.2, 'office'),),
        outline=(SQUARE * 1.1,),
        storeys=(ModelStorey('ground', 0.0), ModelStorey('first')),
        storey=1,
        scale=DrawingScale(0.02, 0.01, 0.03, ScaleSource.UNITS, 'said'),
        H_plan_image=np.diag([0.02, -0.02, 1.0]),
        **others,
    )


def test_areas_and_widths():
    assert model().rooms[0].area_m2 == pytest.approx(11.0)
    assert model().doors[0].width_m == pytest.approx(0.9)
    assert model().points.shape == (4 + 8 + 2 + 2 + 4, 2)
    assert FloorplanModel().points.shape == (0, 2)


def test_arrays_are_copies_and_read_only():
    ends = LINE.copy()
    door = ModelDoor(ends)
    ends[:] = 7.0
    assert door.width_m == pytest.approx(0.9)
    with pytest.raises(ValueError, match='read-only'):
        door.ends[0] = 1.0
    with pytest.raises(ValueError, match='read-only'):
        model().rooms[0].rings[1][0] = 1.0


@pytest.mark.parametrize(
    ('make', 'what'),
    [
        (lambda: ModelWall(()), r'ModelWall\.rings: expected rings of at least three'),
        (lambda: ModelWall((LINE,)), r'ModelWall\.rings: expected rings of at least three'),
        (lambda: ModelWall((SQUARE[:, :1],)), r'ModelWall\.rings: expected shape'),
        (lambda: ModelRoom((SQUARE * np.nan,)), r'ModelRoom\.rings: holds NaN'),
        (lambda: ModelRoom((SQUARE,), printed_area_m2=0.0), 'printed_area_m2: must be positive'),
        (lambda: ModelDoor(LINE[[0, 0]]), r'ModelDoor\.ends: the two ends coincide'),
        (lambda: ModelDoor(LINE, -1.0), r'ModelDoor\.depth_m: must be 0 or more'),
        (lambda: ModelDoor(LINE, hinge=2), r'ModelDoor\.hinge: must be 0, 1 or None'),
        (lambda: ModelDoor(LINE, leaf=SQUARE), r'ModelDoor\.leaf: expected shape'),
        (lambda: ModelWindow(LINE, probability=1.1), r'probability: must be in \[0, 1\]'),
        (lambda: FloorplanModel(storey=0), 'there are 0 storeys, got 0'),
        (lambda: FloorplanModel(H_plan_image=np.eye(2)), 'H_plan_image: expected shape'),
        (lambda: FloorplanModel(outline=(LINE,)), r'FloorplanModel\.outline: expected rings'),
    ],
)
def test_what_is_none_is_refused(make, what):
    with pytest.raises(ValueError, match=what):
        make()


def test_plain_values_and_back():
    whole = model()
    values = json.loads(json.dumps(model_to_json(whole)))
    again = model_from_json(values)
    assert model_to_json(again) == model_to_json(whole)
    assert again.doors[0].kind is DoorKind.SWING
    assert again.scale == whole.scale
    with pytest.raises((ValueError, TypeError, KeyError)):
        model_from_json({**values, 'doors': [{'ends': [1.0]}]})


def test_a_moved_model_has_other_lengths_and_the_same_printed_areas():
    c, s = 0.5 * np.cos(0.4), 0.5 * np.sin(0.4)
    A = np.array([[c, -s, 3.0], [s, c, -2.0]])
    moved = model().moved(A)
    assert moved.doors[0].width_m == pytest.approx(0.45)
    assert moved.doors[0].depth_m == pytest.approx(0.1)
    np.testing.assert_allclose(moved.doors[0].leaf, A[:, :2] @ (1.9, 0.9) + A[:, 2])
    assert moved.rooms[0].area_m2 == pytest.approx(11.0 / 4.0)
    assert moved.rooms[0].printed_area_m2 == 11.2
    assert moved.scale is None


def box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)


WALLS = tuple(
    ModelWall((ring,))
    for ring in (box(1, 1, 7, 1.2), box(1, 4, 7, 4.2), box(1, 1, 1.2, 4.2), box(6.8, 1, 7, 4.2))
)
DOOR = ModelDoor(np.array([[2.0, 1.1], [3.0, 1.1]]), 0.2)


def at(grid, *points):
    rows, cols = np.rint(grid.xy_to_rc(points)).astype(int).T
    return grid.cells[rows, cols].tolist()


def test_floor_is_what_walls_and_shut_doors_keep_apart():
    grid = model_grid(FloorplanModel(WALLS, (DOOR,)), 0.05, (110, 160))
    assert at(grid, (4, 3), (1.1, 3), (2.5, 1.1), (0.5, 0.5)) == [FREE, OCCUPIED, FREE, UNKNOWN]
    area = np.count_nonzero(grid.cells == FREE) * 0.05**2
    assert area == pytest.approx(5.6 * 2.8 + 0.2, rel=0.05)


def test_walls_that_do_not_close_have_no_floor():
    grid = model_grid(FloorplanModel(WALLS[:3]), 0.05, (110, 160))
    assert at(grid, (4, 3), (1.1, 3)) == [UNKNOWN, OCCUPIED]


def test_rooms_alone_have_walls_along_their_outlines():
    rooms = (ModelRoom((box(1, 1, 3, 4),)), ModelRoom((box(3, 1, 7, 4),)))
    door = ModelDoor(np.array([[3.0, 2.0], [3.0, 2.9]]))
    grid = model_grid(FloorplanModel(rooms=rooms, doors=(door,)), 0.025, (220, 320))
    assert at(grid, (2, 3), (3, 1.5), (3, 2.5), (5, 3), (7.5, 3)) == [
        FREE, OCCUPIED, FREE, FREE, UNKNOWN
    ]  # fmt: skip


def test_columns_and_windows_are_walls_and_doors_of_nowhere_are_not_opened():
    walls = (*WALLS, ModelWall((box(4, 2.5, 4.4, 2.9),)), ModelWall((box(1, 4.5, 7, 4.7),)))
    window = ModelWindow(np.array([[4.0, 1.1], [5.0, 1.1]]), 0.2)
    away = ModelDoor(np.array([[2.0, 4.6], [3.0, 4.6]]), 0.1)
    grid = model_grid(FloorplanModel(walls, (DOOR, away), (window,)), 0.05, (110, 160))
    assert at(grid, (4.2, 2.7), (4.5, 1.1), (2.5, 4.6)) == [OCCUPIED] * 3
