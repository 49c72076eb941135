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
from fpnet_core.drawings.types import DrawingScale, ScaleSource

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
