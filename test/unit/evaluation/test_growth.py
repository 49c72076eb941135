# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys of any size, and what is said of their cost."""

import numpy as np
import pytest
import shapely

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


def test_a_small_storey_is_measured_and_drawn(tmp_path):
    found = growth.growth(300.0)
    assert found.explored_m2 > 50.0
    assert 0.0 < found.update[1] < 60.0
    assert found.peak_bytes > 5e7
    save_growth([found, STOREY], tmp_path / 'growth.png')
    assert (tmp_path / 'growth.png').stat().st_size > 10_000
