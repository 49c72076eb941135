# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Self-similar rooms of small made-up storeys, and what is said about a plan."""

import numpy as np
from planted import plan_grid
import pytest

from fpnet.plan_check import check as plan_check
from fpnet.plan_check.check import TourResult, check_plan, room_note
from fpnet.plan_check.self_similarity import SelfSimilarity, self_similarity
from fpnet.plan_check.verdict import Fitness, verdict_of
from fpnet_core.config import load_config
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.errors import ConfigError
from fpnet_core.localizer import create_global_localizer, prepare_plan
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.moved import rescaled, rescaled_rooms
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.evaluation.plan_tours import drive_tour

CONFIG = load_config(None, {})
ASKED = Invocation(('fpnet', 'check-plan'), 'plan.png')
CELL_M = 0.05
# x0, y0, x1, y1 [m]: a corridor; three equal rooms above it; below one that differs.
CORRIDOR = (0, 4, 15, 6)
EQUAL = ((0, 6, 5, 12), (5, 6, 10, 12), (10, 6, 15, 12))
ODD = ((0, 0, 9, 4),)
DOORS = ((1, 6), (6, 6), (11, 6), (4, 4))


def storey(rooms, doors):
    """A drawing with walls of 20 cm around the rooms and doors of 1 m in them."""
    rows, columns = np.mgrid[0:320, 0:360]
    x, y = (columns + 0.5) * CELL_M - 1.0, (rows + 0.5) * CELL_M - 1.0
    cells = np.full(x.shape, -1, np.int8)
    for pad, value in ((0.1, OCCUPIED), (-0.1, FREE)):
        for x0, y0, x1, y1 in rooms:
            inside = (x > x0 - pad) & (x < x1 + pad) & (y > y0 - pad) & (y < y1 + pad)
            cells[inside] = value
    for door_x, door_y in doors:
        cells[(np.abs(x - door_x - 0.5) < 0.5) & (np.abs(y - door_y) <= 0.15)] = FREE
    return GridMap(cells, CELL_M)


def room_at(segmentation, xy):
    row, column = np.rint(segmentation.grid.xy_to_rc(xy)).astype(int)
    return int(segmentation.labels[row, column]) - 1


@pytest.fixture(scope='module')
def repeated():
    plan = prepare_plan(storey((CORRIDOR, *EQUAL, *ODD), DOORS), CONFIG)
    return plan, self_similarity(plan, create_global_localizer(CONFIG))


def test_equal_rooms_are_twins_of_each_other(repeated):
    plan, similarity = repeated
    segmentation = plan.segmentation
    equal = {room_at(segmentation, ((x0 + x1) / 2, (y0 + y1) / 2)) for x0, y0, x1, y1 in EQUAL}
    odd = room_at(segmentation, (5.0, 2.0))
    assert len(equal) == 3
    for room in equal:
        unturned = {twin.other for twin in similarity.alone[room] if abs(twin.turn_deg) < 5.0}
        assert unturned == equal - {room}
        for twin in similarity.alone[room]:
            assert 0.05 < twin.probability < 0.95
    assert not any(twin.other in equal for twin in similarity.alone.get(odd, ()))


def test_the_corridor_tells_equal_rooms_apart(repeated):
    """Where a room's door meets the corridor is seen from the room with its neighbour."""
    plan, similarity = repeated
    assert similarity.whole == ()
    corridor = room_at(plan.segmentation, (7.0, 5.0))
    assert corridor not in similarity.with_neighbours
    assert similarity.with_neighbours == {}


def test_a_storey_of_two_equal_halves_lies_on_itself():
    rooms = ((0, 4, 12, 6), (0, 6, 6, 12), (6, 6, 12, 12), (0, -2, 6, 4), (6, -2, 12, 4))
    doors = ((1, 6), (7, 6), (4, 4), (10, 4))
    plan = prepare_plan(storey([np.add(r, (1, 2, 1, 2)) for r in rooms],
                               [np.add(d, (1, 2)) for d in doors]), CONFIG)  # fmt: skip
    similarity = self_similarity(plan, create_global_localizer(CONFIG))
    assert [abs(round(twin.turn_deg)) for twin in similarity.whole] == [180]
    assert len(similarity.with_neighbours) == 5


def test_a_storey_of_unlike_rooms_is_clear_from_a_room_with_its_neighbours():
    similarity = self_similarity(
        prepare_plan(plan_grid(), CONFIG), create_global_localizer(CONFIG)
    )
    assert similarity.with_neighbours == {}
    assert similarity.whole == ()


