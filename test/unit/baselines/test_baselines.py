# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Other matchers and localizers find a planted placement, or say that they have not."""

from dataclasses import replace

from graph_pairs import toy_pair
import numpy as np
from planted import A_BUILDING_PLAN, A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.config import MatcherConfig
from fpnet_core.geometry import SE2, Similarity2D, angle_between
from fpnet_core.graphs.features import AREA, LABEL, NODE_FEATURES
from fpnet_core.matches import MatchResult
from fpnet_core.pose import map_evidence
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Region, RegionGraph, RegionLabel
from fpnet_lab.baselines import MATCHERS, NearestNeighborMatcher, correlative
from fpnet_lab.baselines.amcl import Amcl
from fpnet_lab.baselines.branch_and_bound import _LEVELS, BranchAndBound
from fpnet_lab.baselines.cloud_registration import CLOUD_METHODS, installed
from fpnet_lab.baselines.correlative import search_placement
from fpnet_lab.baselines.matcher_ransac import place_by_ransac
from fpnet_lab.baselines.monte_carlo import MonteCarlo, MonteCarloSettings

NEAR_M, NEAR_RAD = 1.0, np.deg2rad(10.0)  # as the benchmark counts what is right


@pytest.mark.parametrize('name', CLOUD_METHODS)
def test_the_planted_building_is_found(name):
    if name not in installed():
        pytest.skip(f"{name} is not installed: pip install 'fpnet_ros[peers]'")
    sub = submap_grid()
    answer = CLOUD_METHODS[name](plan_grid())(sub)
    assert answer is not None
    walls = sub.rc_to_xy(np.argwhere(sub.cells == OCCUPIED))
    off = answer.A_plan_submap.apply(walls) - A_PLAN_SUBMAP.apply(walls)
    assert np.linalg.norm(off.mean(axis=0)) < NEAR_M
    assert abs(answer.A_plan_submap.heading - A_PLAN_SUBMAP.heading) < NEAR_RAD
    empty = GridMap(np.zeros((20, 20), np.int8), 0.1)
    assert CLOUD_METHODS[name](plan_grid())(empty) is None


TRUTH = Similarity2D.from_scale_yaw(1.25, np.deg2rad(40.0), [3.0, 2.0])


def drawing():
    """Return three rooms of different shape, 24 x 15 m at 0.1 m."""
    cells = np.full((170, 260), UNKNOWN, np.int8)
    for x, y, width, height in ((10, 10, 120, 60), (10, 70, 50, 80), (130, 10, 110, 100)):
        cells[y : y + height, x : x + width] = OCCUPIED
        cells[y + 2 : y + height - 2, x + 2 : x + width - 2] = FREE
    return GridMap(cells, 0.1)


def seen_from(plan, truth):
    """Return the plan as a map in a frame from which ``truth`` leads to the plan's."""
    shape = (220, 240)
    grid = GridMap(np.full(shape, UNKNOWN, np.int8), 0.1, frame='submap')
    rc = np.argwhere(np.ones(shape, dtype=bool))
    at = np.rint(plan.xy_to_rc(truth.apply(grid.rc_to_xy(rc) - [6.0, 9.0]))).astype(int)
    inside = ((at >= 0) & (at < plan.shape)).all(axis=1)
    cells = grid.cells.copy()
    cells[rc[inside, 0], rc[inside, 1]] = plan.cells[at[inside, 0], at[inside, 1]]
    shifted = Similarity2D(truth.linear, truth.apply(np.array([-6.0, -9.0])))
    return GridMap(cells, 0.1, frame='submap'), shifted


def test_a_planted_similarity_is_found(monkeypatch):
    # A tenth of the published grid: the truth lies on it, and the test stays short.
    monkeypatch.setattr(correlative, 'ROTATIONS', 9)
    plan = drawing()
    sub, truth = seen_from(plan, TRUTH)
    found = search_placement(plan, sub, np.array([0.8, 1.0, 1.25]))
    assert found is not None
    assert found.A_plan_submap.linear == pytest.approx(truth.linear, abs=1e-9)
    # Three quarters of a raster pixel, which is 0.17 m here.
    assert found.A_plan_submap.translation == pytest.approx(truth.translation, abs=0.25)
    assert 0.5 < found.score < 1.1


