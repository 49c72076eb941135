# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
import shapely
from shapely import Polygon

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.layout import Cell, absorb_slivers, cut_holes, unite
from fpnet_lab.sim.plans.skeleton import Arm


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


def test_another_seed_gives_another_plan():
    first, second = (generate_plan(np.random.default_rng(seed), 'racetrack') for seed in (5, 6))
    assert not np.allclose(first.extent, second.extent)


def test_room_bounds_are_kept():
    for seed in range(4):
        plan = generate_plan(np.random.default_rng(seed), min_rooms=20, max_rooms=40)
        assert 20 <= len(plan.rooms) <= 40


def test_unknown_family_is_refused():
    with pytest.raises(ConfigError, match='unknown family'):
        generate_plan(np.random.default_rng(0), 'castle')


def test_unreachable_bounds_are_refused():
    with pytest.raises(ConfigError, match='widen the bounds'):
        generate_plan(np.random.default_rng(0), 'house', min_rooms=500, max_rooms=900)


def test_rooms_have_real_sizes():
    """Medians of 20 real floorplans: 21 m^2 per room, doors of 0.95 m."""
    plans = [generate_plan(np.random.default_rng([3, seed])) for seed in range(25)]
    areas = [Polygon(r.polygon).area for p in plans for r in p.rooms if r.kind == 'room']
    widths = [d.width_m for p in plans for d in p.doors if not d.is_open]
    assert 15.0 < np.median(areas) < 27.0
    assert 0.85 < np.median(widths) < 1.05


def test_mirrored_wings_are_mirror_images():
    plan = generate_plan(np.random.default_rng(2), 'mirrored')
    half = len(plan.rooms) // 2
    for room, image in zip(plan.rooms[:half], plan.rooms[half:], strict=True):
        flipped = Polygon(image.polygon * (-1.0, 1.0))
        assert flipped.symmetric_difference(Polygon(room.polygon)).area < 1e-6


def test_an_arm_maps_to_the_building_and_back():
    arm = Arm((3.0, -2.0), (3.0 + 8.0 * np.cos(0.6), -2.0 + 8.0 * np.sin(0.6)), 2.0, 5.0, 4.0)
    box = shapely.box(1.0, 1.0, 4.0, 6.0)
    world = arm.to_world(box)
    corner = shapely.get_coordinates(world)
    expected = (3.0 + 4.0 * np.cos(0.6) - np.sin(0.6), -2.0 + 4.0 * np.sin(0.6) + np.cos(0.6))
    assert np.abs(corner - expected).sum(axis=1).min() < 1e-9
    assert arm.to_local(world).symmetric_difference(box).area < 1e-9


def test_slivers_join_the_neighbour_with_the_longest_wall():
    sliver = Cell(shapely.box(0.0, 0.0, 0.8, 4.0))
    beside, below = Cell(shapely.box(0.8, 0.0, 5.0, 4.0)), Cell(shapely.box(0.0, -4.0, 5.0, 0.0))
    cells = absorb_slivers([sliver, beside, below])
    assert len(cells) == 2
    assert max(cell.polygon.area for cell in cells) == pytest.approx(20.0, abs=0.01)
    assert cells[0].polygon.bounds == pytest.approx((0.0, 0.0, 5.0, 4.0), abs=0.01)


def test_rings_are_cut_until_no_piece_has_a_hole():
    ring = shapely.box(0.0, 0.0, 20.0, 10.0).difference(shapely.box(2.0, 2.0, 18.0, 8.0))
    pieces = cut_holes(ring)
    assert len(pieces) == 2
    assert not any(piece.interiors for piece in pieces)
    assert sum(piece.area for piece in pieces) == pytest.approx(ring.area)


def test_cells_that_do_not_touch_are_not_united():
    assert unite(shapely.box(0, 0, 1, 1), shapely.box(1.5, 0, 3, 1)) is None


def test_the_room_graph_has_the_plans_rooms_and_doors():
    plan = generate_plan(np.random.default_rng(8), 'suites')
    graph = plan.room_graph()
    assert list(graph) == list(range(len(plan.rooms)))
    assert graph.number_of_edges() == len(plan.doors)
    for a, b, k, width in graph.edges(keys=True, data='width_m'):
        assert {a, b} == set(plan.doors[k].rooms)
        assert width == plan.doors[k].width_m
    area = Polygon(plan.rooms[3].polygon).area
    assert graph.nodes[3] == {'kind': plan.rooms[3].kind, 'area_m2': pytest.approx(area)}


def test_leaves_hang_at_both_ends_and_mostly_open_into_the_smaller_room():
    plan = generate_plan(np.random.default_rng(8), 'racetrack')
    doors = [door for door in plan.doors if not door.is_open]
    areas = [Polygon(room.polygon).area for room in plan.rooms]
    smaller = [areas[d.rooms[d.swing]] <= areas[d.rooms[1 - d.swing]] for d in doors]
    assert np.mean(smaller) > 0.75
    assert {door.hinge for door in doors} == {0, 1}


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


def test_the_floor_area_is_bounded():
    plan = generate_plan(np.random.default_rng(1), min_rooms=5, max_area_m2=300.0)
    assert plan.floor_area_m2 <= 300.0
    assert plan.floor_area_m2 == pytest.approx(sum(Polygon(r.polygon).area for r in plan.rooms))
