# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings that are locally off, and robot maps made of drawings: is the truth kept?"""

import numpy as np
from planted import plan_grid
import pytest
from scipy.ndimage import distance_transform_edt

from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.sim.drawn.distort import rough_drawing
from fpnet_lab.sim.drawn.rough import robot_map_of

SEEDS = range(6)


@pytest.mark.parametrize('seed', SEEDS)
def test_walls_are_where_the_truth_says_they_moved_to(seed):
    grid = plan_grid()
    rough = rough_drawing(grid, np.random.default_rng(seed))
    walls = np.argwhere(grid.cells == OCCUPIED)[::20]
    there = np.rint(rough.grid.xy_to_rc(rough.displaced(grid.rc_to_xy(walls)))).astype(int)
    inside = ((there >= 0) & (there < grid.shape)).all(axis=1)
    off = distance_transform_edt(rough.grid.cells != OCCUPIED)[tuple(there[inside].T)]
    # A few pieces of wall are left out on purpose.
    assert np.mean(off <= 2.0) > 0.8


def test_the_same_seed_gives_the_same_drawing_and_map():
    for make in (lambda g, r: rough_drawing(g, r).grid, robot_map_of):
        first, second = (make(plan_grid(), np.random.default_rng(3)).cells for _ in range(2))
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize('seed', SEEDS)
def test_a_robot_map_has_most_of_the_floor_and_walls_beside_it(seed):
    grid = plan_grid()
    made = robot_map_of(grid, np.random.default_rng(seed))
    was_free = grid.cells == FREE
    assert (made.cells[was_free] == FREE).mean() > 0.75
    # Nothing appears where the drawing shows nothing.
    assert (made.cells[grid.cells == UNKNOWN] == UNKNOWN).all()
    near = distance_transform_edt(made.cells != OCCUPIED)[grid.cells == OCCUPIED]
    assert np.mean(near <= 3.0) > 0.7
    assert made.resolution == grid.resolution