def test_a_map_without_walls_is_nowhere():
    plan = drawing()
    assert search_placement(plan, GridMap(np.zeros((5, 5), np.int8), 0.1)) is None


SETTINGS = MonteCarloSettings(max_particles=5000)


@pytest.fixture(scope='module')
def plan():
    return map_evidence(plan_grid())


@pytest.fixture(scope='module')
def sub():
    return map_evidence(submap_grid())


def test_branch_and_bound_finds_the_planted_placement(plan, sub):
    placement = BranchAndBound(plan, np.array([1.0])).place(sub)
    assert placement.is_accepted
    moved = placement.A_plan_submap.apply(sub.walls) - A_PLAN_SUBMAP.apply(sub.walls)
    # The submap is planted with 2 percent of stretch, that the search does not know.
    assert np.median(np.linalg.norm(moved, axis=1)) < 0.4


def test_branch_and_bound_is_exact(plan, sub):
    search = BranchAndBound(plan, np.array([1.0]))
    few = replace(sub, walls=sub.walls[::60])
    placement = search.place(few)
    points, linear = search._turned(few.walls - few.walls.mean(axis=0))
    rows, cols = search._shape
    rc = np.stack(np.meshgrid(np.arange(rows), np.arange(cols), indexing='ij'), -1).reshape(-1, 2)
    pad = 2 ** (_LEVELS - 1)
    field = search._pyramid[0]
    best = 0.0
    for turned in points[:: max(1, len(points) // 8)]:  # a part of all rotations
        cells = rc[:, None] + turned[None] + pad
        inside = ((cells >= 0) & (cells < field.shape)).all(axis=-1)
        r, c = np.where(inside[..., None], cells, 0).transpose(2, 0, 1)
        best = max(best, float((field[r, c] * inside).mean(axis=1).max()))
    assert placement.score >= best - 1e-5
    assert len(linear) == len(points)


def graph(centroids, frame):
    regions = tuple(
        Region(i, RegionLabel.ROOM, xy + np.array([[0, 0], [1, 0], [0, 1]]), xy, 1.0)
        for i, xy in enumerate(np.asarray(centroids, dtype=np.float64))
    )
    empty = np.zeros((0, 2), dtype=np.int64)
    return RegionGraph(regions, empty, np.zeros((len(regions), 1)), np.zeros((0, 1)), frame)


def test_ransac_outvotes_wrong_matches_and_claims_three():
    S = Similarity2D.from_scale_yaw(1.1, 0.7, [3.0, -8.0])
    sub_xy = np.array([[0, 0], [6, 1], [2, 9], [11, 4], [5, 5]], dtype=np.float64)
    plan_xy = S.apply(sub_xy)
    plan_xy[4] += (7.0, -5.0)
    pairs = np.stack([np.arange(5), np.arange(5)], axis=1)
    match = MatchResult(pairs, np.ones(5), np.zeros((5, 5)))
    placement = place_by_ransac(graph(plan_xy, 'plan'), graph(sub_xy, 'submap'), match)
    assert placement.is_accepted
    assert placement.score == pytest.approx(0.8)
    assert np.allclose(placement.A_plan_submap.matrix, S.matrix, atol=1e-6)
    two = MatchResult(pairs[:2], np.ones(2), np.zeros((5, 5)))
    assert not place_by_ransac(graph(plan_xy, 'plan'), graph(sub_xy, 'submap'), two).is_accepted
    one = MatchResult(pairs[:1], np.ones(1), np.zeros((5, 5)))
    assert place_by_ransac(graph(plan_xy, 'plan'), graph(sub_xy, 'submap'), one) is None


def beams_at(evidence, T_plan_base, rng):
    """What a planar scanner of 60 beams meets of the plan's walls, with noise."""
    angles = T_plan_base.yaw + np.arange(60) * np.deg2rad(6.0)
    reach = np.arange(0.2, 15.0, 0.05)
    rays = reach[None, :, None] * np.stack([np.cos(angles), np.sin(angles)], -1)[:, None]
    xy = T_plan_base.translation + rays
    rc = np.rint(xy @ evidence.A_rc_xy[:, :2].T + evidence.A_rc_xy[:, 2]).astype(int)
    rc = np.clip(rc, 0, np.array(evidence.wall_distance.shape) - 1)
    meets = evidence.wall_distance[rc[..., 0], rc[..., 1]] < 0.1
    hits = xy[np.arange(60), meets.argmax(axis=1)][meets.any(axis=1)]
    return T_plan_base.inv().apply(hits) + rng.normal(0.0, 0.01, (len(hits), 2))


def test_monte_carlo_converges_on_the_true_pose_and_claims_it(plan):
    rng = np.random.default_rng(5)
    cloud = MonteCarlo(plan, np.random.default_rng(0), SETTINGS)
    assert not cloud.estimate().is_accepted
    A_plan_building = A_BUILDING_PLAN.inv()
    # Out of the planted building's first room, then along the corridor.
    route = [(3.0, 1.0 + 0.5 * k, np.pi / 2) for k in range(11)]
    route += [(3.0 + 0.5 * k, 6.0, 0.0) for k in range(34)]
    poses = [
        SE2.from_xy_yaw(*A_plan_building.apply(np.array([x, y])), A_plan_building.apply_yaw(yaw))
        for x, y, yaw in route
    ]
    T_odom_plan = SE2.from_xy_yaw(4.0, 5.0, 1.0)
    for T_plan_base in poses:
        cloud.add_scan(beams_at(plan, T_plan_base, rng), T_odom_plan @ T_plan_base)
    mean = cloud.estimate()
    assert mean.is_accepted
    assert np.linalg.norm(mean.T_plan_base.translation - poses[-1].translation) < 0.5
    assert angle_between(mean.T_plan_base.yaw, poses[-1].yaw) < np.deg2rad(5.0)


def test_amcl_starts_at_initial_poses_only(plan):
    """Without motion it publishes once after each; carried off, it stays where it was told."""
    rng, amcl = np.random.default_rng(3), Amcl(plan, np.random.default_rng(2))
    A_plan_building = A_BUILDING_PLAN.inv()

    def scan(x, y, T_odom_base, second):
        at = A_plan_building.apply(np.array([x, y]))
        place = SE2.from_xy_yaw(*at, A_plan_building.apply_yaw(0.0))
        beams = beams_at(plan, place, rng)
        points = np.column_stack([beams, np.zeros(len(beams))]).astype(np.float32)
        return place, amcl.add_scan(points, T_odom_base.as_matrix4(), second * 10**9)

    odometry = [SE2.from_xy_yaw(0.5 * k, 0.0, 0.0) for k in range(12)]
    told, none = scan(2.0, 6.0, odometry[0], 0)
    assert none is None
    amcl.take_initial_pose(told, np.diag([0.25, 0.25, 0.07]), 0)
    # It comes a second late: the odometry since its stamp is added.
    for k in range(1, 12):
        place, mean = scan(2.0 + 0.5 * k, 6.0, odometry[k], k)
        assert mean is not None, k
    assert np.linalg.norm(mean.T_plan_base.translation - place.translation) < 0.4
    assert np.sqrt(mean.cov[0, 0]) < 0.5
    _, none = scan(7.5, 6.0, odometry[-1], 12)
    assert none is None
    kept = mean.T_plan_base
    elsewhere, mean = scan(3.0, 2.5, odometry[-1] @ SE2.from_xy_yaw(0.3, 0.0, 0.0), 13)
    assert np.linalg.norm(mean.T_plan_base.translation - kept.translation) < 1.0
    assert np.linalg.norm(mean.T_plan_base.translation - elsewhere.translation) > 3.0
    assert amcl.starts == 1


def test_monte_carlo_waits_for_motion_and_repeats_itself(plan):
    rng = np.random.default_rng(5)
    clouds = [MonteCarlo(plan, np.random.default_rng(1), SETTINGS) for _ in range(2)]
    beams = beams_at(plan, SE2.from_xy_yaw(0.0, 0.0, 0.0), rng)
    for cloud in clouds:
        assert not cloud.add_scan(beams, SE2.identity())
        assert not cloud.add_scan(beams, SE2.from_xy_yaw(0.1, 0.0, 0.0))
        assert cloud.add_scan(beams, SE2.from_xy_yaw(0.4, 0.0, 0.0))
    first, second = (cloud.estimate().T_plan_base.matrix for cloud in clouds)
    assert np.array_equal(first, second)


EMPTY = RegionGraph((), np.zeros((0, 2)), np.zeros((0, 28)), np.zeros((0, 3)), 'submap')
NAMES = ('ombb', 'rrwm', 'spectral')


# Right rooms of six seeds: all, but for `spectral` 0.96 of one seed.
@pytest.mark.parametrize('name', NAMES)
def test_baselines_find_the_rooms_of_a_corridor(name):
    rng = np.random.default_rng(2)
    matcher = MATCHERS[name](MatcherConfig())
    right = total = 0
    for _ in range(4):
        plan, sub, labels = toy_pair(rng, rooms=9, seen=6)
        pairs = matcher.match(plan, sub, 200.0).pairs
        rooms = [sub.regions[j].label is RegionLabel.ROOM for j in pairs[:, 1]]
        right += int(np.count_nonzero((labels[pairs[:, 1]] == pairs[:, 0]) & rooms))
        total += sum(region.label is RegionLabel.ROOM for region in sub.regions)
    assert right >= 0.9 * total


@pytest.mark.parametrize('name', NAMES)
def test_an_empty_side_has_no_matches(name):
    plan, _, _ = toy_pair(np.random.default_rng(4), rooms=4, seen=2)
    matcher = MATCHERS[name](MatcherConfig())
    assert len(matcher.match(plan, EMPTY, 0.0).pairs) == 0
    assert len(matcher.match(EMPTY, plan, 0.0).pairs) == 0


SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])


