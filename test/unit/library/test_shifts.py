# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What was seen is laid on a plan by its walls alone, at the best of all shifts."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet.library.shifts import Shifts
from fpnet.library.walls import direction_of
from fpnet_core.geometry import SE2
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

CELL_M = 0.25


def storey(seed=3):
    """Rooms of random widths on both sides of a corridor, 40 m long."""
    rng = np.random.default_rng(seed)
    cells = np.full((60, 160), OCCUPIED, np.int8)
    cells[27:33] = FREE
    for rows in (slice(1, 26), slice(34, 59)):
        walls = np.cumsum(rng.integers(10, 30, 12))
        cells[rows] = FREE
        cells[rows, walls[walls < 160]] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    return GridMap(cells, CELL_M, SE2.from_xy_yaw(-20.0, -8.0, 0.0))


@pytest.fixture(scope='module')
def plan():
    return storey()


def seen_of(plan, placed, scale=1.0):
    """Return two thirds of a plan as of a robot that stands at ``placed``, in larger metres."""
    part = plan.cropped(slice(0, 60), slice(40, 150))
    frame = placed.inv() @ part.T_frame_grid
    moved = SE2(frame.linear, frame.translation / scale)
    return replace(part, resolution=CELL_M / scale, T_frame_grid=moved)


def off(found, index, seen, placed, scale=1.0):
    """Return how far off the cells of what was seen are at most [m]."""
    xy = seen.rc_to_xy(np.argwhere(seen.cells != UNKNOWN))
    true = placed.apply(xy * scale)
    moved = xy @ found.linear[index].T + found.translation[index]
    return float(np.hypot(*(moved - true).T).max())


@pytest.mark.parametrize('yaw', [0.0, 0.4, 1.9, np.pi, 4.0])
def test_walls_lie_on_walls_however_what_was_seen_is_turned(plan, yaw):
    placed = SE2.from_xy_yaw(7.0, -3.0, yaw)
    seen = seen_of(plan, placed)
    found = Shifts(seen, direction_of(seen), [1.0]).best(plan, direction_of(plan))
    assert found.score[0] > 0.5
    assert off(found, 0, seen, placed) < 1.5


def test_the_right_scale_fits_best(plan):
    placed = SE2.from_xy_yaw(-5.0, 2.0, 2.5)
    seen = seen_of(plan, placed, 1.3)
    factors = [0.8, 1.0, 1.3, 1.6]
    found = Shifts(seen, direction_of(seen), factors).best(plan, direction_of(plan))
    assert int(found.score.argmax()) == 2
    assert off(found, 2, seen, placed, 1.3) < 1.5
