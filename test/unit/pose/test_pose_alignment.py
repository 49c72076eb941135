# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence, verification and refinement against a planted transform."""

from functools import cache

import numpy as np
from planted import A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.geometry import SE2, Affine2D, Placements, Similarity2D, angle_between
from fpnet_core.pose import (
    FINE,
    ROUGH,
    AlignmentPrior,
    agreement,
    aligned_placements,
    compared_at,
    map_evidence,
    refine,
    select_promising,
)
from fpnet_core.pose.estimate import DISTINCT_M, MAX_REFINED
from fpnet_core.pose.refine import STRAIN_LIMIT

SIGMA_M = 0.2


@cache
def sides():
    return map_evidence(plan_grid()), map_evidence(submap_grid())


def test_fields_are_read_where_the_walls_are():
    plan, _ = sides()
    rc = plan.walls @ plan.A_rc_xy[:, :2].T + plan.A_rc_xy[:, 2]
    at_walls = plan.wall_distance[tuple(np.round(rc).astype(int).T)]
    assert np.quantile(at_walls, 0.95) <= plan.cell_m
    free_rc = np.round(plan.free @ plan.A_rc_xy[:, :2].T + plan.A_rc_xy[:, 2]).astype(int)
    assert np.quantile(plan.outside_depth[tuple(free_rc.T)], 0.95) <= plan.cell_m


def test_dominant_orientation_is_that_of_the_walls():
    plan, sub = sides()
    # The plan's walls are turned by +20 degrees against its frame.
    assert angle_between(4 * plan.orientation, 4 * np.deg2rad(20.0)) / 4 < np.deg2rad(0.5)
    turned = 4 * (plan.orientation - sub.orientation)
    assert angle_between(turned, 4 * np.deg2rad(67.0)) / 4 < np.deg2rad(1.0)
    assert min(plan.orientation_strength, sub.orientation_strength) > 0.8


def test_of_thousands_the_right_candidate_is_kept_once_and_first():
    plan, sub = sides()
    rng = np.random.default_rng(12)
    wrong = np.column_stack([rng.uniform(-9.0, 9.0, (3000, 2)), rng.uniform(1.0, 5.0, 3000)])
    candidates = [SE2.from_xy_yaw(*row) @ A_PLAN_SUBMAP for row in wrong.tolist()]
    candidates[700:705] = [A_PLAN_SUBMAP] * 5
    kept = select_promising(plan, sub, Placements.of(candidates))
    assert len(kept) == MAX_REFINED
    there = kept.apply(sub.corners) - A_PLAN_SUBMAP.apply(sub.corners)
    moved = np.linalg.norm(there, axis=2).max(axis=1)
    assert moved[0] < 1e-9
    assert moved[1:].min() > 0.2
    few = Placements.of([A_PLAN_SUBMAP, candidates[0]])
    assert len(select_promising(plan, sub, few)) == 2


def test_truth_scores_high_and_every_wrong_placement_low():
    plan, sub = sides()
    turns = [A_PLAN_SUBMAP @ SE2.from_xy_yaw(0, 0, a) for a in np.deg2rad([0, 90, 180, 270])]
    shifts = [SE2.from_xy_yaw(dx, dy, 0) @ A_PLAN_SUBMAP for dx, dy in ((2, 0), (0, 3), (-4, 1))]
    scores = agreement(plan, sub, Placements.of([*turns, *shifts]), SIGMA_M).score
    assert scores[0] > 0.85
    assert scores[1:].max() < 0.5


def scattered(count=40):
    """Placements around the true one, some of which put the map off the drawing."""
    rng = np.random.default_rng(2)
    moved = (SE2.from_xy_yaw(*rng.normal(0.0, (6.0, 6.0, 1.0))) for _ in range(count))
    return Placements.of([A_PLAN_SUBMAP, *(A_PLAN_SUBMAP @ T for T in moved)])


def test_drawn_walls_are_met_wherever_a_placement_puts_the_map():
    plan, sub = sides()
    found, likelihood = scattered(), sub.wall_likelihood(SIGMA_M)
    seen = agreement(plan, sub, found, SIGMA_M).plan_seen
    for placement, share in zip(found, seen, strict=True):
        back = placement.A_plan_submap.inv().apply(plan.walls)
        row, col = np.floor(back @ sub.A_rc_xy[:, :2].T + sub.A_rc_xy[:, 2] + 0.5).astype(int).T
        height, width = sub.observed.shape
        is_on = (row >= 0) & (col >= 0) & (row < height) & (col < width)
        row, col = row[is_on], col[is_on]
        met = likelihood[row, col][sub.observed[row, col]]
        assert share == pytest.approx(met.mean() if len(met) else 0.0, abs=1e-6)


