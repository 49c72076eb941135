# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where to look next, in a corridor of which the robot has seen the middle."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.localizer.guidance import next_look
from fpnet_core.pose import map_evidence
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, LocalizerOutput, Status, Submap

CELL_M, LONG_M, WIDE_M, SEEN_M = 0.1, 24.0, 3.0, 6.0


def corridor(low_m, high_m, has_ends):
    """Return a corridor along x from ``low_m`` to ``high_m``, its axis y = 0."""
    rows, cols = round(WIDE_M / CELL_M) + 6, round((high_m - low_m) / CELL_M) + 6
    cells = np.full((rows, cols), OCCUPIED if has_ends else UNKNOWN, np.int8)
    cells[3:-3, 3:-3] = FREE
    cells[[2, -3], 3:-3] = OCCUPIED
    corner = SE2.from_xy_yaw(low_m - 3 * CELL_M, -0.5 * WIDE_M - 3 * CELL_M, 0.0)
    return GridMap(cells, CELL_M, corner, 'map')


@pytest.fixture(scope='module')
def plan():
    return map_evidence(corridor(0.0, LONG_M, True))


def output(*places, p, status=Status.AMBIGUOUS):
    """Return that of a robot in the middle of what it saw, on these places of the plan."""
    seen = corridor(-SEEN_M, SEEN_M, False)
    submap = Submap(seen, np.zeros(seen.shape, np.bool_), np.zeros((1, 2)))
    placed = Placements.of([SE2.from_xy_yaw(*place) for place in places])
    is_placed = status is Status.LOCALIZED
    return LocalizerOutput(
        0,
        status,
        Affine2D.identity() if is_placed else None,
        estimates=replace(placed, probability=np.array(p)),
        submap=submap,
    )


def robot(yaw_deg=0.0):
    return SE2.from_xy_yaw(0.0, 0.0, np.deg2rad(yaw_deg)).as_matrix4()


@pytest.mark.parametrize(('rival_x', 'sign'), [(LONG_M - 7.0, 1.0), (7.0, -1.0)])
def test_it_leads_to_the_end_that_only_one_place_has_near(plan, rival_x, sign):
    found = next_look(plan, output((12.0, 0.0, 0.0), (rival_x, 0.0, 0.0), p=[0.5, 0.5]), robot())
    assert sign * found.way_odom[-1, 0] > 1.0
    np.testing.assert_allclose(found.way_odom[0], 0.0, atol=0.3)
    assert found.way_m == pytest.approx(abs(found.way_odom[-1, 0]), abs=1.0)
    assert found.gain_nats == pytest.approx(np.log(2.0), rel=0.2)
    assert found.words.endswith('walls there separate 2 hypotheses')


@pytest.mark.parametrize(
    ('yaw_deg', 'where'),
    [(0.0, 'ahead'), (180.0, 'behind'), (90.0, 'on the right'), (-45.0, 'ahead on the left')],
)
def test_it_is_said_as_the_robot_stands(plan, yaw_deg, where):
    seen = output((12.0, 0.0, 0.0), (LONG_M - 7.0, 0.0, 0.0), p=[0.5, 0.5])
    assert f' m {where}: walls' in next_look(plan, seen, robot(yaw_deg)).words


@pytest.mark.parametrize('p', [0.5, 0.49])
def test_of_equal_halves_no_look_tells_anything(plan, p):
    halves = output((12.0, 0.0, 0.0), (12.0, 0.0, np.pi), p=[p, p])
    assert next_look(plan, halves, robot()) is None


def test_one_place_is_made_sure_by_more_of_what_the_plan_shows(plan):
    found = next_look(plan, output((8.0, 0.0, 0.0), p=[0.6]), robot())
    assert abs(found.way_odom[-1, 0]) > 1.0
    assert found.gain_nats > 0.1
    assert found.words.endswith('unobserved parts of the plan are visible there')


def test_nothing_is_said_where_a_claim_stands_or_nothing_was_found(plan):
    claimed = output((12.0, 0.0, 0.0), p=[1.0], status=Status.LOCALIZED)
    assert next_look(plan, claimed, robot()) is None
    assert next_look(plan, output(p=[]), robot()) is None
    waiting = LocalizerOutput(0, Status.WAITING)
    assert next_look(plan, waiting, robot()) is None


def test_nothing_is_said_where_there_is_no_way(plan):
    seen = output((12.0, 0.0, 0.0), (LONG_M - 7.0, 0.0, 0.0), p=[0.5, 0.5])
    walled = replace(seen.submap.grid, cells=np.full(seen.submap.grid.shape, OCCUPIED, np.int8))
    nowhere = replace(seen, submap=replace(seen.submap, grid=walled))
    far = SE2.from_xy_yaw(500.0, 0.0, 0.0).as_matrix4()
    assert next_look(plan, nowhere, robot()) is None
    assert next_look(plan, seen, far) is None


def test_a_mirrored_plan_is_to_be_flipped_first(plan):
    seen = output((12.0, 0.0, 0.0), (LONG_M - 7.0, 0.0, 0.0), p=[0.5, 0.5])
    assert next_look(plan, replace(seen, is_mirrored=True), robot()) is None


def test_where_it_has_been_it_is_not_sent_again(plan):
    seen = output((12.0, 0.0, 0.0), (LONG_M - 7.0, 0.0, 0.0), p=[0.5, 0.5])
    first = next_look(plan, seen, robot())
    been = replace(seen, submap=replace(seen.submap, path_xy=first.way_odom))
    again = next_look(plan, been, robot())
    away = np.linalg.norm(first.way_odom[-1] - again.way_odom[-1])
    assert away > 1.0
