# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Branch and bound, Monte Carlo and RANSAC find a planted placement, or say that they have not."""

from dataclasses import replace

import numpy as np
from planted import A_BUILDING_PLAN, A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.geometry import SE2, Similarity2D, angle_between
from fpnet_core.matches import MatchResult
from fpnet_core.pose import map_evidence
from fpnet_core.types import Region, RegionGraph, RegionLabel
from fpnet_lab.baselines.amcl import Amcl
from fpnet_lab.baselines.branch_and_bound import _LEVELS, BranchAndBound, _pyramid
from fpnet_lab.baselines.matcher_ransac import place_by_ransac
from fpnet_lab.baselines.monte_carlo import MonteCarlo, MonteCarloSettings, planar_slice

SETTINGS = MonteCarloSettings(max_particles=5000)


@pytest.fixture(scope='module')
def plan():
    return map_evidence(plan_grid())


@pytest.fixture(scope='module')
def sub():
    return map_evidence(submap_grid())


def test_pyramid_holds_maxima_of_windows_that_begin_at_a_cell():
    rng = np.random.default_rng(3)
    field = rng.random((70, 90), dtype=np.float32)
    levels = _pyramid(field)
    pad = 2 ** (_LEVELS - 1)
    assert levels.shape == (_LEVELS, 70 + pad, 90 + pad)
    for h, row, col in ((0, 5, 7), (2, 66, 88), (3, 10, 20), (6, 0, 0)):
        window = field[row : row + 2**h, col : col + 2**h]
        assert levels[h, pad + row, pad + col] == window.max()
    # A window that begins four cells outside and reaches in.
    assert levels[3, pad - 4, pad - 4] == field[:4, :4].max()


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


def test_branch_and_bound_refuses_an_empty_submap_and_a_poor_fit(plan, sub):
    search = BranchAndBound(plan, np.array([1.0]))
    assert search.place(replace(sub, walls=np.zeros((0, 2)))) is None
    scattered = np.random.default_rng(1).uniform(-20.0, 20.0, size=(200, 2))
    assert search.place(replace(sub, walls=scattered)) is None


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


def test_planar_slice_is_level_and_keeps_the_nearest_return_of_a_direction():
    T = np.eye(4)
    T[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # yaw of 90 degrees is taken out
    points = np.array([[3, 0.01, 0.1], [2, 0.01, 0.0], [0, 4, 0.2], [1, 0.01, 1.5]], np.float32)
    points[2, 0] = -0.01  # just beyond 90 degrees
    assert np.allclose(planar_slice(points, T), [[2.0, 0.01], [-0.01, 4.0]])
    pitched = np.eye(4)
    pitched[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]  # nose down: ahead is below
    assert len(planar_slice(points[:2], pitched)) == 0
    assert planar_slice(np.zeros((0, 3), np.float32), T).shape == (0, 2)


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
