# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
import shapely

from fpnet_core.errors import ConfigError
from fpnet_core.geometry import SE2
from fpnet_core.types import FREE, OCCUPIED, RegionLabel
from fpnet_lab.cli.simulate_pairs import parse_shard
from fpnet_lab.sim.config import BuildingConfig, ScanConfig, SimConfig
from fpnet_lab.sim.pairs.explore import Scanner, fit_rigid, scan_walk
from fpnet_lab.sim.pairs.pair import generate_mapped_pair, generate_pair
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes, move_doors
from fpnet_lab.sim.pairs.walks import plan_walk
from fpnet_lab.sim.plans import generate_plan

SMALL = SimConfig(max_rooms=14)
EXACT = ScanConfig(
    planar=0.0,
    noise_m=(0.0, 0.0),
    yaw_drift_rad=(0.0, 0.0),
    jitter_m=(0.0, 0.0),
    jitter_rad=(0.0, 0.0),
    length_drift=0.0,
    warp=(0.0, 0.0),
)
BARE = BuildingConfig(
    furnished=0.0,
    closed_doors=(0.0, 0.0),
    moved_doors=0.0,
    moved_walls=0.0,
    removed_walls=0.0,
    added_walls=0.0,
    glass=(0.0, 0.0),
)


@pytest.fixture(scope='module')
def plan():
    return generate_plan(np.random.default_rng(4), 'house')


def test_pairs_do_not_depend_on_what_came_before():
    alone = generate_pair(9, 5, SMALL)
    generate_pair(9, 0, SMALL)
    again = generate_pair(9, 5, SMALL)
    np.testing.assert_array_equal(alone.sub_labels, again.sub_labels)
    np.testing.assert_array_equal(alone.plan_graph.node_feat, again.plan_graph.node_feat)
    np.testing.assert_array_equal(alone.A_plan_submap.matrix, again.A_plan_submap.matrix)


def test_pairs_of_one_storey_share_its_id_only():
    first, second = generate_pair(9, 8, SMALL), generate_pair(9, 9, SMALL)
    assert first.plan_id == second.plan_id == 1
    assert not np.allclose(first.A_plan_submap.matrix, second.A_plan_submap.matrix)


@pytest.mark.parametrize('index', [0, 4, 8])
def test_the_true_transform_puts_partners_on_each_other(index):
    mapped = generate_mapped_pair(21, index, SMALL)
    pair = mapped.pair
    labels = pair.sub_labels
    assert len(labels) == len(pair.sub_graph)
    matched = np.flatnonzero(labels >= 0)
    assert len(np.unique(labels[matched])) == len(matched) > 0
    for i in matched.tolist():
        sub, plan = pair.sub_graph.regions[i], pair.plan_graph.regions[labels[i]]
        assert sub.label is plan.label
        if sub.label is RegionLabel.DOOR:
            gap = pair.A_plan_submap.apply(sub.centroid) - plan.centroid
            assert np.hypot(*gap) < 0.6
    rc = np.argwhere(mapped.submap.grid.cells == FREE)
    xy = pair.A_plan_submap.apply(mapped.submap.grid.rc_to_xy(rc))
    grid = mapped.plan_segmentation.grid
    target = np.rint(grid.xy_to_rc(xy)).astype(int)
    inside = ((target >= 0) & (target < grid.shape)).all(axis=1)
    hits = grid.cells[target[inside, 0], target[inside, 1]] == FREE
    assert hits.sum() / len(rc) > 0.75


def test_an_exact_robot_in_an_empty_building_sees_its_plan(plan):
    rng = np.random.default_rng(1)
    world = build_world(plan, draw_changes(plan, rng, BARE), scan_height_m=1.0)
    walk = plan_walk(world, rng, EXACT)
    scanner = Scanner(is_planar=False, height_m=1.0, max_range_m=15.0, noise_m=0.0, rays=540)
    submap, T_submap_building = scan_walk(world, walk, scanner, rng, EXACT)
    np.testing.assert_allclose(T_submap_building.apply(walk), submap.path_xy, atol=1e-9)
    rooms = world.room_of >= 0
    for value, near_room in ((FREE, True), (OCCUPIED, True)):
        rc = np.argwhere(submap.grid.cells == value)
        xy = T_submap_building.inv().apply(submap.grid.rc_to_xy(rc))
        cells = np.floor(world.to_cells(xy)).astype(int)
        reach = np.array([-4, 0, 4])
        touched = np.zeros(len(cells), bool)
        for dx in reach:
            for dy in reach:
                touched |= rooms[cells[:, 1] + dy, cells[:, 0] + dx]
        assert touched.mean() > 0.999 if near_room else touched.mean() < 0.001
    assert submap.lintel.any()