def test_a_look_at_few_samples_scores_about_as_one_at_all():
    plan, sub = sides()
    every, few = (agreement(plan, sub, scattered(), SIGMA_M, most).score for most in (None, 300))
    assert few.argmax() == every.argmax() == 0
    np.testing.assert_allclose(few, every, atol=0.1)
    same = agreement(plan, sub, scattered(), SIGMA_M, len(sub.walls) + len(sub.free)).score
    np.testing.assert_array_equal(same, every)


@pytest.mark.parametrize('seed', range(6))
def test_refinement_recovers_pose_and_anisotropy(seed):
    plan, sub = sides()
    rng = np.random.default_rng(seed)
    mid = sub.walls.mean(axis=0)
    off = Similarity2D.from_scale_yaw(1.0, np.deg2rad(67.0) + rng.uniform(-0.06, 0.06), [0.0, 0.0])
    start = A_PLAN_SUBMAP.apply(mid) - off.apply(mid) + rng.uniform(-0.4, 0.4, 2)
    starts = Placements(off.linear[None], start[None])
    rough = refine(plan, sub.walls, starts, AlignmentPrior(0.03), ROUGH)
    got = refine(plan, sub.walls, rough, AlignmentPrior(0.03), FINE)
    error = np.linalg.norm(got.apply(sub.walls)[0] - A_PLAN_SUBMAP.apply(sub.walls), axis=1)
    assert error.max() < 0.1, f'seed {seed}'
    assert np.abs(got.linear[0] - A_PLAN_SUBMAP.linear).max() < 0.01, f'seed {seed}'
    assert np.all(np.linalg.eigvalsh(got.cov[0]) > 0.0)


def strain_of(linear, stretch):
    u, s, _ = np.linalg.svd(linear)
    return (u * s) @ u.T @ np.linalg.inv(stretch) - np.eye(2)


@pytest.mark.parametrize('stretch', [None, np.diag([1.03, 0.98])])
def test_strain_stays_bounded_however_often_a_candidate_is_refined(stretch):
    plan, sub = sides()
    linear = np.diag([1.4, 0.8]) @ A_PLAN_SUBMAP.linear
    done = Placements.of([Affine2D(linear, A_PLAN_SUBMAP.translation)])
    for _ in range(5):
        done = refine(plan, sub.walls, done, AlignmentPrior(0.02, stretch), ROUGH)
    reference = np.sqrt(np.linalg.det(done.linear[0])) * np.eye(2) if stretch is None else stretch
    assert np.abs(strain_of(done.linear[0], reference)).max() <= 1.05 * STRAIN_LIMIT * 0.02


def test_a_scale_that_nobody_allowed_is_not_taken():
    plan, sub = sides()
    larger = Affine2D(1.2 * A_PLAN_SUBMAP.linear, 1.2 * A_PLAN_SUBMAP.translation)
    start = Placements.of([larger])
    done = refine(plan, sub.walls, start, AlignmentPrior(0.03, scales=(0.9, 1.1)), ROUGH)
    assert 0.9 <= np.sqrt(np.linalg.det(done.linear[0])) <= 1.105


def test_estimates_are_distinct_where_the_robot_is():
    plan, sub = sides()
    robot = sub.free.mean(axis=0)
    rng = np.random.default_rng(1)
    starts = [
        SE2.from_xy_yaw(*rng.uniform(-4, 4, 2), turn) @ A_PLAN_SUBMAP
        for turn in np.deg2rad([0, 5, 90, 180, 180, 270])
    ]
    found = aligned_placements(plan, sub, Placements.of(starts), AlignmentPrior(0.03), robot)
    placed = [e.A_plan_submap.apply(compared_at(sub, robot)) for e in found]
    apart = [
        np.linalg.norm(a - b, axis=1).mean() for k, a in enumerate(placed) for b in placed[:k]
    ]
    assert min(apart) > DISTINCT_M
    assert [e.score for e in found] == sorted((e.score for e in found), reverse=True)


def test_a_free_submap_beyond_the_plan_is_violation():
    plan, sub = sides()
    away = SE2.from_xy_yaw(500.0, 0.0, 0.0) @ A_PLAN_SUBMAP
    result = agreement(plan, sub, Placements.of([away]), SIGMA_M)
    assert result.free_violation[0] == 1.0
    assert result.score[0] == 0.0
