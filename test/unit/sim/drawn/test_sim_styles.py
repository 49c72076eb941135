# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The looks that a drawing may have."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.geometry import Affine2D
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import CLEAN, STYLES, DrawingStyle
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
