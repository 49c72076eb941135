# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generated, given and traced storeys, and how like real ones they are."""

from functools import cache

import cv2
import networkx as nx
import numpy as np
import pytest
import shapely
from shapely import Polygon
from typer.testing import CliRunner

from fpnet_core.errors import ConfigError, FpnetError, MapFormatError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, RegionLabel
from fpnet_lab.cli.simulate import app
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.buildings.openings import opening_polygon, walkable_area
from fpnet_lab.sim.config import BuildingConfig, SimConfig
from fpnet_lab.sim.drawn.distort import warp_map
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.pairs.dataset import PairDataset, read_manifest
from fpnet_lab.sim.pairs.pair import generate_mapped_pair, generate_pair
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes
from fpnet_lab.sim.pairs.presets import PRESETS, in_split, preset
from fpnet_lab.sim.pairs.scan2d import EMPTY
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.sources import GivenPlans
from fpnet_lab.sim.plans.special import SPECIAL, generate_special_plan, special_plan
from fpnet_lab.sim.plans.traced import plan_from_grid
from fpnet_lab.sim.population.comparison import two_sample
from fpnet_lab.sim.population.floors import CELL_M, floor_of_plan, read_floors
from fpnet_lab.sim.population.statistics import FEATURES, FloorMeasures, measure_floor
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom


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


@cache
def _plans(family):
    return [generate_plan(np.random.default_rng([seed, 3]), family) for seed in range(3)]


def _rooms(plan, *kinds):
    return [Polygon(r.polygon) for r in plan.rooms if r.kind in kinds]


@pytest.mark.parametrize(
    ('family', 'image'), [('mirrored', (-1.0, 1.0)), ('turned', (-1.0, -1.0))]
)
def test_symmetric_wings_fall_on_each_other(family, image):
    for plan in _plans(family):
        floor = shapely.union_all([Polygon(room.polygon) for room in plan.rooms])
        moved = shapely.union_all([Polygon(room.polygon * image) for room in plan.rooms])
        assert floor.symmetric_difference(moved).area < 1e-6 * floor.area


def test_disconnected_wings_share_no_door():
    for plan in _plans('disconnected'):
        assert nx.number_connected_components(plan.room_graph()) == 2


def test_homes_are_small_with_narrow_doors_around_one_hall():
    for plan in _plans('home'):
        rooms = _rooms(plan, 'room')
        assert plan.floor_area_m2 < 200.0
        assert np.median([room.area for room in rooms]) < 20.0
        assert max(door.width_m for door in plan.doors if not door.is_open) < 0.91
        assert len(_rooms(plan, 'hall')) == 1


@pytest.mark.parametrize('name', list(SPECIAL))
def test_rooms_of_a_special_building_are_apart_and_can_be_reached(name):
    for seed in range(3):
        plan = special_plan(np.random.default_rng(seed), name)
        overlap = shapely.area(plan.outlines).sum() - shapely.union_all(plan.outlines).area
        assert overlap < 0.05
        if name != 'terraced':  # whose dwellings are joined by nothing
            assert nx.is_connected(nx.Graph(plan.room_graph()))


def test_a_door_to_the_outside_lies_in_an_outer_wall():
    seen = 0
    for seed in range(20):
        plan = generate_special_plan(np.random.default_rng(seed))
        for door in plan.doors:
            if door.is_outside:
                beyond = door.ends.mean(axis=0) + (plan.wall_m + 0.5) * door.normal
                within = door.ends.mean(axis=0) - plan.wall_m * door.normal
                assert not shapely.contains_xy(plan.outlines, *beyond).any()
                assert shapely.contains_xy(plan.outlines[door.rooms[0]], *within)
                seen += 1
    assert seen > 8


def ious(expected, got):
    """Best intersection over union of each expected polygon with one of the others."""
    best = []
    for polygon in expected:
        shared = shapely.area(shapely.intersection(polygon, got))
        best.append(float((shared / (polygon.area + shapely.area(got) - shared)).max()))
    return np.array(best)


