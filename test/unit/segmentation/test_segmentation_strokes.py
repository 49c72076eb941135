# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Leaves and arcs of doors leave drawings; everything else stays."""

import cv2
import numpy as np
import pytest
from real_data import DATA, needs

from fpnet_core.config import SegmentationConfig
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.strokes import erase_door_symbols
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import STYLES
from fpnet_lab.sim.plans import generate_plan

RESOLUTION_M = 0.05
DOORWAY_M = 0.9
PLANS = DATA / 'bormann' / 'floorplan'


def leaf_and_arc():
    """Places of a leaf in the doorway of two rooms, and of its arc."""
    sweep = np.linspace(0.0, np.pi / 2.0, 20)
    arc = np.stack([4.1 + DOORWAY_M * np.cos(sweep), 2.0 + DOORWAY_M * np.sin(sweep)], axis=1)
    return np.concatenate([[(4.1, 2.0)], arc])


def two_rooms(angle_deg, symbol=None, scale=1.0):
    """Two rooms side by side whose doorway shows a symbol, turned about the middle."""
    turn = np.radians(angle_deg)
    T = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) * scale

    def px(xy):
        return np.rint(((np.array(xy) - (4.0, 2.5)) @ T.T + 6.0) / RESOLUTION_M * 16).astype(int)

    def fill(x0, y0, x1, y1, value):
        corners = px([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        cv2.fillPoly(cells, [corners], int(value), shift=4)

    cells = np.full((round(12.0 / RESOLUTION_M),) * 2, OCCUPIED, np.uint8)
    fill(0.0, 0.0, 3.9, 5.0, FREE)
    fill(4.1, 0.0, 8.0, 5.0, FREE)
    fill(3.8, 2.0, 4.2, 2.0 + DOORWAY_M, FREE)
    if symbol is not None:
        cv2.polylines(cells, [px(symbol)], False, int(OCCUPIED), 1, shift=4)
    return cells.astype(np.int8)


@pytest.mark.parametrize('scale', [0.85, 1.0, 1.2])
@pytest.mark.parametrize('angle_deg', [0.0, 17.0, 200.0])
def test_a_doorway_with_leaf_and_arc_is_one_door(angle_deg, scale):
    grid = GridMap(two_rooms(angle_deg, leaf_and_arc(), scale), RESOLUTION_M)
    found = segment_floorplan(grid, SegmentationConfig())
    (portal,) = found.portals
    assert None not in portal.rooms
    centre = 6.0 + scale * np.array([0.0, -0.05]) @ rotation(angle_deg).T
    assert portal.ends.mean(axis=0) == pytest.approx(centre, abs=0.25)


def rotation(angle_deg):
    turn = np.radians(angle_deg)
    return np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])


@pytest.mark.parametrize('angle_deg', [0.0, 17.0])
def test_walls_stay_and_hardly_a_trace_of_the_symbol_does(angle_deg):
    bare = two_rooms(angle_deg) == FREE
    drawn = two_rooms(angle_deg, leaf_and_arc()) == FREE
    erased = erase_door_symbols(drawn, RESOLUTION_M)
    assert not (erased & ~bare).sum() > 4
    left = (bare & ~erased).sum() / (bare & ~drawn).sum()
    assert left < 0.2


def test_most_doors_drawn_with_arcs_are_found():
    style = STYLES['sketch']
    found, doors = 0, 0
    for seed in (5, 6, 8, 9):
        plan = generate_plan(np.random.default_rng([0, seed]), max_rooms=50)
        portals = segment_floorplan(
            render_plan(plan, RESOLUTION_M, style=style), SegmentationConfig()
        ).portals
        at = np.array([portal.ends.mean(axis=0) for portal in portals])
        for door in plan.doors:
            if not door.is_open:
                doors += 1
                found += np.hypot(*(at - door.ends.mean(axis=0)).T).min() <= 0.6
    assert found >= 0.85 * doors


# Of the first storey's furniture two chairs stand in a doorway, see below.
@pytest.mark.parametrize(
    ('style', 'seed'),
    [
        *((style, 1) for style in ('clean', 'thin', 'double', 'lettered')),
        *(('furnished', seed) for seed in range(2, 8)),
    ],
)
def test_drawings_without_arcs_stay_as_they_are(style, seed):
    plan = generate_plan(np.random.default_rng([0, seed]), max_rooms=50)
    free = render_plan(plan, 0.08, style=STYLES[style]).cells == FREE
    np.testing.assert_array_equal(erase_door_symbols(free, 0.08), free)


@pytest.mark.real
@needs('bormann')
@pytest.mark.parametrize('plan', ['office_b', 'NLB'])
def test_real_plans_without_arcs_stay_as_they_are(plan):
    free = cv2.imread(str(PLANS / f'{plan}.png'), cv2.IMREAD_GRAYSCALE) >= 250
    np.testing.assert_array_equal(erase_door_symbols(free, RESOLUTION_M), free)


@pytest.mark.parametrize('seed', [1, 2, 8])
def test_chairs_in_a_doorway_may_go_and_walls_stay(seed):
    plan = generate_plan(np.random.default_rng([0, seed]), max_rooms=50)
    furnished, bare = (
        render_plan(plan, 0.08, style=STYLES[style]).cells == FREE
        for style in ('furnished', 'clean')
    )
    erased = erase_door_symbols(furnished, 0.08)
    assert (erased >= furnished).all()
    assert not (erased & ~furnished & ~bare).any()
    assert (erased != furnished).sum() < 1e-3 * bare.sum()


def test_an_arc_before_a_closed_wall_stays():
    cells = two_rooms(0.0, leaf_and_arc())
    cells[:, 117:122] = OCCUPIED
    free = cells == FREE
    np.testing.assert_array_equal(erase_door_symbols(free, RESOLUTION_M), free)
