# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys as drawings: in every style, locally off, on sheets of sites, with the truth kept."""

from dataclasses import replace

import numpy as np
from planted import plan_grid
import pytest
from scipy.ndimage import distance_transform_edt

from fpnet_core.geometry import Affine2D
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.evaluation.sites.site_drives import SIZES, site_likenesses
from fpnet_lab.sim.drawn.distort import rough_drawing
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.rough import robot_map_of
from fpnet_lab.sim.drawn.storeys import DIFFERENT, Likeness, draw_storeys, share_apart
from fpnet_lab.sim.drawn.styles import CLEAN, STYLES, DrawingStyle
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom

KINDS = (Likeness.OTHER, Likeness.TRUE, Likeness.EQUAL, Likeness.ALIKE)


@pytest.fixture(scope='module')
def storeys():
    rng = np.random.default_rng(11)
    return draw_storeys(generate_plan(rng, 'double_corridor'), KINDS, rng)


def test_storeys_differ_as_they_should(storeys):
    other, true, equal, alike = storeys
    assert [storey.name for storey in storeys] == ['L0', 'L1', 'L2', 'L3']
    assert (true.different, equal.different, other.different) == (0.0, 0.0, 1.0)
    assert DIFFERENT <= alike.different < 0.7
    np.testing.assert_array_equal(equal.drawn.grid.cells, true.drawn.grid.cells)
    assert alike.drawn.grid.shape == true.drawn.grid.shape
    apart = share_apart(true.drawn.grid, alike.drawn.grid)
    assert DIFFERENT <= apart < 0.7


def test_every_storey_has_a_sheet_of_its_own(storeys):
    poses = [storey.drawn.grid.T_frame_grid for storey in storeys]
    for k, pose in enumerate(poses):
        for other in poses[:k]:
            assert np.abs(pose.matrix - other.matrix).max() > 0.1


@pytest.mark.parametrize('count', SIZES)
@pytest.mark.parametrize('has_equal', [True, False])
def test_sites_hold_what_was_asked_for(count, has_equal):
    kinds = site_likenesses(count, np.random.default_rng(count), has_equal)
    assert len(kinds) == count
    assert kinds.count(Likeness.TRUE) == 1
    assert kinds.count(Likeness.EQUAL) == int(has_equal)
    assert kinds.count(Likeness.ALIKE) + kinds.count(Likeness.EQUAL) == 1 + (count - 1) // 2


def _box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


@pytest.fixture
def two_rooms():
    rooms = (PlanRoom(_box(0.1, 0.1, 4.9, 2.9)), PlanRoom(_box(5.1, 0.1, 7.9, 2.9)))
    door = PlanDoor((0, 1), np.array([[5.0, 1.0], [5.0, 1.9]]))
    return BuildingPlan(rooms, (door,), 0.2, 'test')


def _value(grid, xy):
    row, col = np.rint(grid.xy_to_rc(np.array(xy))).astype(int)
    return grid.cells[row, col]


TURN = Affine2D(
    np.diag([1.05, 0.96]) @ np.array([[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]]),
    np.array([-7.0, 3.5]),
)


@pytest.mark.parametrize('A', [Affine2D.identity(), TURN], ids=['as built', 'turned'])
def test_rooms_and_doors_are_free_walls_are_not(two_rooms, A):
    grid = render_plan(two_rooms, 0.05, T_plan_building=A)
    for xy in ((2.5, 1.5), (6.5, 2.0), (5.0, 1.45), (0.3, 0.3), (7.7, 2.7)):
        assert _value(grid, A.apply(xy)) == FREE
    for xy in ((5.0, 0.5), (5.0, 2.4), (0.0, 1.5), (6.5, 3.0)):
        assert _value(grid, A.apply(xy)) == OCCUPIED
    assert _value(grid, A.apply((2.5, 3.5))) == UNKNOWN
    assert grid.frame == 'plan'


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


def _two_rooms(**door):
    rooms = (PlanRoom(_box(0.15, 0.15, 4.85, 4.85)), PlanRoom(_box(5.15, 0.15, 9.85, 4.85)))
    return BuildingPlan(
        rooms, (PlanDoor((0, 1), np.array([[5.0, 1.0], [5.0, 2.0]]), **door),), 0.3, 'test'
    )


@pytest.fixture(scope='module')
def storey():
    return generate_plan(np.random.default_rng(4), 'suites')


@pytest.mark.parametrize('name', sorted(set(STYLES) - {'clean'}))
def test_every_style_changes_the_drawing(storey, name):
    clean, drawn = (render_plan(storey, 0.05, style=s) for s in (CLEAN, STYLES[name]))
    assert clean.cells.shape != drawn.cells.shape or (clean.cells != drawn.cells).any()
    assert set(np.unique(drawn.cells)) <= {FREE, OCCUPIED, UNKNOWN}


@pytest.mark.parametrize('name', sorted(STYLES))
@pytest.mark.parametrize('resolution', [0.01, 0.2])
def test_every_style_can_be_drawn_at_any_scale_and_angle(name, resolution):
    c, s = np.cos(0.7), np.sin(0.7)
    turn = Affine2D(np.array([[c, -s], [s, c]]), np.array([3.0, -40.0]))
    grid = render_plan(_two_rooms(), resolution, T_plan_building=turn, style=STYLES[name])
    assert _value(grid, turn.apply((1.0, 4.3))) == FREE
    assert np.count_nonzero(grid.cells == OCCUPIED) > 100


def test_equal_styles_give_equal_drawings_and_other_seeds_other_furniture(storey):
    style = DrawingStyle(furniture=True, text=True, seed=3)
    first, second = (render_plan(storey, 0.05, style=style) for _ in range(2))
    np.testing.assert_array_equal(first.cells, second.cells)
    other = render_plan(storey, 0.05, style=replace(style, seed=4))
    assert (other.cells != first.cells).any()
