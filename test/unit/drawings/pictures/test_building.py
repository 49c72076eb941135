# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Buildings as the parser sees them: from probabilities to cells, and whole sheets."""

import cv2
import numpy as np
from plan_pictures import WHITE, sheet, storey
import pytest

from fpnet_core.drawings.pictures.building import (
    see_building,
)
from fpnet_core.drawings.pictures.view import view_of
from fpnet_core.errors import MapFormatError
from fpnet_core.types import FREE


@pytest.mark.parametrize('quarters', [0, 1])
@pytest.mark.parametrize('colours', [(0, WHITE), ((150, 40, 30), WHITE), (90, 215)])
def test_rooms_are_seen_whatever_the_ink(colours, quarters):
    wall, paper = colours
    picture, labels = storey(wall=wall, paper=paper)
    picture, labels = np.rot90(picture, quarters), np.rot90(labels, quarters)
    seen = see_building(view_of(np.ascontiguousarray(picture)), None)
    truth = cv2.warpPerspective(
        np.ascontiguousarray(labels).astype(np.uint8), seen.H_cell_pixel, seen.cells.shape[::-1],
        flags=cv2.INTER_NEAREST,
    )  # fmt: skip
    # True rooms reach to the middle of walls.
    assert (seen.cells[truth > 0] == FREE).mean() > 0.85
    assert (seen.cells[truth == 0] != FREE).mean() > 0.9


def test_a_storey_that_is_not_there_is_said_so():
    picture, _ = storey()
    with pytest.raises(MapFormatError, match='expected 1 to 1'):
        see_building(view_of(picture), 2)


def test_an_empty_sheet_shows_no_building():
    assert see_building(view_of(np.full((200, 300, 3), WHITE, np.uint8)), None) is None


STRONG_FRAME = pytest.mark.xfail(
    reason='the network takes a strong frame for walls (notes/drawings.md)', strict=True
)
COURTYARD = pytest.mark.xfail(
    reason='the network takes windows upon a blank courtyard for doors (notes/drawings.md)',
    strict=True,
)


@pytest.mark.parametrize('thickness', [2, pytest.param(3, marks=STRONG_FRAME)])
def test_the_ground_within_a_frame_of_two_lines_is_no_room(thickness):
    """The network takes such a frame, 2 m beside the building, for a wall of two lines."""
    pad = ((40, 100), (40, 140))
    picture, labels = storey()
    framed = np.pad(picture, (*pad, (0, 0)), constant_values=WHITE)
    truth = np.pad(labels, pad)
    height, width = truth.shape
    for inset in (10, 16):
        corners = (inset, inset), (width - inset - 1, height - inset - 1)
        cv2.rectangle(framed, *corners, (0, 0, 0), thickness)
    for row in range(4):
        corners = (width - 146, height - 66 + 12 * row), (width - 17, height - 17)
        cv2.rectangle(framed, *corners, (0, 0, 0), 1)
    seen = see_building(view_of(framed), None)
    ground = cv2.erode((truth == 0).astype(np.uint8), np.ones((9, 9), np.uint8))
    outside = cv2.warpPerspective(ground, seen.H_cell_pixel, seen.cells.shape[::-1]) > 0
    assert (seen.cells[outside] == FREE).mean() < 0.01


def rooms_around(size, is_courtyard):
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


@pytest.mark.parametrize(
    ('size', 'is_courtyard', 'is_framed'),
    [
        ((1000, 800), False, False),
        ((1000, 800), False, True),
        ((1600, 1100), False, False),
        ((1600, 1100), False, True),
        pytest.param((1300, 1000), True, False, marks=COURTYARD),
    ],
)
def test_a_hall_is_as_large_as_its_walls_and_a_courtyard_outside(size, is_courtyard, is_framed):
    picture, truth = rooms_around(size, is_courtyard)
    if is_framed:
        picture, truth = sheet(picture, truth)
    seen = see_building(view_of(picture), None)
    space = cv2.warpPerspective(truth, seen.H_cell_pixel, seen.cells.shape[::-1]) > 0
    share = (seen.cells[space] == FREE).mean()
    assert share < 0.02 if is_courtyard else share > 0.98
    rim = np.concatenate([seen.cells[:3].ravel(), seen.cells[-3:].ravel()])
    assert (rim != FREE).all()
