# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Strokes and boxes on a layer of doors are doors where they reach from wall to wall."""

import ezdxf
import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.formats.door_strokes import find_door_strokes
from fpnet_core.drawings.formats.pages import BLACK, PageBuilder, Paint, Ring, outline_pieces
from fpnet_core.drawings.formats.worker import read_here
from fpnet_core.drawings.read import read_drawing
from fpnet_core.drawings.types import ReadOptions

# Two rooms of 5 x 4 m, their outlines 0.2 m apart, and a door through both at x = 5.1, y = 1 to 2.
ROOMS = [(0.0, 0.0, 5.0, 4.0), (5.2, 0.0, 10.2, 4.0)]
DOOR = (5.0, 1.0, 5.2, 2.0)


def box(x0, y0, x1, y1):
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])


def pieces(*lines):
    builder = PageBuilder('test')
    for points in lines:
        builder.add([Ring(np.asarray(points, float))], Paint(stroke=BLACK))
    return outline_pieces(builder.finish())


def test_a_line_to_the_moon_takes_no_memory_and_hides_no_door():
    walls = pieces(*(box(*room) for room in ROOMS), [(0.0, 50.0), (4e8, 50.0)])
    assert len(find_door_strokes(pieces(box(*DOOR)), walls, 1.0).depth) == 1


def drawn(path, per_m=1000.0):
    document = ezdxf.new()
    document.units = 4
    space = document.modelspace()
    for room in ROOMS:
        for shift in (0.0, 4.2):
            points = per_m * (box(*room)[:-1] + np.array([0.0, shift]))
            space.add_lwpolyline(points, close=True, dxfattribs={'layer': 'ROOMS'})
    for door in (DOOR, (2.0, 4.0, 3.0, 4.2), (7.0, 4.0, 8.0, 4.2)):
        points = per_m * box(*door)[:-1]
        space.add_lwpolyline(points, close=True, dxfattribs={'layer': 'DOORS'})
    document.saveas(path)
    return path


def test_rooms_that_are_outlines_are_joined_by_the_doors_of_a_dxf(tmp_path):
    drawing = read_here(drawn(tmp_path / 'rooms.dxf'), 'dxf', ReadOptions())
    assert [door.source for door in drawing.model.doors] == ['layer of doors'] * 3
    reading = read_drawing(drawing, ReadOptions(), FpnetConfig().segmentation)
    assert not reading.is_other
    assert len(reading.segmentation.rooms) == 4
    joined = {frozenset(portal.rooms) for portal in reading.segmentation.portals}
    assert len(joined) == 3


def placed(points, turn=0.0, per_m=1.0):
    c, s = np.cos(turn), np.sin(turn)
    return per_m * np.asarray(points, float) @ np.array([[c, s], [-s, c]])


def found(*lines, turn=0.0, per_m=1.0, unit_m=None):
    doors = pieces(*(placed(line, turn, per_m) for line in lines))
    walls = pieces(*(placed(box(*room), turn, per_m) for room in ROOMS))
    return find_door_strokes(doors, walls, 1.0 / per_m if unit_m is None else unit_m)


def test_leaves_frames_and_what_is_far_too_long_are_not():
    leaf = [(5.0, 2.0), (4.1, 2.0)]  # into the room
    frame = box(5.0, 1.0, 5.2, 1.05)
    assert not len(found(leaf, frame, [(5.1, 0.1), (5.1, 3.9)]).depth)
    assert not len(find_door_strokes(pieces(box(*DOOR)), pieces(), 1.0).depth)
    assert not len(find_door_strokes(pieces(box(*DOOR)), pieces(box(*ROOMS[0])), None).depth)
