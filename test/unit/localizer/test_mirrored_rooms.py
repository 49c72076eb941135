# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The mirror image of a plan that was cut once is the plan's, mirrored."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.geometry import SE2
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.moved import mirrored_rooms
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.plans import generate_plan


@pytest.fixture(scope='module')
def segmentation():
    plan = generate_plan(np.random.default_rng(8), 'branched', 10, 40)
    grid = render_plan(plan, 0.1)
    moved = replace(grid, T_frame_grid=SE2.from_xy_yaw(7.0, -3.0, 0.4))
    return segment_floorplan(moved, SegmentationConfig())


def test_twice_mirrored_is_the_same(segmentation):
    again = mirrored_rooms(mirrored_rooms(segmentation))
    assert np.array_equal(again.grid.cells, segmentation.grid.cells)
    assert np.array_equal(again.labels, segmentation.labels)
    for region, expected in zip(again.regions, segmentation.regions, strict=True):
        assert region.polygon == pytest.approx(expected.polygon)
        assert region.centroid == pytest.approx(expected.centroid)
    for portal, expected in zip(again.portals, segmentation.portals, strict=True):
        assert portal.ends == pytest.approx(expected.ends)


def test_rooms_lie_on_their_cells_and_run_counter_clockwise(segmentation):
    mirrored = mirrored_rooms(segmentation)
    assert len(mirrored.rooms) >= 10
    for room in mirrored.rooms:
        x, y = room.polygon.T
        assert np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)) > 0.0
        own = np.argwhere(mirrored.labels == room.id + 1)
        assert mirrored.grid.rc_to_xy(own).mean(axis=0) == pytest.approx(room.centroid, abs=0.2)


def test_it_is_what_cutting_the_mirrored_drawing_gives(segmentation):
    mirrored = mirrored_rooms(segmentation)
    cut = segment_floorplan(segmentation.grid.mirrored(), SegmentationConfig())
    assert len(cut.rooms) == len(mirrored.rooms)
    assert len(cut.doors) == len(mirrored.doors)
    for sides in ((cut.rooms, mirrored.rooms), (cut.doors, mirrored.doors)):
        found, expected = (np.array([region.centroid for region in side]) for side in sides)
        apart = np.linalg.norm(found[:, None] - expected, axis=2).min(axis=1)
        assert np.median(apart) < segmentation.grid.resolution
        assert apart.max() < 0.5
