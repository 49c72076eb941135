# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pairs of a floorplan and a robot's map: labels, truth, rays."""

import numpy as np
import pytest

from fpnet_core.errors import ConfigError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_core.types import FREE, OCCUPIED, GridMap, Portal, Region, RegionLabel, Segmentation
from fpnet_lab.cli.simulate_pairs import parse_shard
from fpnet_lab.sim.config import BuildingConfig, ClipConfig, ScanConfig, SimConfig
from fpnet_lab.sim.pairs.clips import clip_map
from fpnet_lab.sim.pairs.explore import Scanner, scan_walk
from fpnet_lab.sim.pairs.labels import Relation, label_regions
from fpnet_lab.sim.pairs.pair import generate_mapped_pair, generate_pair
from fpnet_lab.sim.pairs.perturb import build_world, draw_changes
from fpnet_lab.sim.pairs.presets import preset
from fpnet_lab.sim.pairs.scan2d import (
    EMPTY,
    GLASS,
    SOLID,
    cast_rays,
    clear_cells,
    walk_field,
    walk_to,
)
from fpnet_lab.sim.pairs.walks import plan_walk
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.sources import NamedPlan, generated_plans

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


EXACT_CLIP = ClipConfig(
    clipped=0.0, bumps_cells=(0.0, 0.0), specks=(0.0, 0.0), furnished=0.0, resolution_m=(0.05,)
)


@pytest.fixture(scope='module')
def storey():
    return NamedPlan(generate_plan(np.random.default_rng(3), 'branched'), 'branched')


def test_an_exact_clip_shows_its_rooms_where_they_are(storey):
    submap, T_submap_building = clip_map(storey, None, np.random.default_rng(1), EXACT_CLIP)

    rooms = submap.path_xy
    cells = np.rint(submap.grid.xy_to_rc(rooms)).astype(int)
    middles = T_submap_building.inv().apply(rooms)
    known = submap.grid.cells[cells[:, 0], cells[:, 1]]
    assert (known == FREE).all()
    everything = np.array([room.polygon.mean(axis=0) for room in storey.plan.rooms])
    assert np.linalg.norm(everything[None] - middles[:, None], axis=2).min(axis=1).max() < 1e-6


def test_pairs_of_clips_are_labelled_and_repeat():
    config = preset('paper-synthetic').config
    first, second = (generate_pair(5, 3, config) for _ in range(2))

    assert (first.sub_labels == second.sub_labels).all()
    assert (first.sub_labels >= 0).mean() > 0.6
    assert np.array_equal(first.A_plan_submap.matrix, second.A_plan_submap.matrix)


def test_an_unknown_family_is_named():
    source = generated_plans(SimConfig(families=('igloo',)))
    with pytest.raises(ConfigError, match='igloo'):
        source.storey(0, 0, 0)


# Turned by no multiple of 90 degrees, unequal scales and shift: nothing may be swapped.
A_PLAN_SUBMAP = Affine2D(
    np.diag([1.04, 0.95]) @ np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]]),
    np.array([11.0, -4.0]),
)