@pytest.fixture(scope='module', params=['double_corridor', 'suites', 'ring_polygon'])
def drawn_and_traced(request):
    plan = generate_plan(np.random.default_rng(6), request.param, min_rooms=13)
    return plan, plan_from_grid(render_plan(plan, 0.05))


def test_rooms_are_where_they_were_drawn(drawn_and_traced):
    drawn, traced = drawn_and_traced
    rooms = [o for o, r in zip(drawn.outlines, drawn.rooms, strict=True) if r.kind == 'room']
    agreement = ious(rooms, traced.outlines)
    assert np.mean(agreement > 0.8) > 0.85
    assert np.median(agreement) > 0.93
    total = shapely.union_all(drawn.outlines).area
    assert shapely.union_all(traced.outlines).area == pytest.approx(total, rel=0.04)
    assert traced.wall_m == pytest.approx(drawn.wall_m, abs=0.06)


def test_doors_join_two_rooms_through_the_wall(drawn_and_traced):
    drawn, traced = drawn_and_traced
    outlines = traced.outlines
    for door in traced.doors:
        a, b = door.rooms
        assert a != b
        opening = opening_polygon(traced, door)
        assert opening.intersects(outlines[a])
        assert opening.intersects(outlines[b])
    middles = shapely.points([d.ends.mean(axis=0) for d in traced.doors])
    real = [d.ends.mean(axis=0) for d in drawn.doors if not d.is_open]
    near = shapely.distance(shapely.points(real)[:, None], middles[None]).min(axis=1) < 0.3
    assert near.mean() > 0.85


def test_a_traced_plan_does_all_that_a_generated_one_does():
    drawn = generate_plan(np.random.default_rng(6), 'double_corridor', min_rooms=13)
    traced = plan_from_grid(render_plan(drawn, 0.05))
    rng = np.random.default_rng(1)
    building = extrude(traced, rng)
    assert len(building.walls.triangles) > 100
    assert len(building.furniture) > 5
    world = build_world(traced, draw_changes(traced, rng, BuildingConfig(furnished=0.0)), 0.5)
    area = np.count_nonzero((world.room_of >= 0) & (world.body == EMPTY)) * 0.05**2
    assert area == pytest.approx(sum(o.area for o in traced.outlines), rel=0.1)
    tour = plan_tour(traced, rng, TourLimits(rooms=3, shortest_s=10.0, longest_s=200.0))
    assert walkable_area(traced).covers(tour.line())


@pytest.mark.parametrize('value', [FREE, OCCUPIED])
def test_a_drawing_without_rooms_is_refused(value):
    with pytest.raises(MapFormatError, match='no rooms'):
        plan_from_grid(GridMap(np.full((80, 90), value), 0.05))


SMALL = SimConfig(pairs_per_plan=2, pairs_per_drawing=2)


def _house(seed):
    return render_plan(generate_plan(np.random.default_rng(seed), 'house'), 0.05)


@pytest.fixture(scope='module')
def source():
    return GivenPlans([('first', _house(4)), ('second', _house(6))])


def test_pairs_of_a_given_plan_fit_its_own_raster(source):
    mapped = generate_mapped_pair(3, 0, SMALL, source)
    labels = mapped.pair.sub_labels
    assert np.count_nonzero(labels >= 0) >= 2
    rc = np.argwhere(mapped.submap.grid.cells == FREE)
    xy = mapped.pair.A_plan_submap.apply(mapped.submap.grid.rc_to_xy(rc))
    grid = mapped.plan_segmentation.grid
    target = np.rint(grid.xy_to_rc(xy)).astype(int)
    inside = ((target >= 0) & (target < grid.shape)).all(axis=1)
    assert (grid.cells[tuple(target[inside].T)] == FREE).mean() > 0.85


