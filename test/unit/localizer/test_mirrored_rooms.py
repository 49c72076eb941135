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