def _segmentation(boxes, doors, T_frame_building, resolution=0.1):
    """Segment axis-parallel ``boxes`` of a building as seen from a transformed frame."""
    corners = np.array([[-2, -2], [22, -2], [22, 14], [-2, 14]], dtype=float)
    seen = T_frame_building.apply(corners)
    origin = seen.min(axis=0)
    cols, rows = np.ceil((seen.max(axis=0) - origin) / resolution).astype(int)
    cells = np.full((rows, cols), FREE, np.int8)
    grid = GridMap(cells, resolution, SE2.from_xy_yaw(*origin, 0.0))
    rc = np.stack(np.meshgrid(np.arange(rows), np.arange(cols), indexing='ij'), axis=-1)
    xy = T_frame_building.inv().apply(grid.rc_to_xy(rc))
    labels = np.zeros((rows, cols), np.int32)
    regions = []
    scale = abs(np.linalg.det(T_frame_building.linear))
    for x0, y0, x1, y1 in boxes:
        inside = (xy[..., 0] > x0) & (xy[..., 0] < x1) & (xy[..., 1] > y0) & (xy[..., 1] < y1)
        labels[inside] = len(regions) + 1
        ring = T_frame_building.apply([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        area = (x1 - x0) * (y1 - y0) * scale
        regions.append(Region(len(regions), RegionLabel.ROOM, ring, ring.mean(axis=0), area))
    portals = []
    for ends in doors:
        moved = T_frame_building.apply(ends)
        ring = np.vstack([moved + 0.1, moved[::-1] - 0.1])
        regions.append(Region(len(regions), RegionLabel.DOOR, ring, moved.mean(axis=0), 0.2))
        portals.append(Portal(len(regions) - 1, (0, None), moved))
    return Segmentation(grid, labels, tuple(regions), tuple(portals))


ROOMS = [(0, 0, 10, 4), (0, 5, 5, 11), (6, 5, 12, 11)]
DOORS = [[[2, 4.5], [3, 4.5]], [[8, 4.5], [8.9, 4.5]]]
T_SUB = A_PLAN_SUBMAP.inv()


@pytest.fixture
def drawn():
    return _segmentation(ROOMS, DOORS, Affine2D.identity())


def test_the_same_rooms_in_another_order_find_their_partners(drawn):
    sub = _segmentation([ROOMS[2], ROOMS[0], ROOMS[1]], DOORS[::-1], T_SUB)
    assert label_regions(drawn, sub, A_PLAN_SUBMAP).labels.tolist() == [2, 0, 1, 4, 3]


def test_doors_need_the_place_and_the_direction(drawn):
    near = [[2.2, 4.6], [3.2, 4.6]]
    crossed = [[8.45, 4.0], [8.45, 5.0]]
    far = [[14.0, 9.0], [15.0, 9.0]]
    sub = _segmentation([ROOMS[0]], [near, crossed, far], T_SUB)
    assert label_regions(drawn, sub, A_PLAN_SUBMAP).labels.tolist() == [0, 3, IGNORE, UNMATCHED]


def test_two_doors_never_share_a_partner(drawn):
    sub = _segmentation([ROOMS[0]], [DOORS[0], [[2.3, 4.5], [3.3, 4.5]]], T_SUB)
    assert label_regions(drawn, sub, A_PLAN_SUBMAP).labels.tolist() == [0, 3, IGNORE]


def _relations(plan, boxes):
    return label_regions(plan, _segmentation(boxes, [], T_SUB), A_PLAN_SUBMAP).relations.tolist()


def test_relations_tell_whole_partial_split_merged_and_foreign_rooms(drawn):
    assert _relations(drawn, [ROOMS[0]]) == [Relation.MATCHED]
    assert _relations(drawn, [(0, 0, 3, 4)]) == [Relation.MATCHED | Relation.PARTIAL]
    split = Relation.PARTIAL | Relation.SPLIT
    assert _relations(drawn, [(0, 0, 3.5, 4), (4, 0, 10, 4)]) == [split, split | Relation.MATCHED]
    assert _relations(drawn, [(0, 5, 12, 11)]) == [Relation.MATCHED | Relation.MERGED]
    assert _relations(drawn, [(14, 6, 19, 11)]) == [0]


FOUR = np.array([0.0, 0.5, 1.0, 1.5]) * np.pi


def _room(rows=20, cols=30):
    world = np.full((rows, cols), SOLID, np.uint8)
    world[2:-2, 3:-3] = EMPTY
    return world


def _directions(angles):
    angles = np.asarray(angles)
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)[None]


def _cast(world, angles, reach=100.0, passes=None, x=10.5, y=6.25):
    passes = np.zeros((1, len(angles)), bool) if passes is None else np.array([passes])
    starts = np.array([[x, y]])
    clear = clear_cells(world == EMPTY)
    ranges, codes = cast_rays(world[None], clear, starts, _directions(angles), reach, passes)
    return ranges[0, 0], codes[0, 0]


def test_ranges_end_at_the_walls_faces():
    ranges, codes = _cast(_room(), FOUR)
    np.testing.assert_allclose(ranges, [16.5, 11.75, 7.5, 4.25], atol=1e-9)
    assert (codes == SOLID).all()


def test_oblique_rays_meet_the_wall_where_geometry_says():
    ranges, _ = _cast(_room(), [0.3])
    np.testing.assert_allclose(ranges, [16.5 / np.cos(0.3)], atol=1e-9)


def test_leaping_over_clear_cells_changes_nothing():
    rng = np.random.default_rng(5)
    world = np.where(rng.random((120, 150)) < 0.004, SOLID, EMPTY).astype(np.uint8)
    world[58:63, 68:73] = EMPTY
    angles = rng.uniform(-np.pi, np.pi, 500)
    leaping = _cast(world, angles, x=70.4, y=60.7)
    starts, passes = np.array([[70.4, 60.7]]), np.zeros((1, 500), bool)
    no_leaps = np.zeros_like(world)
    stepping = cast_rays(world[None], no_leaps, starts, _directions(angles), 100.0, passes)
    np.testing.assert_allclose(leaping[0], stepping[0][0, 0], atol=1e-9)
    np.testing.assert_array_equal(leaping[1], stepping[1][0, 0])
    assert (leaping[1] == SOLID).any()
    assert (leaping[1] == EMPTY).any()


def test_glass_stops_only_rays_that_do_not_pass():
    world = _room()
    world[:, 15] = GLASS
    ranges, codes = _cast(world, [0.0, 0.0], passes=[False, True])
    np.testing.assert_allclose(ranges, [4.5, 16.5])
    assert codes.tolist() == [GLASS, SOLID]


def test_walks_go_around_walls_and_cut_no_corners():
    passable = np.ones((9, 9), bool)
    passable[4, :7] = False
    previous, length = walk_field(passable, 0, 0)
    walk = walk_to(previous, 9, 8, 0)
    assert walk[0].tolist() == [0, 0]
    assert walk[-1].tolist() == [8, 0]
    assert passable[walk[:, 0], walk[:, 1]].all()
    assert (np.abs(np.diff(walk, axis=0)).max(axis=1) == 1).all()
    steps = np.diff(walk, axis=0)
    for (row, col), (dr, dc) in zip(walk[:-1], steps, strict=True):
        assert passable[row + dr, col]
        assert passable[row, col + dc]
    assert length[8 * 9] == np.float32(np.hypot(*steps.T).sum())