@pytest.mark.slow
def test_a_simulated_drive_ends_with_a_right_claim():
    tour = drive_tour(reading_of(plan_grid()), CONFIG, 0)
    assert tour.found_after_m is not None
    assert 0.0 <= tour.found_after_m < tour.path_m
    assert tour.error_m < 0.5
    assert not tour.is_wrong


def stated(metres):
    return DrawingScale(metres, metres, metres, ScaleSource.STATED)


def reading_of(grid, scale=None, doubts=()):
    blank = Drawing(np.full((2, 2, 3), 255, np.uint8), 'plan.png', 'png')
    scale = scale or stated(grid.resolution)
    return Reading(grid, scale, np.eye(3), 'dark walls on light paper', blank, doubts=doubts)


def checked(monkeypatch, tour, seeds, **options):
    monkeypatch.setattr(plan_check, 'self_similarity', lambda *_: SelfSimilarity({}, {}, ()))
    return check_plan(reading_of(plan_grid()), CONFIG, seeds, tour, **options)


def test_a_good_plan_is_said_to_be_found_soon(monkeypatch):
    paths = {4: 6.0, 5: 8.0, 6: 30.0}
    check = checked(
        monkeypatch,
        lambda _reading, _config, seed: TourResult(seed, 40.0, paths[seed], 0.1),
        range(4, 7),
    )
    assert [tour.seed for tour in check.tours] == [4, 5, 6]
    assert (
        'In 3 of 3 simulated drives the robot was localized, typically after 8 m.' in check.advice
    )
    plain = check.as_json()
    assert plain['expected_path_m'] == 8.0
    assert plain['rooms'] == 7
    assert room_note(check, 0) == ''


def test_a_plan_that_allows_no_drive_has_advice(monkeypatch):
    def no_tour(*_):
        raise ConfigError('no room can be left')

    steps = []
    check = checked(monkeypatch, no_tour, range(2), on_step=steps.append)
    assert len(steps) == 3
    assert check.tours == ()
    assert any('no room can be left' in line for line in check.advice)
    assert check.as_json()['expected_path_m'] is None


@pytest.mark.parametrize(
    ('factor', 'word'), [(0.1, 'median room has 0.'), (8.0, 'door is 7'), (1.0, '')]
)
def test_a_scale_of_no_building_speaks_against_a_plan(factor, word):
    grid = rescaled(plan_grid(), factor)
    found = verdict_of(
        reading_of(grid), segment_floorplan(plan_grid(), CONFIG.segmentation), ASKED
    )
    assert found.fitness is Fitness.FIT
    segmentation = rescaled_rooms(segment_floorplan(plan_grid(), CONFIG.segmentation), factor)
    found = verdict_of(reading_of(grid), segmentation, ASKED)
    assert found.is_read
    assert word in ' '.join(reason.what for reason in found.reasons)
    assert found.is_usable != bool(word)


def test_only_a_scale_that_nobody_can_search_is_refused():
    segmentation = segment_floorplan(plan_grid(), CONFIG.segmentation)
    for high_m, count in ((0.085, 0), (0.095, 1)):
        guess = DrawingScale(0.05, 0.04, high_m, ScaleSource.ESTIMATED)
        found = verdict_of(reading_of(plan_grid(), guess), segmentation, ASKED).reasons
        assert len(found) == count
    assert found[0].next == (
        'measure one length: fpnet check-plan plan.png --length X1,Y1,X2,Y2=METRES'
    )


def test_doubts_of_the_reader_are_reasons_and_nothing_else_is_said(monkeypatch):
    monkeypatch.setattr(plan_check, 'self_similarity', lambda *_: pytest.fail('looked further'))
    doubted = reading_of(plan_grid(), doubts=('No door was found.',))
    drive = lambda *_: pytest.fail('drove')  # noqa: E731
    check = check_plan(doubted, CONFIG, range(2), drive)
    assert [reason.what for reason in check.verdict.reasons] == ['No door was found']
    assert check.advice == check.tours == ()
    assert not check.is_readable


@pytest.mark.parametrize(
    ('rooms', 'doors', 'word'),
    [((CORRIDOR, *EQUAL), (), 'rooms and no door'), (((0, 0, 30, 18),), (), '')],
)
def test_what_no_building_is_like_is_refused(rooms, doors, word):
    segmentation = segment_floorplan(storey(rooms, doors), CONFIG.segmentation)
    found = verdict_of(reading_of(storey(rooms, doors)), segmentation, ASKED)
    assert found.is_usable != bool(word)
    assert word in ' '.join(reason.what for reason in found.reasons)
