# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Leaves and arcs of a drawing are doors with a hinge, in the coordinates of the file."""

import numpy as np
from plan_files import Plan, _svg_place, arc_points, write_dxf, write_svg
import pytest

from fpnet.exports.segmented_model import complete_model
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.formats.worker import read_here
from fpnet_core.drawings.model import DoorKind
from fpnet_core.drawings.read import read_drawing
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.types import FREE


def doors_of(path):
    model = read_here(path, path.suffix[1:], ReadOptions()).model
    assert not model.is_whole
    return model.doors


def test_doors_of_a_dxf_have_hinge_leaf_and_line(tmp_path):
    plan = Plan(turn=0.4, origin=(4500.0, -120.0))
    doors = doors_of(write_dxf(tmp_path / 'a.dxf', plan))
    assert len(doors) == 3
    door = min(doors, key=lambda each: np.hypot(*(each.ends[0] - plan.place([(6.0, 2.0)])[0])))
    np.testing.assert_allclose(door.ends, plan.place([(6.0, 2.0), (6.0, 2.9)]), atol=0.02)
    np.testing.assert_allclose(door.leaf, plan.place([(5.1, 2.0)])[0], atol=0.02)
    assert (door.kind, door.hinge) == (DoorKind.SWING, 0)


def test_a_reading_has_the_doors_that_are_drawn_in_metres_of_its_map(tmp_path):
    plan = Plan(1000.0, origin=(70_000.0, 0.0))
    drawing = read_here(write_dxf(tmp_path / 'a.dxf', plan, 4), 'dxf', ReadOptions())
    reading = read_drawing(drawing, ReadOptions(), FpnetConfig().segmentation)
    assert [door.width_m for door in reading.model.doors] == pytest.approx([0.9] * 3, rel=0.02)
    rows, cols = (
        np.rint(reading.grid.xy_to_rc([door.ends.mean(axis=0) for door in reading.model.doors]))
        .astype(int)
        .T
    )
    assert reading.grid.cells[rows, cols].tolist()[0] == FREE
    model = complete_model(reading)
    assert 'door symbol' in [door.source for door in model.doors]
    assert 'Office' in [room.name for room in model.rooms]


@pytest.mark.parametrize('head', ['', 'data-x="1"'])
def test_two_leaves_that_meet_are_one_door(tmp_path, head):
    plan = Plan(20.0)
    arc = arc_points()
    other = arc * (1, -1) + (0.0, 2 * 2.9)  # mirrored at where the first one ends
    lines = [other, [(6.0, 3.8), (5.1, 3.8)]]
    body = ''.join(
        '<polyline fill="none" stroke="black" points="'
        + ' '.join(f'{x:.4f},{y:.4f}' for x, y in _svg_place(line, plan)) + '"/>'
        for line in lines
    )  # fmt: skip
    (door,) = doors_of(write_svg(tmp_path / 'a.svg', plan, body, head))
    assert door.kind is DoorKind.DOUBLE
    ends = _svg_place([(6.0, 2.0), (6.0, 3.8)], plan)
    np.testing.assert_allclose(sorted(door.ends.tolist()), sorted(ends.tolist()), atol=0.5)
