# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Halls, ways out, plans that their users accept, and files that are no floorplans."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet.plan_check.verdict import Fitness, verdict_of
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.pictures.plausible import findings
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.segmentation import segment_floorplan, told_scale
from fpnet_core.segmentation.ways_out import rooms_with_ways_out
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

CONFIG = FpnetConfig().segmentation
CELL_M = 0.1
WIDE_M, DEEP_M = 40.0, 25.0
ASKED = Invocation(('fpnet', 'check-plan'), 'hall.png')


def hall(offices=2, gate_m=3.0):
    """A hall of 40 x 25 m with offices of 4 x 5 m in a corner, and a gate to the outside."""
    rows, columns = np.mgrid[0:290, 0:440]
    x, y = (columns + 0.5) * CELL_M - 2.0, (rows + 0.5) * CELL_M - 2.0
    cells = np.full(x.shape, UNKNOWN, np.int8)
    small = [(4.0 * k, 0.0, 4.0 * k + 4.0, 5.0) for k in range(offices)]
    rooms = [(0.0, 0.0, WIDE_M, DEEP_M), *small]
    for x0, y0, x1, y1 in rooms:
        for pad, value in ((0.1, OCCUPIED), (-0.1, FREE)):
            is_in = (x > x0 - pad) & (x < x1 + pad) & (y > y0 - pad) & (y < y1 + pad)
            cells[is_in] = value
        cells[(np.abs(x - x0 - 2.0) < 0.5) & (np.abs(y - 5.0) < 0.2) & (y1 == 5.0)] = FREE
    cells[(np.abs(x - 20.0) < gate_m / 2.0) & (np.abs(y - DEEP_M) < 0.2)] = FREE
    return GridMap(cells, CELL_M)


def read(grid, source=ScaleSource.STATED, **changes):
    scale = DrawingScale(grid.resolution, grid.resolution, grid.resolution, source)
    blank = Drawing(np.full((2, 2, 3), 255, np.uint8), 'hall.png', 'png')
    reading = replace(Reading(grid, scale, np.eye(3), 'as drawn', blank), **changes)
    segmentation = segment_floorplan(grid, CONFIG)
    return verdict_of(reading, segmentation, ASKED, told_scale(grid, segmentation, CONFIG))


@pytest.mark.parametrize(
    ('offices', 'gate_m', 'ways'),
    [(2, 3.0, {0}), (0, 1.0, {0}), (2, 0.0, set()), (0, 20.0, set())],
)
def test_a_gate_is_a_way_out_and_a_missing_wall_is_none(offices, gate_m, ways):
    assert rooms_with_ways_out(segment_floorplan(hall(offices, gate_m), CONFIG)) == ways


@pytest.mark.parametrize('offices', [0, 2])
def test_a_hall_with_a_gate_is_fit_where_its_scale_is_stated(offices):
    assert read(hall(offices)).fitness is Fitness.FIT
    estimated = read(hall(offices), ScaleSource.ESTIMATED)
    assert estimated.fitness is Fitness.DOUBTFUL
    assert not estimated.is_usable


def test_the_reader_finds_nothing_odd_in_a_measured_hall():
    for offices, doubts in ((0, 2), (2, 1)):
        rooms = segment_floorplan(hall(offices), CONFIG)
        assert findings(rooms, 1.0) == []
        assert len(findings(rooms)) == doubts


def test_paper_without_a_door_is_no_hall():
    [reason] = read(hall(0, 0.0)).reasons[:1]
    assert reason.what.startswith('it is one room of 9')
    assert reason.places


def test_who_accepts_a_plan_gives_a_reason_that_stays():
    doubts = ('One room takes 97 % of the area.',)
    doubted = read(hall(), doubts=doubts)
    assert not doubted.is_usable
    assert '--accept REASON' in doubted.reasons[0].next
    accepted = read(hall(), doubts=doubts, accepted='it is a hall')
    assert accepted.is_usable
    assert accepted.is_read
    assert list(accepted.lines()) == ['accepted: it is a hall']
    assert accepted.as_json()['accepted'] == 'it is a hall'
    assert accepted.as_json()['fitness'] == 'doubtful'


def test_a_picture_of_something_else_is_no_floorplan():
    said = ('It seems to show something other than a floorplan (probability 0.98).',)
    verdict = read(hall(), doubts=said, is_other=True)
    assert verdict.fitness is Fitness.NO_FLOORPLAN
    assert 'look at' not in verdict.reasons[0].next  # nothing was written
    assert verdict.said_of_file('a.png').startswith('a.png: not a floorplan: It seems to show ')
    assert read(hall(), doubts=said).fitness is Fitness.DOUBTFUL
