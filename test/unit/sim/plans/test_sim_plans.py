# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from shapely import Polygon

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.plans import generate_plan


def test_equal_seeds_give_equal_plans():
    first, second = (generate_plan(np.random.default_rng(5)) for _ in range(2))
    assert first.family == second.family
    for a, b in zip(first.rooms, second.rooms, strict=True):
        np.testing.assert_array_equal(a.polygon, b.polygon)
    for a, b in zip(first.doors, second.doors, strict=True):
        np.testing.assert_array_equal(a.ends, b.ends)


@pytest.mark.parametrize(
    ('family', 'seed', 'rooms', 'doors', 'floor_m2'),
    [
        ('racetrack', 6, 51, 54, 1222.738),
        ('ring_polygon', 0, 65, 66, 1899.818),
        ('ring_polygon', 5, 74, 104, 1875.979),
        ('ring_polygon', 7, 61, 112, 1391.899),
    ],
)
def test_equal_seeds_give_equal_plans_on_every_processor(family, seed, rooms, doors, floor_m2):
    # These came out differently where NumPy takes sines and exponentials from AVX-512.
    plan = generate_plan(np.random.default_rng(seed), family)
    assert (len(plan.rooms), len(plan.doors)) == (rooms, doors)
    assert plan.floor_area_m2 == pytest.approx(floor_m2, abs=0.001)


def test_room_bounds_are_kept():
    for seed in range(4):
        plan = generate_plan(np.random.default_rng(seed), min_rooms=20, max_rooms=40)
        assert 20 <= len(plan.rooms) <= 40


def test_unknown_family_is_refused():
    with pytest.raises(ConfigError, match='unknown family'):
        generate_plan(np.random.default_rng(0), 'castle')


def test_rooms_have_real_sizes():
    """Medians of 20 real floorplans: 21 m^2 per room, doors of 0.95 m."""
    plans = [generate_plan(np.random.default_rng([3, seed])) for seed in range(25)]
    areas = [Polygon(r.polygon).area for p in plans for r in p.rooms if r.kind == 'room']
    widths = [d.width_m for p in plans for d in p.doors if not d.is_open]
    assert 15.0 < np.median(areas) < 27.0
    assert 0.85 < np.median(widths) < 1.05


@pytest.mark.parametrize(
    ('bounds', 'reason'),
    [
        ({'min_rooms': 50, 'max_area_m2': 100.0}, '50 rooms do not fit into 100 m²'),
        ({'min_rooms': 30, 'max_rooms': 10}, 'exceeds max_rooms 10'),
        ({'min_rooms': 20, 'max_area_m2': 62.0}, 'widen the bounds'),
    ],
)
def test_more_rooms_than_area_is_refused(bounds, reason):
    with pytest.raises(ConfigError, match=reason):
        generate_plan(np.random.default_rng(0), 'bays', **bounds)
