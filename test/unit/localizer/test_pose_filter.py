# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The pose follows the walls around the robot, not a placement that odometry has bent."""

from functools import cache

import numpy as np
import pytest

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2, Affine2D, angle_between
from fpnet_core.localizer.pose_filter import LocalPoseFilter
from fpnet_core.pose import map_evidence
from fpnet_core.scoring.deform import deform, patches_of
from fpnet_core.types import FREE, OCCUPIED, GridMap

ANCHOR = LocalPoseFilter(LocalizerConfig())
CELL_M = 0.05
ROBOT = np.array([5.0, 4.0])
TRUTH = Affine2D(np.eye(2), np.zeros(2))


def outline(low, high):
    """Points on the sides of an upright rectangle, every 5 cm."""
    (x0, y0), (x1, y1) = low, high
    xs, ys = np.arange(x0, x1, CELL_M), np.arange(y0, y1, CELL_M)
    sides = [np.stack(np.broadcast_arrays(xs, y), -1) for y in (y0, y1)]
    return np.vstack([*sides, *(np.stack(np.broadcast_arrays(x, ys), -1) for x in (x0, x1))])


ROOM = outline((2.0, 2.0), (9.0, 7.0))
CORRIDOR = outline((-20.0, 2.0), (40.0, 4.0))


@cache
def plan(name):
    return plan_of({'room': ROOM, 'corridor': CORRIDOR}[name])


def plan_of(walls):
    corner = np.array([-25.0, -5.0])
    cells = np.full((400, 1400), FREE, dtype=np.int8)
    col, row = np.floor((walls - corner) / CELL_M).astype(int).T
    cells[row, col] = OCCUPIED
    return map_evidence(GridMap(cells, CELL_M, SE2.from_xy_yaw(*corner, 0.0), 'plan'))


def off_by(x, y, yaw_deg):
    """Return a claim that puts the robot so far from where it is, and turned."""
    turn = SE2.from_xy_yaw(0.0, 0.0, np.deg2rad(yaw_deg))
    return Affine2D(turn.linear, ROBOT - turn.apply(ROBOT) + np.array([x, y]))


def error(A):
    return float(np.hypot(*(A.apply(ROBOT) - ROBOT))), angle_between(A.apply_yaw(0.0), 0.0)


def test_a_claim_that_fits_around_the_robot_stays_as_it_is():
    claim = off_by(0.03, -0.02, 0.2)
    assert ANCHOR.follow(None, plan('room'), ROOM, claim, ROBOT) == (None, claim)


@pytest.mark.parametrize('drift', [(0.4, 0.0, 0.0), (-0.3, 0.3, 4.0), (0.0, 0.0, 8.0)])
def test_walls_around_the_robot_undo_drift(drift):
    fix, claim = None, off_by(*drift)
    for _ in range(4):
        fix, anchored = ANCHOR.follow(fix, plan('room'), ROOM, claim, ROBOT)
    metres, radians = error(anchored)
    assert metres < 0.06
    assert np.rad2deg(radians) < 0.6


def test_drift_is_followed_beyond_the_reach_of_a_single_look():
    """The claim stays behind by two metres in the end; each step alone is small."""
    fix = None
    for metres in np.linspace(0.0, 2.0, 20):
        fix, anchored = ANCHOR.follow(fix, plan('room'), ROOM, off_by(metres, 0.0, 0.0), ROBOT)
    assert error(anchored)[0] < 0.1


def test_along_a_corridor_odometry_decides():
    seen = CORRIDOR[np.abs(CORRIDOR[:, 0] - ROBOT[0]) < 8.0]
    robot, claim = np.array([5.0, 3.0]), Affine2D(np.eye(2), np.array([0.0, 0.35]))
    _, anchored = ANCHOR.follow(None, plan('corridor'), seen, claim, robot)
    x, y = anchored.apply(robot)
    assert abs(x - 5.0) < 0.02
    assert abs(y - 3.0) < 0.1


@pytest.mark.parametrize('off_m', [0.25, 0.5])
def test_the_pose_goes_where_the_judge_bends_the_drawing(off_m):
    """Half of a building is drawn too far to the right."""
    off, far = np.array([off_m, 0.0]), ROOM + np.array([20.0, 0.0])
    seen, drawn = np.vstack([ROOM, far - off]), plan_of(np.vstack([ROOM, far]))
    patches = patches_of(seen, plan_of(seen))
    bent = deform(drawn, drawn.A_rc_xy[None], seen, patches)
    shift_m = bent.shift_cells[0, patches.of_wall] @ np.linalg.inv(drawn.A_rc_xy[:, :2]).T
    upright = np.isclose(seen[:, 0] % 20.0, 2.0) | np.isclose((seen[:, 0] + off_m) % 20.0, 2.0)
    is_far = seen[:, 0] > 15.0
    robot = ROBOT + np.array([20.0, 0.0]) - off
    _, anchored = ANCHOR.follow(None, drawn, seen[is_far], TRUTH, robot)
    np.testing.assert_allclose(shift_m[upright & ~is_far].mean(axis=0), 0.0, atol=0.1)
    np.testing.assert_allclose(shift_m[upright & is_far].mean(axis=0), off, atol=0.15)
    np.testing.assert_allclose(anchored.apply(robot) - robot, off, atol=0.15)


def test_few_returns_say_nothing():
    claim = off_by(0.4, 0.0, 0.0)
    assert ANCHOR.follow(None, plan('room'), ROOM[:20], claim, ROBOT)[1] is claim


@pytest.mark.parametrize('drift', [(0.1, 0.0, 5.0), (-0.1, 0.15, -3.0)])
def test_the_pose_ends_on_the_walls_of_the_last_scans(drift):
    """Wheels that slip in a turn have smeared the metres before it, not what is seen now."""
    metres, radians = error(ANCHOR.at_last(plan('room'), ROOM, off_by(*drift), ROBOT))
    assert metres < 0.05
    assert np.rad2deg(radians) < 0.8