def of_squares(rows, frame='plan'):
    regions = tuple(
        Region(i, RegionLabel.ROOM, SQUARE, np.zeros(2), 1.0) for i in range(len(rows))
    )
    return RegionGraph(regions, np.zeros((0, 2)), rows, np.zeros((0, 3)), frame)


def rows_of(areas, doors=()):
    rows = np.zeros((len(areas), NODE_FEATURES), np.float32)
    rows[:, AREA] = np.array(areas)[:, None]
    rows[:, LABEL] = (0, 1)
    for door in doors:
        rows[door, LABEL] = (1, 0)
    return rows


def test_mutual_nearest_descriptors_are_paired():
    # Submap area 0.9 is nearest to plan 1.0, but 1.05 is nearer to that; 5.2 goes with 5.0.
    matcher = NearestNeighborMatcher(MatcherConfig())
    result = matcher.match(
        of_squares(rows_of([1.0, 5.0, 9.0])), of_squares(rows_of([0.9, 1.05, 5.2])), 1.0
    )
    assert result.pairs.tolist() == [[0, 1], [1, 2]]
    assert result.scores == pytest.approx([np.exp(-(0.05**2)), np.exp(-(0.2**2))], rel=1e-4)


def test_doors_never_match_rooms():
    matcher = NearestNeighborMatcher(MatcherConfig())
    result = matcher.match(
        of_squares(rows_of([1.0, 3.0], doors=[0])), of_squares(rows_of([1.0])), 1.0
    )
    assert result.pairs.tolist() == [[1, 0]]
    only_door = of_squares(rows_of([1.0], doors=[0]))
    assert matcher.match(only_door, of_squares(rows_of([1.0])), 1.0).pairs.shape == (0, 2)


@pytest.mark.parametrize('sizes', [(0, 2), (2, 0), (0, 0)])
def test_empty_graphs_have_no_matches(sizes):
    plan, sub = (of_squares(rows_of([1.0] * n).reshape(n, NODE_FEATURES)) for n in sizes)
    result = NearestNeighborMatcher(MatcherConfig()).match(plan, sub, 1.0)
    assert result.pairs.shape == (0, 2)
    assert result.probability.shape == sizes
