# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is measured of storeys, and how two populations are compared."""

import cv2
import numpy as np
import pytest

from fpnet_core.errors import MapFormatError
from fpnet_lab.sim.population.comparison import two_sample
from fpnet_lab.sim.population.floors import CELL_M, floor_of_plan, read_floors
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


def test_missing_and_unequal_images_are_named(tmp_path):
    with pytest.raises(MapFormatError, match='missing'):
        read_floors(tmp_path, ['a'])
    for kind, size in (('floorplan', 20), ('room_labels', 30)):
        (tmp_path / kind).mkdir()
        cv2.imwrite(str(tmp_path / kind / 'a.png'), np.full((size, size), 255, np.uint8))
    with pytest.raises(MapFormatError, match='one size'):
        read_floors(tmp_path, ['a'])