def test_lintels_lie_in_walls_and_span_a_door(plan):
    rng = np.random.default_rng(1)
    world = build_world(plan, draw_changes(plan, rng, BARE), scan_height_m=1.0)
    walk = plan_walk(world, rng, EXACT)
    scanner = Scanner(is_planar=False, height_m=1.0, max_range_m=15.0, noise_m=0.0, rays=540)
    submap, T = scan_walk(world, walk, scanner, rng, EXACT)
    lintels = T.inv().apply(submap.grid.rc_to_xy(np.argwhere(submap.lintel)))
    rooms = shapely.union_all([shapely.Polygon(room.polygon).buffer(-0.1) for room in plan.rooms])
    assert not shapely.contains_xy(rooms, *lintels.T).any()
    under = [
        shapely.contains_xy(shapely.LineString(door.ends).buffer(0.15), *lintels.T).sum()
        for door in plan.doors
    ]
    assert max(under) > 8


def test_planar_scanners_know_no_lintels(plan):
    rng = np.random.default_rng(1)
    world = build_world(plan, draw_changes(plan, rng, BARE), scan_height_m=0.3)
    scanner = Scanner(is_planar=True, height_m=0.3, max_range_m=15.0, noise_m=0.0, rays=540)
    walk = plan_walk(world, rng, EXACT)
    submap, _ = scan_walk(world, walk, scanner, rng, EXACT)
    assert not submap.lintel.any()


def test_narrow_scanners_look_ahead(plan):
    rng = np.random.default_rng(1)
    world = build_world(plan, draw_changes(plan, rng, BARE), scan_height_m=0.3)
    middle = np.array(shapely.Polygon(plan.rooms[0].polygon).representative_point().coords[0])
    ahead = np.array([0.8, -0.6])
    walk = np.stack([middle, middle + 0.1 * ahead])
    scanner = Scanner(True, 0.3, max_range_m=15.0, noise_m=0.0, rays=540, fov_rad=np.pi)
    submap, T = scan_walk(world, walk, scanner, rng, EXACT)
    seen = T.inv().apply(submap.grid.rc_to_xy(np.argwhere(submap.grid.cells == FREE)))
    along = (seen - middle) @ ahead
    assert along.min() > -0.2
    assert along.max() > 0.5


def test_the_best_rigid_fit_recovers_a_planted_transform():
    rng = np.random.default_rng(3)
    xy = rng.uniform((-3.0, 2.0), (15.0, 40.0), (30, 2))
    planted = SE2.from_xy_yaw(4.0, -9.0, 2.1)
    found = fit_rigid(xy, planted.apply(xy), np.full(30, 2.1))
    np.testing.assert_allclose(found.matrix, planted.matrix, atol=1e-9)
    one = fit_rigid(xy[:1], planted.apply(xy[:1]), np.array([2.1]))
    np.testing.assert_allclose(one.matrix, planted.matrix, atol=1e-9)


def test_moved_doors_stay_in_their_walls(plan):
    moved = move_doors(plan, np.random.default_rng(0), share=1.0)
    changed = 0
    for before, after in zip(plan.doors, moved, strict=True):
        assert before.rooms == after.rooms
        assert before.width_m == pytest.approx(after.width_m)
        along = before.ends[1] - before.ends[0]
        shift = after.ends[0] - before.ends[0]
        assert abs(along[0] * shift[1] - along[1] * shift[0]) < 1e-9
        changed += np.abs(shift).max() > 0.0
    assert changed > 0


@pytest.mark.parametrize('text', ['2/2', '1', 'a/b', '-1/3', '3/1'])
def test_malformed_shards_are_refused(text):
    with pytest.raises(ConfigError, match='expected I/N'):
        parse_shard(text)


def test_shards_are_parsed():
    assert parse_shard('3/7') == (3, 7)
