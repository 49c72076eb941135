# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doors are told by the arc and the leaf, however these are written; curved walls stay."""

import numpy as np
import pytest

from fpnet_core.drawings.formats.doors import find_doors
from fpnet_core.drawings.formats.pages import (
    BLACK,
    PageBuilder,
    Paint,
    Ring,
    outline_pieces,
)
from fpnet_core.drawings.formats.units import resolve_unit, wall_thickness


def arc(centre, radius, start, stop, count=13):
    angle = np.radians(np.linspace(start, stop, count))
    return np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def pieces(*rings):
    builder = PageBuilder('test')
    for points in rings:
        builder.add([Ring(np.asarray(points, float))], Paint(stroke=BLACK))
    return outline_pieces(builder.finish())


def door(hinge=(5.0, 3.0), width=0.9, start=30.0):
    leaf = [hinge, arc(hinge, width, start, start, 1)[0]]
    return leaf, arc(hinge, width, start, start + 90.0)


BOX = [(0, 0), (20, 0), (20, 10), (0, 10), (0, 0)]


@pytest.mark.parametrize('grid', [1e-6, 0.02])
def test_a_leaf_and_its_arc_are_a_door(grid):
    leaf, swept = (np.round(np.asarray(p) / grid) * grid for p in door())
    found = find_doors(pieces(BOX, leaf, swept), None, 20.0)
    assert found.width == pytest.approx([0.9], rel=0.02)
    assert found.is_door.tolist() == [False] * 4 + [True] * (1 + 12)


def test_an_arc_without_a_leaf_is_a_door_beside_others_only():
    alone = arc((12.0, 3.0), 1.0, 0.0, 90.0)
    assert not find_doors(pieces(BOX, alone), None, 20.0).is_door.any()
    found = find_doors(pieces(BOX, *door(), alone), None, 20.0)
    assert found.is_door[-12:].all()
    assert len(found.width) == 1


def test_curved_walls_circles_and_polygons_are_no_doors():
    wall = arc((10.0, 5.0), 4.0, 0.0, 90.0, 30)
    column = arc((3.0, 3.0), 0.4, 0.0, 360.0, 25)
    octagon = arc((15.0, 5.0), 1.0, 0.0, 360.0, 9)
    assert not find_doors(pieces(BOX, wall, column, octagon), 1.0, 20.0).is_door.any()


def double_walls(thickness):
    walls = []
    for y in (0.0, 4.0, 8.0):
        walls += [[(0, y), (12, y)], [(0.2, y + thickness), (12.2, y + thickness)]]
    return pieces(*walls)


@pytest.mark.parametrize('unit_m', [0.001, 0.01, 1.0, 0.0254, 0.3048])
@pytest.mark.parametrize('stated_m', [0.001, 1.0, None])
def test_units_by_doors(unit_m, stated_m):
    rings = [BOX, *door(), *door((9.0, 4.0), 0.8), *door((14.0, 4.0), 1.0)]
    found = resolve_unit(
        pieces(*[np.asarray(ring) / unit_m for ring in rings]),
        pieces(BOX),
        stated_m,
        20.0 / unit_m,
    )
    assert found.length_m == pytest.approx(unit_m)
    assert found.stated_m == stated_m


def test_units_without_doors_are_not_guessed_against_the_header():
    walls = double_walls(0.15)
    assert resolve_unit(walls, walls, 1.0, 12.0).length_m == 1.0
    # 10 m of walls of 15 mm as stated, or 100 m of walls of 15 cm: nobody knows.
    faces = [np.array([(0.0, y), (9600.0, y)]) for y in (0.0, 4000.0)]
    thin = pieces(*faces, *[face + 15.0 for face in faces])
    assert wall_thickness(thin) == pytest.approx(15.0)
    assert resolve_unit(thin, thin, 0.001, 10_000.0).length_m is None
