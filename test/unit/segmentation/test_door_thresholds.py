# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lines across doorways are sills, unless they are windows or as thick as walls."""

import cv2
import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.metrics.openings import place_agreement
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import DrawingStyle
from fpnet_lab.sim.plans import generate_plan

CELL_M = 0.025
WALL_M = 0.2


def two_rooms(lines, angle_deg=0.0, wall_m=WALL_M, arc=False, letters=False, windows=0):
    """Two rooms whose doorway of 0.9 m is crossed by ``lines``, as windows in outer walls are."""
    turn = np.radians(angle_deg)
    T = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])

    def px(xy):
        return np.rint(((np.array(xy) - (4.0, 2.5)) @ T.T + 6.0) / CELL_M * 16).astype(int)

    def fill(x0, y0, x1, y1, value):
        corners = px([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        cv2.fillPoly(cells, [corners], int(value) % 256, shift=4)

    def draw(xy):
        cv2.polylines(cells, [px(xy)], False, int(OCCUPIED), 1, shift=4)

    half = wall_m / 2.0
    cells = np.full((480, 480), UNKNOWN, np.int8).view(np.uint8)
    fill(-0.3, -0.3, 8.3, 5.3, OCCUPIED)
    fill(0.0, 0.0, 4.0 - half, 5.0, FREE)
    fill(4.0 + half, 0.0, 8.0, 5.0, FREE)
    fill(4.0 - half, 2.0, 4.0 + half, 2.9, FREE)
    for x in np.linspace(4.0 - half, 4.0 + half, lines) if lines > 1 else [4.0] * lines:
        draw([(x, 2.0), (x, 2.9)])
    for x in (1.0, 2.5, 5.0, 6.5) if windows else ():
        fill(x, -0.35, x + 0.9, 0.05, FREE)
        for y in np.linspace(-0.25, -0.05, windows) if windows > 1 else [-0.15]:
            draw([(x, y), (x + 0.9, y)])
    if arc:
        sweep = np.linspace(0.0, np.pi / 2.0, 30)
        swept = np.stack([4.0 + half + 0.9 * np.cos(sweep), 2.0 + 0.9 * np.sin(sweep)], axis=1)
        draw(np.concatenate([[(4.0 + half, 2.0)], swept]))
    if letters:
        for y in (2.45, 2.6):
            for x in (4.4, 4.55, 4.7, 4.85):
                draw([(x, y), (x + 0.08, y), (x + 0.08, y + 0.1), (x, y + 0.1)])
    return GridMap(cells.view(np.int8), CELL_M)


def doors(grid):
    return segment_floorplan(grid, SegmentationConfig()).portals


@pytest.mark.parametrize('lines', [1, 2])
@pytest.mark.parametrize('angle_deg', [0.0, 17.0, 45.0])
@pytest.mark.parametrize('arc', [False, True])
def test_a_doorway_with_sills_is_a_door(lines, angle_deg, arc):
    (portal,) = doors(two_rooms(lines, angle_deg, arc=arc))
    assert None not in portal.rooms
    turn = np.radians(angle_deg)
    middle = 6.0 + 0.05 * np.array([np.sin(turn), -np.cos(turn)])
    assert portal.ends.mean(axis=0) == pytest.approx(middle, abs=0.25)


def test_three_lines_are_a_window():
    assert not doors(two_rooms(3, wall_m=0.3))


def test_what_outer_walls_show_is_a_window_within_too_but_for_a_leaf():
    assert not doors(two_rooms(1, windows=1))
    assert len(doors(two_rooms(1, windows=1, arc=True))) == 1
    assert len(doors(two_rooms(1, windows=3))) == 1


@pytest.mark.parametrize('jamb_px', [1, 3])
def test_doorways_in_hatched_walls_are_as_wide_as_their_jambs_lines_say(jamb_px):
    """The leaf hangs in the middle of a jamb's line, which a fifteenth of the doorway may be."""
    free = np.zeros((400, 640), np.bool_)
    free[40:180, 40:600] = free[190:360, 40:600] = True
    row, col = np.indices(free.shape)
    hatched = (row >= 182) & (row < 188) & (col >= 40) & (col < 600)
    left, right = 300, 300 + 29
    line = (col >= left - jamb_px) & (col < right + jamb_px)
    free |= hatched & ((row + col) % 4 != 0) & ~line
    free |= (row >= 182) & (row < 188) & (col >= left) & (col < right)
    middles = np.array([left - 0.5 * (jamb_px + 1), right + 0.5 * (jamb_px - 1)])
    width, turn = np.ptp(middles), np.linspace(0.0, np.pi / 2.0, 40)
    arc = np.stack([middles[0] + width * np.cos(turn), 184.0 - width * np.sin(turn)], axis=1)
    ink = (~free).astype(np.uint8)
    symbol = np.rint(np.concatenate([[(middles[0], 184.0)], arc[::-1]])).astype(np.int32)
    cv2.polylines(ink, [symbol], False, 1)
    cells = np.where(ink > 0, OCCUPIED, FREE).astype(np.int8)
    (portal,) = doors(GridMap(cells, 0.03))
    assert None not in portal.rooms
    assert portal.width_m == pytest.approx(0.03 * width, abs=0.15)


def test_a_line_between_walls_as_thin_is_a_wall():
    assert not doors(two_rooms(1, wall_m=0.05))


def test_letters_across_an_arc_do_not_shut_the_doorway():
    (portal,) = doors(two_rooms(0, arc=True, letters=True))
    assert portal.width_m == pytest.approx(0.9, abs=0.2)


@pytest.mark.parametrize('lines', [1, 2])
def test_storeys_with_sills_keep_their_doors(lines):
    plan = generate_plan(np.random.default_rng(7))
    style = DrawingStyle(walls='thick', doors='leaf', sills=lines)
    grid = render_plan(plan, CELL_M, style=style)
    found = np.array([p.ends.mean(axis=0) for p in doors(grid)]).reshape(-1, 2)
    true = np.array([d.ends.mean(axis=0) for d in plan.doors if not d.is_open])
    assert place_agreement(found, true, 0.6).recall > 0.8
