# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.errors import ConfigError
from fpnet_core.types import FREE, OCCUPIED, RegionLabel
from fpnet_lab.cli.simulate_pairs import parse_shard
from fpnet_lab.sim.config import BuildingConfig, ScanConfig, SimConfig
from fpnet_lab.sim.pairs.explore import Scanner, scan_walk
from fpnet_lab.sim.pairs.pair import generate_mapped_pair, generate_pair
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes
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


@pytest.mark.parametrize('text', ['2/2', '1', 'a/b', '-1/3', '3/1'])
def test_malformed_shards_are_refused(text):
    with pytest.raises(ConfigError, match='expected I/N'):
        parse_shard(text)
