# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Halls told from courtyards and from the paper within a frame, by doors."""

import cv2
import numpy as np
from plan_pictures import WHITE, sheet
import pytest

from fpnet_core.drawings.pictures.halls import given_halls, halls_of
from fpnet_core.drawings.pictures.learned import see_building
from fpnet_core.drawings.pictures.view import view_of
from fpnet_core.io.pixel_classes import CLASSES, DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.types import FREE

BELOW = np.s_[100:220, 60:300]
"""The middle of what lies below the rooms of :func:`rooms_above`."""


def chances(classes, sure=0.96):
    """Probabilities (K, H, W) of classes that are known but for a rest."""
    rest = (1.0 - sure) / (len(CLASSES) - 1)
    return np.stack([np.where(classes == k, sure, rest) for k in range(len(CLASSES))]).astype(
        np.float32
    )


def found(*pictures, ink=None):
    """Halls and their walls by looks at which classes are known."""
    none = np.zeros(pictures[0].shape, np.bool_)
    return halls_of([chances(each) for each in pictures], none if ink is None else ink)


def rooms_above(doors=3, windows=0, gap=0):
    """Three rooms, and below them what walls shut in but for a gap, seen as outside."""
    classes = np.full((280, 360), OUTSIDE, np.uint8)
    classes[40:240, 40:320] = WALL
    classes[84:236, 44:316] = OUTSIDE
    for k in range(3):
        left = 44 + 92 * k
        classes[44:80, left : left + 88] = FLOOR
        classes[80:84, left + 10 : left + 30] = DOOR if k < doors else WALL
        classes[80:84, left + 40 : left + 80] = WINDOW if k < windows else WALL
    classes[236:240, 180 : 180 + gap] = OUTSIDE
    return classes


@pytest.mark.parametrize(
    ('picture', 'is_hall'),
    [
        (rooms_above(), True),
        (rooms_above(doors=1), True),
        (rooms_above(doors=0), False),
        (rooms_above(gap=4), True),
        (rooms_above(gap=60), False),
        (rooms_above(doors=0, windows=3), False),
    ],
)
def test_what_walls_shut_in_is_a_hall_where_doors_lead_into_it(picture, is_hall):
    halls, walls = found(picture)
    assert halls[BELOW].all() == halls[BELOW].any() == is_hall
    assert walls[237:239, 60:170].all() == walls[237:239, 60:170].any() == is_hall
    assert not halls[:84].any()
    assert not (halls | walls)[242:].any()
    assert not (halls | walls)[:, :38].any()


def test_windows_of_many_rooms_look_upon_a_courtyard_with_a_door():
    classes = rooms_above(doors=1)
    classes[82, 54:74] = WALL  # a narrow door
    assert found(classes)[0][BELOW].all()
    classes[80:84, 90:316] = WINDOW
    assert not found(classes)[0].any()


def test_a_frame_shuts_in_no_hall():
    """The doors of the building that it surrounds lead out of this building."""
    classes = rooms_above()
    framed = np.full((480, 560), OUTSIDE, np.uint8)
    framed[10:470, 10:550] = WALL
    framed[14:466, 14:546] = OUTSIDE
    framed[100:380, 100:460] = classes
    framed[140:144, 160:240] = DOOR  # from the rooms to what the frame shuts in
    halls, walls = found(framed)
    assert halls[100:380, 100:460][BELOW].all()
    around = np.ones(framed.shape, np.bool_)
    around[138:342, 138:422] = False
    assert not (halls | walls)[around].any()


def test_any_look_may_show_a_wall():
    lost = rooms_above()
    lost[236:240] = OUTSIDE
    assert not found(lost)[0].any()
    assert found(lost, rooms_above())[0][BELOW].all()


