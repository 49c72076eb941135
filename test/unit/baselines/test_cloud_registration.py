# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Maps as clouds, and what registers clouds on the planted building, where it is installed."""

import numpy as np
from planted import A_PLAN_SUBMAP, plan_grid, submap_grid
import pytest

from fpnet_core.types import OCCUPIED, GridMap
from fpnet_lab.baselines.cloud_registration import (
    CLOUD_METHODS,
    installed,
)

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
