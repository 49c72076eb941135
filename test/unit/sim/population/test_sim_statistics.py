# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is measured of storeys, and how two populations are compared."""

import cv2
import numpy as np
import pytest

from fpnet_core.errors import MapFormatError
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.population.comparison import compare, percentile_errors, two_sample
from fpnet_lab.sim.population.floors import CELL_M, LabelledFloor, floor_of_plan, read_floors
from fpnet_lab.sim.population.statistics import FEATURES, FloorMeasures, measure_floor
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom


def _box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


@pytest.fixture
def three_rooms():
    """Rooms 0 and 1 are two pieces of one corridor; room 2 has two doors to it."""
    rooms = (
        PlanRoom(_box(0.0, 0.0, 5.0, 2.0), 'corridor'),
        PlanRoom(_box(5.2, 0.0, 10.2, 2.0), 'corridor'),
        PlanRoom(_box(0.0, 2.2, 10.2, 6.2)),
    )
    doors = (
        PlanDoor((0, 1), np.array([[5.1, 0.0], [5.1, 2.0]]), is_open=True),
        PlanDoor((0, 2), np.array([[1.0, 2.1], [1.9, 2.1]])),
        PlanDoor((1, 2), np.array([[7.0, 2.1], [8.5, 2.1]])),
    )
    return BuildingPlan(rooms, doors, 0.2, 'test')


def test_pieces_of_one_corridor_are_one_room(three_rooms):
    found = measure_floor(floor_of_plan(three_rooms, 'test'))
    doorways = 0.2 / 2.0 * (0.9 + 1.5)
    assert sorted(found.areas_m2) == pytest.approx([20.4 + doorways, 40.8 + doorways], rel=0.02)
    assert sorted(found.aspects) == pytest.approx([10.2 / 4.1, 10.2 / 2.1], rel=0.03)
    assert sorted(found.door_widths_m) == pytest.approx([0.9, 1.5], abs=CELL_M)
    assert found.doors_per_room.tolist() == [2, 2]
    assert (found.hub_degree, found.cycles, found.components) == (2, 1, 1)
    assert found.regions.shape == (2, len(FEATURES))


def test_where_a_person_ends_a_label_in_a_doorway_changes_nothing(three_rooms):
    floor = floor_of_plan(three_rooms, 'test')
    moved = floor.labels.copy()
    into = cv2.dilate((floor.labels == 2).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    moved[into & floor.free & (moved == 0)] = 2
    first, second = (
        measure_floor(LabelledFloor('f', m, floor.free)) for m in (floor.labels, moved)
    )
    np.testing.assert_allclose(first.areas_m2, second.areas_m2, rtol=0.01)
    np.testing.assert_allclose(first.door_widths_m, second.door_widths_m, atol=1e-6)


def test_a_turned_door_keeps_its_width(three_rooms):
    c, s = np.cos(0.5), np.sin(0.5)
    turn = np.array([[c, s], [-s, c]])
    rooms = tuple(PlanRoom(room.polygon @ turn, room.kind) for room in three_rooms.rooms)
    doors = tuple(PlanDoor(d.rooms, d.ends @ turn, d.is_open) for d in three_rooms.doors)
    found = measure_floor(floor_of_plan(BuildingPlan(rooms, doors, 0.2, 'test'), 'test'))
    assert sorted(found.door_widths_m) == pytest.approx([0.9, 1.5], abs=2 * CELL_M)
    assert sorted(found.aspects) == pytest.approx([10.2 / 4.1, 10.2 / 2.1], rel=0.05)


def _measures(name, rng, scale):
    areas = scale * rng.uniform(10.0, 30.0, 20)
    regions = np.column_stack([np.log(areas), rng.normal(size=(20, len(FEATURES) - 1))])
    ones = np.ones(20)
    return FloorMeasures(name, regions, areas, ones, ones, np.ones(20, int), ones, 3, 1, 1)


@pytest.mark.parametrize(('scale', 'low', 'high'), [(1.0, 0.3, 0.65), (2.5, 0.85, 1.0)])
def test_the_classifier_sees_a_difference_where_there_is_one(scale, low, high):
    rng = np.random.default_rng(0)
    generated = [_measures(f'g{i}', rng, scale) for i in range(15)]
    real = [_measures(f'r{i}', rng, 1.0) for i in range(10)]
    told = two_sample(generated, real, repeats=1)
    assert low <= told.auc <= high
    if scale > 1.0:
        assert max(told.importance, key=told.importance.get) == 'log_area'


def test_percentile_errors_are_relative_to_the_real_side():
    rng = np.random.default_rng(0)
    real = [_measures('r', rng, 1.0)]
    generated = [_measures('g', np.random.default_rng(0), 1.2)]
    errors = percentile_errors(compare(generated, real))
    assert errors['room_area_m2_p50'] == pytest.approx(0.2)
    assert errors['door_width_m_p95'] == 0.0
    assert len(errors) == 15


def test_generated_rooms_and_doors_keep_real_sizes():
    """Wide bands: a few storeys only; the command's table is the real comparison."""
    found = [
        measure_floor(floor_of_plan(generate_plan(np.random.default_rng([5, i])), str(i)))
        for i in range(8)
    ]
    areas = np.concatenate([floor.areas_m2 for floor in found])
    widths = np.concatenate([floor.door_widths_m for floor in found])
    assert 14.0 < np.median(areas) < 28.0
    assert 3.0 < np.percentile(areas, 5) < 9.0
    assert 0.85 <= np.median(widths) <= 1.05


def test_missing_and_unequal_images_are_named(tmp_path):
    with pytest.raises(MapFormatError, match='missing'):
        read_floors(tmp_path, ['a'])
    for kind, size in (('floorplan', 20), ('room_labels', 30)):
        (tmp_path / kind).mkdir()
        cv2.imwrite(str(tmp_path / kind / 'a.png'), np.full((size, size), 255, np.uint8))
    with pytest.raises(MapFormatError, match='one size'):
        read_floors(tmp_path, ['a'])