def test_ink_that_goes_on_from_walls_is_wall_where_it_is_as_thick():
    lost = rooms_above()
    lost[236:240, 44:316] = OUTSIDE
    for thickness, is_hall in ((4, True), (1, False)):
        ink = np.zeros(lost.shape, np.bool_)
        ink[236 : 236 + thickness, 44:316] = True
        assert found(lost, ink=ink)[0][BELOW].any() == is_hall
    apart = np.zeros(lost.shape, np.bool_)
    apart[242:246, 60:300] = True
    assert not found(lost, ink=apart)[0].any()


def test_what_is_given_is_inside_and_sums_up():
    seen = chances(rooms_above())
    halls, walls = halls_of([seen], np.zeros(seen.shape[1:], np.bool_))
    given = given_halls(seen, halls, walls)
    np.testing.assert_allclose(given.sum(axis=0), 1.0, atol=1e-5)
    assert (given[FLOOR][halls] > 0.96).all()
    assert (given[OUTSIDE][halls | walls] == 0.0).all()
    rest = ~(halls | walls)
    np.testing.assert_allclose(given[:, rest], seen[:, rest], atol=1e-6)


def drawn(size, is_courtyard):
    """
    Rooms of 5 m in a row above a hall; or all around a corridor, with windows to a courtyard.

    Returns the picture (H, W, 3) and the middle of the hall or courtyard (H, W).
    """
    (width, height), room, left, wall = size, 100, 80, 6
    right, low = left + width, left + height
    picture = np.full((low + 80, right + 80, 3), WHITE, np.uint8)
    truth = np.zeros(picture.shape[:2], np.uint8)
    cv2.rectangle(picture, (left, left), (right, low), (0, 0, 0), wall)
    inset = (room if is_courtyard else 0) + 20
    truth[left + room + 20 : low - inset, left + inset : right - inset] = 1
    inner = (left, left + room), (right, low)
    if is_courtyard:
        inner = (left + room,) * 2, (right - room, low - room)
    cv2.rectangle(picture, *inner, (0, 0, 0), wall)
    (x0, y0), (x1, y1) = inner
    rows = (left, low - room) if is_courtyard else (left,)
    for x in range(left, right, room):
        for y in rows:
            cv2.line(picture, (x, y), (x, y + room), (0, 0, 0), wall)
        for y in (y0, y1)[: len(rows)]:
            if x0 <= x < x1:
                cv2.rectangle(picture, (x + 40, y - 4), (x + 60, y + 4), (WHITE,) * 3, -1)
    if is_courtyard:
        corner, opposite = (x0 + 45, y0 + 45), (x1 - 45, y1 - 45)
        truth[:] = 0
        truth[y0 + 60 : y1 - 60, x0 + 60 : x1 - 60] = 1
        cv2.rectangle(picture, corner, opposite, (0, 0, 0), wall)
        for x in range(x0 + 80, x1 - 120, 90):
            for y in (corner[1], opposite[1]):
                cv2.rectangle(picture, (x, y - 4), (x + 40, y + 4), (WHITE,) * 3, -1)
                for offset in (-3, 0, 3):
                    cv2.line(picture, (x, y + offset), (x + 40, y + offset), (0, 0, 0), 1)
    return picture, truth


@pytest.mark.parametrize('is_framed', [False, True])
@pytest.mark.parametrize(
    ('size', 'is_courtyard'), [((1000, 800), False), ((1600, 1100), False), ((1300, 1000), True)]
)
def test_a_hall_is_as_large_as_its_walls_and_a_courtyard_outside(size, is_courtyard, is_framed):
    picture, truth = drawn(size, is_courtyard)
    if is_framed:
        picture, truth = sheet(picture, truth)
    seen = see_building(view_of(picture), None)
    space = cv2.warpPerspective(truth, seen.H_cell_pixel, seen.cells.shape[::-1]) > 0
    share = (seen.cells[space] == FREE).mean()
    assert share < 0.02 if is_courtyard else share > 0.98
    rim = np.concatenate([seen.cells[:3].ravel(), seen.cells[-3:].ravel()])
    assert (rim != FREE).all()
