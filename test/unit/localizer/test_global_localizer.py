# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which placements are looked at, and which of them somebody's word is for."""

import pytest

from fpnet_core.geometry import SE2, Placements, Similarity2D
from fpnet_core.localizer.hint import PoseHint


@pytest.mark.parametrize('scale', [0.7, 1.0, 1.4])
def test_a_hint_is_for_placements_of_any_scale_that_put_the_robot_there(scale):
    here = SE2.from_xy_yaw(10.0, -4.0, 0.3)  # far from where odometry began
    there = SE2.from_xy_yaw(2.0, 5.0, -1.1)
    hint = PoseHint(there, here)
    linear = Similarity2D.from_scale_yaw(scale, there.yaw - here.yaw, (0.0, 0.0))
    around_robot = Similarity2D.from_scale_yaw(
        scale, there.yaw - here.yaw, there.translation - linear.apply(here.translation)
    )
    assert hint.agrees(around_robot)
    turned = around_robot @ here @ SE2.from_xy_yaw(0.0, 0.0, 0.8) @ here.inv()
    around_start = Similarity2D.from_scale_yaw(
        scale, there.yaw - here.yaw, hint.A_plan_odom.translation
    )
    found = Placements.of([turned, around_robot, around_start])
    expected = [False, True, scale == 1.0]
    assert hint.agreeing(found, SE2.from_xy_yaw(0.0, 0.0, 0.0)).tolist() == expected
