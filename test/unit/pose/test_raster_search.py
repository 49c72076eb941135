# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Placements that the rasters propose, and their ranking where scales differ."""

from dataclasses import replace
from functools import cache

import numpy as np
from planted import A_BUILDING_PLAN, A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.config import PoseConfig
from fpnet_core.geometry import SE2, Affine2D, Placements, angle_between
from fpnet_core.pose import AlignmentPrior, aligned_placements, map_evidence
from fpnet_core.pose.raster_search import search_placements, wall_turns
from fpnet_core.types import UNKNOWN

FACTORS = np.exp(0.12 * np.arange(-6, 7))
SHRUNK = 0.45
CONFIG = PoseConfig()


@cache
def plan_evidence():
    return map_evidence(plan_grid())


@cache
def room_evidence():
    """The robot has seen one room of 6 by 4 m through to its corner, and nothing else."""
    grid = submap_grid()
    rc = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing='ij'), axis=-1)
    xy = (A_BUILDING_PLAN @ A_PLAN_SUBMAP).apply(grid.rc_to_xy(rc))
    seen = (xy[..., 0] > 13.85) & (xy[..., 1] > 5.2)
    return map_evidence(replace(grid, cells=np.where(seen, grid.cells, UNKNOWN)))


def corner_error(A, sub):
    return np.linalg.norm(A.apply(sub.corners) - A_PLAN_SUBMAP.apply(sub.corners), axis=1).mean()


def test_wall_turns_hold_the_true_rotation():
    turns = wall_turns(plan_evidence(), map_evidence(submap_grid()))
    assert len(turns) % 4 == 0
    off = min(abs(angle_between(turn, np.deg2rad(67.0))) for turn in turns)
    assert off < np.deg2rad(2.0)


@pytest.mark.parametrize('sub', [room_evidence, lambda: map_evidence(submap_grid())])
def test_the_true_place_is_among_the_best_of_the_search(sub):
    sub = sub()
    found = search_placements(plan_evidence(), sub, FACTORS, 30)
    assert 0 < len(found) <= 30
    assert min(corner_error(placed.A_plan_submap, sub) for placed in found) < 1.0


def test_scales_at_which_the_map_is_larger_than_the_plan_are_left_out():
    sub = map_evidence(submap_grid())
    assert len(search_placements(plan_evidence(), sub, np.array([4.0]), 30)) == 0


def test_a_map_without_walls_proposes_nothing():
    grid = submap_grid()
    blank = map_evidence(replace(grid, cells=np.full(grid.shape, UNKNOWN)))
    assert len(search_placements(plan_evidence(), blank, FACTORS, 30)) == 0


def test_a_shrunk_placement_of_equal_score_ranks_below_the_true_one():
    sub = room_evidence()
    centre = sub.corners.mean(axis=0)
    placed = A_PLAN_SUBMAP.apply(centre)
    linear = SHRUNK * A_PLAN_SUBMAP.linear
    tiny = Affine2D(linear, placed - linear @ centre)
    candidates = Placements.of([tiny, A_PLAN_SUBMAP @ SE2.from_xy_yaw(0.1, -0.1, 0.01)])
    found = aligned_placements(plan_evidence(), sub, candidates, AlignmentPrior(0.03))
    assert corner_error(found[0].A_plan_submap, sub) < 0.3
    assert found.scale[0] == pytest.approx(1.0, abs=0.05)
    assert found[0].score > 0.8
