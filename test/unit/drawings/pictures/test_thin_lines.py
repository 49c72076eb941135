# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lines that are thinner than walls: they cut rooms and shut doors until a reading is without."""

import cv2
import numpy as np
from PIL import Image
from plan_pictures import PX_PER_M, ROOM_COUNT, storey
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.found import NOMINAL_M, Found, likelihood, rooms_of
from fpnet_core.drawings.pictures.thin_lines import without_thin_lines
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

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
        for tick in (left + 20, x, right - 20):
            cv2.line(picture, (tick - 4, y + 4), (tick + 4, y - 4), BLACK, 2)
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


def reading_of(cells):
    rooms, _ = rooms_of(cells, NOMINAL_M, CONFIG)
    return Found(cells, np.eye(3), rooms, likelihood(rooms), 'by hand')


def building(shut=True):
    """Four rooms of 5 m x 5 m with doors in thin partitions, the last one behind a thick wall."""
    cells = np.full((140, 460), UNKNOWN, np.int8)
    cells[10:130, 10:450] = OCCUPIED
    cells[18:122, 18:442] = FREE
    for x, thickness in ((120, 2), (220, 2), (320, 8)):
        cells[18:122, x : x + thickness] = OCCUPIED
        if thickness == 2 or not shut:
            cells[60:78, x : x + thickness] = FREE
    return cells


def test_thin_partitions_stay_although_a_room_has_no_door():
    found = reading_of(building())
    assert len(found.segmentation.rooms) - doored(found.segmentation) == 1
    assert without_thin_lines(found, CONFIG) is found


def test_no_line_goes_where_every_room_has_a_door(monkeypatch):
    found = reading_of(building(shut=False))
    monkeypatch.setattr(Found, 'with_cells', lambda *_: pytest.fail('was cut anew'))
    assert without_thin_lines(found, CONFIG) is found
