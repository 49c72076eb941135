# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The looks that a drawing may have."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.geometry import Affine2D
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import CLEAN, STYLES, DrawingStyle, StyleConfig, draw_style
from fpnet_lab.sim.drawn.symbols import door_marks
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom


def _box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


def _two_rooms(**door):
    rooms = (PlanRoom(_box(0.15, 0.15, 4.85, 4.85)), PlanRoom(_box(5.15, 0.15, 9.85, 4.85)))
    return BuildingPlan(
        rooms, (PlanDoor((0, 1), np.array([[5.0, 1.0], [5.0, 2.0]]), **door),), 0.3, 'test'
    )


def _value(grid, xy):
    row, col = np.rint(grid.xy_to_rc(np.array(xy))).astype(int)
    return grid.cells[row, col]


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


def test_outlined_walls_are_hollow_and_hatched_ones_half_filled():
    fractions = []
    for style in (CLEAN, DrawingStyle(walls='double', hatching=True), DrawingStyle('double')):
        grid = render_plan(_two_rooms(), 0.02, style=style)
        fractions.append(np.count_nonzero(grid.cells == OCCUPIED))
        assert _value(grid, (4.87, 3.5)) == OCCUPIED
    assert fractions[0] > 1.5 * fractions[1] > 1.5 * fractions[2]
    assert _value(grid, (5.0, 3.5)) == FREE


def test_thick_walls_take_floor_from_the_rooms():
    free = [
        np.count_nonzero(render_plan(_two_rooms(), 0.05, style=DrawingStyle(walls)).cells == FREE)
        for walls in ('thin', 'solid', 'thick')
    ]
    assert free[0] > free[1] > free[2]


def test_white_paper_leaves_nothing_unknown():
    grid = render_plan(_two_rooms(), 0.05, style=DrawingStyle(white_paper=True))
    assert not (grid.cells == UNKNOWN).any()


def test_windows_open_outer_walls_only():
    clean = render_plan(_two_rooms(), 0.02)
    drawn = render_plan(_two_rooms(), 0.02, style=DrawingStyle(windows=True))
    rows, cols = np.nonzero((clean.cells == OCCUPIED) & (drawn.cells == FREE))
    xy = drawn.rc_to_xy(np.stack([rows, cols], axis=1))
    assert len(xy)
    outside = (xy < 0.15).any(axis=1) | (xy[:, 0] > 9.85) | (xy[:, 1] > 4.85)
    assert outside.all()
    for room_side in ((2.5, 0.155), (2.5, 4.845)):
        assert _value(drawn, room_side) == OCCUPIED, 'the inner line keeps the room closed'


@pytest.mark.parametrize(('swing', 'x'), [(0, 3.85), (1, 6.15)])
@pytest.mark.parametrize(('hinge', 'y'), [(0, 1.0), (1, 2.0)])
def test_a_leaf_hangs_at_its_hinge_and_opens_into_its_room(swing, x, hinge, y):
    plan = _two_rooms(swing=swing, hinge=hinge)
    (leaf,) = door_marks(plan, 0.3, with_arcs=False)
    np.testing.assert_allclose(leaf[1], (x, y), atol=1e-9)
    (arc,) = door_marks(plan, 0.3, with_arcs=True)
    shut = arc[-1]
    np.testing.assert_allclose(shut, (leaf[0][0], 3.0 - y), atol=1e-9)


def test_wide_doors_have_two_leaves_and_passages_none():
    wide = replace(_two_rooms().doors[0], ends=np.array([[5.0, 1.0], [5.0, 3.0]]))
    plan = replace(_two_rooms(), doors=(wide,))
    lengths = [np.hypot(*(leaf[1] - leaf[0])) for leaf in door_marks(plan, 0.3, False)]
    assert lengths == pytest.approx([1.0, 1.0])
    assert door_marks(replace(plan, doors=(replace(wide, is_open=True),)), 0.3, True) == []


def test_dimension_lines_stay_outside():
    clean = render_plan(_two_rooms(), 0.05)
    drawn = render_plan(_two_rooms(), 0.05, style=DrawingStyle(dimensions=True))
    changed = np.argwhere(clean.cells != drawn.cells)
    assert len(changed) > 200
    assert (clean.cells[tuple(changed.T)] == UNKNOWN).all()


def test_shares_of_styles_are_kept():
    config = StyleConfig()
    rng = np.random.default_rng(0)
    styles = [draw_style(rng, config) for _ in range(2000)]
    assert np.mean([s.walls == 'double' for s in styles]) == pytest.approx(
        config.double_walls, abs=0.03
    )
    assert np.mean([s.doors == 'arc' for s in styles]) == pytest.approx(config.door_arcs, abs=0.03)
    assert np.mean([s.text for s in styles]) == pytest.approx(config.text, abs=0.03)
