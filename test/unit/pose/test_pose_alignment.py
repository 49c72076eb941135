# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence, verification and refinement against a planted transform."""

from functools import cache

import numpy as np
from planted import A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.geometry import SE2, Similarity2D, angle_between
from fpnet_core.pose import FINE, ROUGH, agreement, coarse_support, map_evidence, refine
from fpnet_core.types import FREE, UNKNOWN, GridMap

SIGMA_M = 0.2


@cache
def sides():
    return map_evidence(plan_grid()), map_evidence(submap_grid())


def batch(*transforms):
    return np.array([T.linear for T in transforms]), np.array([T.translation for T in transforms])


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


def test_truth_scores_high_and_every_wrong_placement_low():
    plan, sub = sides()
    turns = [A_PLAN_SUBMAP @ SE2.from_xy_yaw(0, 0, a) for a in np.deg2rad([0, 90, 180, 270])]
    shifts = [SE2.from_xy_yaw(dx, dy, 0) @ A_PLAN_SUBMAP for dx, dy in ((2, 0), (0, 3), (-4, 1))]
    scores = agreement(plan, sub, *batch(*turns, *shifts), SIGMA_M).score
    assert scores[0] > 0.85
    assert scores[1:].max() < 0.5


def test_coarse_and_full_scores_of_no_candidate_are_empty():
    plan, sub = sides()
    empty = np.zeros((0, 2, 2)), np.zeros((0, 2))
    assert coarse_support(plan, sub, *empty, SIGMA_M, 100).shape == (0,)
    assert agreement(plan, sub, *empty, SIGMA_M).score.shape == (0,)


@pytest.mark.parametrize('seed', range(6))
def test_refinement_recovers_pose_and_anisotropy(seed):
    plan, sub = sides()
    rng = np.random.default_rng(seed)
    mid = sub.walls.mean(axis=0)
    off = Similarity2D.from_scale_yaw(1.0, np.deg2rad(67.0) + rng.uniform(-0.06, 0.06), [0.0, 0.0])
    start = A_PLAN_SUBMAP.apply(mid) - off.apply(mid) + rng.uniform(-0.4, 0.4, 2)
    rough = refine(plan, sub, off.linear[None], start[None], 0.03, ROUGH)
    got = refine(plan, sub, rough.linear, rough.translation, 0.03, FINE)
    placed = sub.walls @ got.linear[0].T + got.translation[0]
    error = np.linalg.norm(placed - A_PLAN_SUBMAP.apply(sub.walls), axis=1)
    assert error.max() < 0.1, f'seed {seed}'
    assert np.abs(got.linear[0] - A_PLAN_SUBMAP.linear).max() < 0.01, f'seed {seed}'
    assert np.all(np.linalg.eigvalsh(got.cov[0]) > 0.0)


def test_a_free_submap_beyond_the_plan_is_violation():
    plan, sub = sides()
    away = SE2.from_xy_yaw(500.0, 0.0, 0.0) @ A_PLAN_SUBMAP
    result = agreement(plan, sub, *batch(away), SIGMA_M)
    assert result.free_violation[0] == 1.0
    assert result.score[0] == 0.0


@pytest.mark.parametrize('value', [FREE, UNKNOWN])
def test_a_map_without_walls_gives_no_wall_evidence(value):
    evidence = map_evidence(GridMap(np.full((40, 30), value, dtype=np.int8), 0.05))
    assert evidence.walls.shape == (0, 2)
    assert evidence.orientation_strength == 0.0
