# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What must hold of every answer: frames and order mean nothing, and less evidence is no proof."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2
from fpnet_core.localizer import MapMatchStatus, match_maps
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.pairs.pair import generate_mapped_pair

SCENES = range(2)
CLAIM = FpnetConfig().localizer.accept_probability


@cache
def matcher():
    return LearnedMatcher(FpnetConfig().matcher)


@cache
def mapped(index):
    sim = SimConfig()
    return generate_mapped_pair(431, index * sim.pairs_per_plan, sim)


def matched(plan, submap):
    return match_maps(plan, submap, matcher(), FpnetConfig(), True, True)


def plan_of(index):
    return mapped(index).plan_segmentation.grid


def error_m(found, index, submap):
    """How far the best placement moves the middle of the robot's free space."""
    rc = np.argwhere(submap.grid.cells == FREE).mean(axis=0)
    middle = submap.grid.rc_to_xy(rc)
    truth = mapped(index).pair.A_plan_submap
    return float(np.linalg.norm(found.A_best.apply(middle) - truth.apply(middle)))


def taken_away(submap, share, rng):
    """The same map with all but a disc around one of its free cells unseen."""
    free = np.argwhere(submap.grid.cells == FREE)
    centre = free[rng.integers(len(free))]
    far = np.linalg.norm(free - centre, axis=1)
    radius = np.quantile(far, share)
    rows, cols = np.indices(submap.grid.shape)
    away = np.hypot(rows - centre[0], cols - centre[1]) > radius
    return replace(
        submap, grid=replace(submap.grid, cells=np.where(away, UNKNOWN, submap.grid.cells))
    )


@pytest.mark.parametrize('index', SCENES)
def test_laying_both_maps_elsewhere_changes_nothing(index):
    plan, submap = plan_of(index), mapped(index).submap
    plain = matched(plan, submap)
    T, U = SE2.from_xy_yaw(31.0, -12.0, 0.8), SE2.from_xy_yaw(-7.0, 19.0, -2.1)
    laid = matched(
        replace(plan, T_frame_grid=T @ plan.T_frame_grid),
        replace(submap, grid=replace(submap.grid, T_frame_grid=U @ submap.grid.T_frame_grid)),
    )
    assert laid.status is plain.status
    assert laid.probability == pytest.approx(plain.probability, abs=0.05)
    back = T.inv() @ laid.A_best @ U
    moved = back.apply(submap.path_xy) - plain.A_best.apply(submap.path_xy)
    assert np.linalg.norm(moved, axis=1).max() < 0.3


@pytest.mark.parametrize('index', SCENES)
def test_a_plan_against_itself_is_claimed(index):
    plan = plan_of(index)
    found = matched(plan, submap_from_grid(plan))
    assert found.status is MapMatchStatus.MATCHED
    corners = found.plan.evidence.corners
    assert np.linalg.norm(found.A_best.apply(corners) - corners, axis=1).max() < 0.3


@pytest.mark.parametrize('index', SCENES)
@pytest.mark.parametrize('share', [0.6, 0.3, 0.1, 0.03])
def test_taking_away_what_was_seen_makes_no_wrong_placement_sure(index, share):
    rng = np.random.default_rng([index, round(100 * share)])
    submap = taken_away(mapped(index).submap, share, rng)
    if not (submap.grid.cells == OCCUPIED).any():
        pytest.skip('no wall is left to be seen')
    found = matched(plan_of(index), submap)
    assert found.probability < CLAIM or error_m(found, index, submap) < 2.0


@pytest.mark.parametrize('index', SCENES)
def test_other_buildings_plans_are_not_claimed(index):
    other = plan_of((index + 1) % len(SCENES))
    found = matched(other, mapped(index).submap)
    assert found.status is not MapMatchStatus.MATCHED
