# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Buildings found in pictures, as a user would hand them in."""

import cv2
import numpy as np
from PIL import Image
from plan_pictures import PX_PER_M, ROOM_COUNT, storey
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures import hypothesis as hypothesis_module
from fpnet_core.drawings.pictures.doubts import doubts_of
from fpnet_core.drawings.pictures.hypothesis import find_building
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import Drawing, DrawingScale, ReadOptions, ScaleSource
from fpnet_core.segmentation import segment_floorplan

CONFIG = SegmentationConfig()
LARGER = 2
"""The storey's pixels along one of these pictures."""

M_PER_PX = 1.0 / (LARGER * PX_PER_M)
BLACK = (0, 0, 0)


def drawn(thickness=4):
    """The storey at 40 pixels a metre."""
    picture, labels = storey(thickness=thickness)
    size = picture.shape[1] * LARGER, picture.shape[0] * LARGER
    return cv2.resize(picture, size, interpolation=cv2.INTER_NEAREST), labels


def doorways(picture):
    """Yield the boxes (x0, y0, x1, y1) of the storey's doorways in the walls of its corridor."""
    for row in (140, 180):
        y = LARGER * row
        is_open = (picture[y, 80:-80, 0] > 0).astype(np.int8)
        edges = np.flatnonzero(np.diff(is_open, prepend=0, append=0)) + 80
        for x0, x1 in edges.reshape(-1, 2):
            yield int(x0), y - 4, int(x1), y + 4


def with_dimensions(picture, labels):
    """Return the picture with a chain of dimensions along and one across each room."""
    for room in range(1, ROOM_COUNT):
        rows, cols = np.nonzero(labels == room)
        left, right, top, low = (
            LARGER * v for v in (cols.min(), cols.max(), rows.min(), rows.max())
        )
        y, x = top + (low - top) // 3, left + 2 * (right - left) // 3
        cv2.line(picture, (left, y), (right, y), BLACK, 2)
        cv2.line(picture, (x, top), (x, low), BLACK, 2)
        for update in (left + 20, x, right - 20):
            cv2.line(picture, (update - 4, y + 4), (update + 4, y - 4), BLACK, 2)
    return picture


def with_panels(picture, keep=0):
    """Return the picture with two panels of a sliding door in each doorway but the first ones."""
    for x0, y0, x1, y1 in list(doorways(picture))[keep:]:
        middle, y = (x0 + x1) // 2, (y0 + y1) // 2
        cv2.rectangle(picture, (x0 - 1, y - 2), (middle + 4, y - 1), BLACK, -1)
        cv2.rectangle(picture, (middle - 4, y + 1), (x1 + 1, y + 2), BLACK, -1)
    return picture


def read(picture, tmp_path, resolution_m=M_PER_PX):
    path = tmp_path / 'plan.png'
    Image.fromarray(picture).save(path)
    reading = read_plan(path, ReadOptions(resolution_m=resolution_m))
    return reading, segment_floorplan(reading.grid, CONFIG)


def doored(segmentation):
    return len({room for portal in segmentation.portals for room in portal.rooms})


@pytest.mark.parametrize('resolution_m', [M_PER_PX, None])
def test_chains_of_dimensions_cut_no_rooms(tmp_path, resolution_m):
    reading, rooms = read(with_dimensions(*drawn()), tmp_path, resolution_m)
    assert len(rooms.rooms) == ROOM_COUNT
    assert doored(rooms) == ROOM_COUNT
    assert reading.is_readable


@pytest.mark.parametrize('keep', [0, 5])
def test_panels_of_sliding_doors_shut_no_doorway(tmp_path, keep):
    picture, _ = drawn()
    assert len(list(doorways(picture))) == ROOM_COUNT - 1
    reading, rooms = read(with_panels(picture, keep), tmp_path)
    assert len(rooms.rooms) == ROOM_COUNT
    assert doored(rooms) == ROOM_COUNT
    assert reading.is_readable


def hall_with_two_offices(px_per_m):
    """A hall of 40 x 25 m, two offices with doors in its corner, and a door to the outside."""
    picture = np.full((31 * px_per_m, 46 * px_per_m, 3), 255, np.uint8)

    def box(x0, y0, x1, y1, colour=BLACK):
        ends = [(round((x + 3.0) * px_per_m), round((y + 3.0) * px_per_m)) for x, y in
                ((x0, y0), (x1, y1))]  # fmt: skip
        cv2.rectangle(picture, *ends, colour, -1)

    box(0.0, 0.0, 40.0, 25.0)
    box(0.3, 0.3, 39.7, 24.7, (255, 255, 255))
    for wall in ((5.0, 0.0, 5.15, 4.0), (10.0, 0.0, 10.15, 4.15), (0.0, 4.0, 10.15, 4.15)):
        box(*wall)
    for door in ((2.0, 3.98, 2.9, 4.17), (7.0, 3.98, 7.9, 4.17), (20.0, 24.68, 21.0, 25.02)):
        box(*door, (255, 255, 255))
    return picture


@pytest.mark.parametrize('px_per_m', [20, 50])
def test_a_hall_of_unknown_scale_has_its_offices(tmp_path, px_per_m):
    reading, rooms = read(hall_with_two_offices(px_per_m), tmp_path, None)
    areas = sorted(room.area_m2 for room in rooms.rooms)
    assert len(areas) == 3
    assert areas[2] / areas[0] == pytest.approx((39.4 * 24.4 - 9.85 * 3.85) / (4.7 * 3.7), rel=0.2)
    assert len(rooms.portals) >= 2
    assert 0.5 < reading.scale.resolution_m * px_per_m < 2.0
    assert not reading.scale.is_known


@pytest.mark.parametrize('is_said_by', ['resolution', 'length', 'drawing'])
def test_rooms_are_told_at_the_scale_that_is_said(monkeypatch, is_said_by):
    monkeypatch.setattr(
        hypothesis_module, 'segment_unknown_scale', lambda *_: pytest.fail('guessed')
    )
    picture, _ = storey()
    width, pixel_m = picture.shape[1], 1.0 / PX_PER_M
    units = DrawingScale(pixel_m, pixel_m, pixel_m, ScaleSource.UNITS)
    options = {
        'resolution': ReadOptions(resolution_m=pixel_m),
        'length': ReadOptions(length=(0.0, 9.0, width, 9.0, width * pixel_m)),
        'drawing': ReadOptions(),
    }[is_said_by]
    drawing = Drawing(picture, 'a.png', 'png', scale=units if is_said_by == 'drawing' else None)
    found = find_building(drawing, options, CONFIG)
    nominal_m = np.sqrt(abs(np.linalg.det(found.H_plan_pixel[:2, :2])))
    assert found.known_factor * nominal_m == pytest.approx(pixel_m)
    assert len(found.segmentation.rooms) == ROOM_COUNT
    assert not doubts_of(found, CONFIG).reasons
