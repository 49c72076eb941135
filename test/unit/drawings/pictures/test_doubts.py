# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What speaks against a building that was found, where, and what is said of it."""

from dataclasses import replace

import numpy as np
from PIL import Image
from plan_pictures import storey
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures import doubts as doubts_module
from fpnet_core.drawings.pictures.building import SeenBuilding
from fpnet_core.drawings.pictures.doubts import (
    ROOM_FIGURES,
    SHEET_FIGURES,
    doubts_of,
    evidence_of,
    model_of,
    packaged_doubt_model,
)
from fpnet_core.drawings.pictures.hypothesis import PlanHypothesis, rooms_of
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.stated import SaidScale
from fpnet_core.errors import WeightsError
from fpnet_core.io.pixel_classes import CLASSES, DOOR, FLOOR, OUTSIDE, WALL
from fpnet_core.segmentation.scale_model import ScalePrior
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

CONFIG = SegmentationConfig()
ANY_SCALE = ScalePrior(np.log([0.001, 1.0]), np.zeros(2))


def classes(doors=True):
    """Six rooms along a corridor, 300 x 200 pixels, walls 6 pixels thick, paper around it."""
    found = np.full((240, 340), OUTSIDE, np.uint8)
    found[17:223, 17:323] = WALL
    for left in (23, 123, 223):
        found[23:97, left : left + 94] = found[143:217, left : left + 94] = FLOOR
        if doors:
            found[97:103, left + 38 : left + 56] = found[137:143, left + 38 : left + 56] = DOOR
    found[103:137, 23:317] = FLOOR
    return found


def chances(known, sure=0.97):
    rest = (1.0 - sure) / (len(CLASSES) - 1)
    each = [np.where(known == k, sure, rest) for k in range(len(CLASSES))]
    return np.stack(each).astype(np.float32)


def found(known, seen=None, first=None):
    """A building of these classes, of which the looks saw others."""
    cells = np.select(
        [known == WALL, (known == FLOOR) | (known == DOOR)], [OCCUPIED, FREE], UNKNOWN
    ).astype(np.int8)
    looks = [chances(known) if each is None else each for each in (seen, first)]
    building = SeenBuilding(cells, *looks, np.eye(3), ((0, 0, 340, 240),), 0, ANY_SCALE)
    rooms, _ = rooms_of(cells, CONFIG)
    return PlanHypothesis(cells, np.eye(3), rooms, SaidScale(), seen=building)


def whole(building, name):
    return evidence_of(building, CONFIG).whole[SHEET_FIGURES.index(name) - 3]


def test_nothing_speaks_against_a_plain_building():
    plain = found(classes())
    evidence = evidence_of(plain, CONFIG)
    assert evidence.rooms.shape == (7, len(ROOM_FIGURES))
    for name, expected in (('floor', 0.97), ('walled', 0.97), ('open', 0.0), ('other', 1.0)):
        np.testing.assert_allclose(
            evidence.rooms[:, ROOM_FIGURES.index(name)], expected, atol=0.04, err_msg=name
        )
    assert whole(plain, 'agreement') == 1.0
    assert whole(plain, 'lost') < 0.05
    assert doubts_of(plain, CONFIG).reasons == ()


def test_the_packaged_model_refuses_other_figures():
    model = packaged_doubt_model()
    assert 0.0 < model.doubted_from < 1.0
    regression = {'figures': ['size'], 'mean': [0], 'spread': [1], 'weight': [1], 'bias': 0}
    with pytest.raises(WeightsError, match='train doubts'):
        model_of({'rooms': regression, 'sheets': regression, 'others': regression})


def test_places_and_reasons_are_those_of_the_rooms_in_doubt(monkeypatch):
    seen = chances(classes())
    seen[:, 23:97, 23:117] = chances(np.full((74, 94), OUTSIDE), 0.9)
    building = found(classes(), seen)
    strict = replace(packaged_doubt_model(), doubted_from=0.0)
    monkeypatch.setattr(doubts_module, 'packaged_doubt_model', lambda: strict)
    doubts = doubts_of(building, CONFIG)
    assert any('at the upper left' in reason for reason in doubts.reasons), doubts
    assert doubts.places[0].box == pytest.approx((23, 23, 117, 97), abs=6)


def test_a_picture_of_something_else_is_said_to_be_one(monkeypatch):
    certain = replace(packaged_doubt_model(), other_from=0.0)
    assert not doubts_of(found(classes()), CONFIG).is_other
    monkeypatch.setattr(doubts_module, 'packaged_doubt_model', lambda: certain)
    doubts = doubts_of(found(classes()), CONFIG)
    assert doubts.is_other
    assert 'something other than a floorplan' in doubts.reasons[0]


def test_rooms_that_mostly_have_no_door_are_doubted():
    reasons = doubts_of(found(classes(doors=False)), CONFIG).reasons
    assert any('No door was found' in reason for reason in reasons), reasons


def test_nothing_enclosed_is_no_building():
    doubts = doubts_of(found(np.full((240, 340), OUTSIDE, np.uint8)), CONFIG)
    assert doubts.wrong == 1.0
    assert doubts.reasons[0].startswith('No room was found')


def test_a_drawing_is_read_with_its_doubts(tmp_path):
    picture, _ = storey()
    Image.fromarray(picture).save(tmp_path / 'plan.png')
    reading = read_plan(tmp_path / 'plan.png')
    assert reading.doubts == ()
    assert reading.doubtful == ()