@pytest.mark.parametrize('degrees', [0.0, 13.0, 45.0, 71.0])
def test_walls_of_one_cell_stay_closed_at_any_angle(degrees):
    cells = np.full((60, 60), FREE, np.int8)
    cells[[0, -1, 30], :] = cells[:, [0, -1]] = OCCUPIED
    A = Affine2D(SE2.from_xy_yaw(0.0, 0.0, np.deg2rad(degrees)).linear, np.zeros(2))
    turned = warp_map(GridMap(cells, 0.05), A)
    config = SMALL.segmentation.model_copy(update={'min_room_area_m2': 0.5})
    assert len(segment_floorplan(turned, config).rooms) == 2


def test_a_plan_without_rooms_is_one_clear_line():
    with pytest.raises(MapFormatError, match='blank: the floorplan has no rooms'):
        GivenPlans([('blank', GridMap(np.full((40, 40), UNKNOWN, np.int8), 0.05))])
    with pytest.raises(MapFormatError, match='no floorplan was given'):
        GivenPlans([])


def test_a_single_closed_room_is_one_clear_line():
    cells = np.full((80, 100), OCCUPIED, np.int8)
    cells[2:-2, 2:-2] = FREE
    with pytest.raises(MapFormatError, match='cell: the floorplan has 1 room, expected 2'):
        GivenPlans([('cell', GridMap(cells, 0.05))])


def test_tours_that_see_too_little_are_one_clear_line(monkeypatch):
    monkeypatch.setattr('fpnet_lab.sim.pairs.pair.MIN_SUB_REGIONS', 99)
    monkeypatch.setattr('fpnet_lab.sim.pairs.pair._ATTEMPTS', 2)
    with pytest.raises(FpnetError, match='no tour in 2 saw 99 regions'):
        generate_pair(0, 0, SMALL, GivenPlans([('cell', _house(4))]))


def test_presets_are_the_papers():
    assert PRESETS['paper-synthetic'].pair_count(0) == 25000
    assert PRESETS['paper-real'].pair_count(20) == 1000
    assert PRESETS['paper-challenging'].config.drawing.cut == 1.0
    assert PRESETS['default'].pair_count(0) is None
    with pytest.raises(ConfigError, match="no preset 'x'; expected one of default"):
        preset('x')


def test_splits_choose_by_name():
    plans = [('office_a', _house(4)), ('office_f', _house(4))]
    assert [name for name, _ in in_split(plans, 'report')] == ['office_f']
    with pytest.raises(ConfigError, match='no split'):
        in_split(plans, 'test')
    with pytest.raises(ConfigError, match='is a tune storey: lab_a_scan'):
        in_split(plans[1:], 'tune')


def _run(*arguments):
    return CliRunner().invoke(app, ['pairs', *map(str, arguments)])


def test_the_command_makes_pairs_of_my_plan(tmp_path):
    write_map(_house(4), tmp_path / 'mine.yaml')
    result = _run('--out', tmp_path / 'out', '--count', 2, '--floorplan', tmp_path / 'mine.yaml')
    assert result.exit_code == 0, result.output
    assert len(PairDataset(tmp_path / 'out')) == 2
    assert list(read_manifest(tmp_path / 'out')['source']['plans']) == ['mine']
    graph = PairDataset(tmp_path / 'out').pair(0).plan_graph
    assert any(region.label is RegionLabel.DOOR for region in graph.regions)


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['--preset', 'paper-real'], 'needs real floorplans; give --plans PATH'),
        ([], 'has no default number of pairs; give --count'),
        (['--split', 'tune', '--count', 1], 'give --plans PATH'),
        (['--floorplan', 'absent.png', '--count', 1], 'absent.png does not exist'),
    ],
)
def test_impossible_requests_are_refused(tmp_path, arguments, message):
    result = _run('--out', tmp_path / 'out', *arguments)
    assert isinstance(result.exception, FpnetError)
    assert message in str(result.exception)


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
