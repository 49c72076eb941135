# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys of any size, and what is said of their cost."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from fpnet_core.types import UNKNOWN, GridMap, Submap
from fpnet_lab.evaluation.speed import growth
from fpnet_lab.sim.plans.wards import wards
from fpnet_lab.viz.growth import save_growth

STOREY = growth.Grown(
    20_000.0, 423, 3173.0, (3.0, 1.5), (0.6, 0.4), {'segment': 0.3, 'match': 0.2}, 10**9, 'waiting'
)


@pytest.mark.parametrize('area_m2', [300.0, 2_000.0, 8_000.0])
def test_wards_have_the_size_that_is_asked_for(area_m2):
    plan = wards(np.random.default_rng(0), area_m2)
    assert 0.75 * area_m2 < plan.floor_area_m2 < 1.15 * area_m2
    assert len(plan.rooms) == pytest.approx(area_m2 / 50.0, rel=0.35)
    outlines = [room.polygon for room in plan.rooms]
    union = shapely.union_all([shapely.Polygon(outline) for outline in outlines])
    assert union.area == pytest.approx(plan.floor_area_m2, rel=1e-3)


def test_only_the_storey_that_an_aim_is_stated_for_has_one():
    _, update = STOREY.figures()
    assert (update.aim, update.is_met) == (growth.AIM_TICK_S, False)
    assert [each.aim for each in replace(STOREY, area_m2=3_000.0).figures()] == [None, None]


def test_before_a_tick_nothing_near_the_robot_was_known():
    grid = GridMap(np.zeros((300, 400), np.int8), 0.1)
    submap = Submap(grid, np.ones((300, 400), bool), np.array([[1.0, 1.0], [12.0, 9.0]]))
    before = growth._before(submap)
    is_new = before.grid.cells == UNKNOWN
    assert is_new.sum() * 0.01 == pytest.approx(_disc_inside(), rel=0.03)
    assert is_new[90, 120]
    assert not before.lintel[is_new].any()
    assert before.lintel[~is_new].all()


def _disc_inside():
    disc = shapely.Point(12.0, 9.0).buffer(10.0)
    return disc.intersection(shapely.box(0.0, 0.0, 40.0, 30.0)).area


def test_a_small_storey_is_measured_and_drawn(tmp_path):
    found = growth.growth(300.0)
    assert found.explored_m2 > 50.0
    assert 0.0 < found.update[1] < 60.0
    assert found.peak_bytes > 5e7
    save_growth([found, STOREY], tmp_path / 'growth.png')
    assert (tmp_path / 'growth.png').stat().st_size > 10_000
