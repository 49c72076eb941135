# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which placements are looked at, and which of them somebody's word is for."""

import numpy as np
import pytest

from fpnet_core.geometry import SE2, Placements, Similarity2D
from fpnet_core.localizer.global_localizer import _assigned
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.matches import MatchHypothesis, MatchResult


def assigned(scales, factors):
    """Return the scales that are left of complete assignments with these."""
    pairs = np.array([[0, 0], [1, 1]])
    hypotheses = tuple(
        MatchHypothesis(pairs, 0.1, Similarity2D.from_scale_yaw(scale, 0.7, (3.0, -1.0)))
        for scale in scales
    )
    match = MatchResult(pairs, np.ones(2), np.full((2, 2), 0.5), hypotheses)
    return _assigned(match, np.array(factors)).scale.tolist()


@pytest.mark.parametrize(
    ('factors', 'kept'),
    [
        ((1.0,), [0.96, 1.0, 1.04]),
        ((0.9, 1.0, 1.1), [0.85, 0.96, 1.0, 1.04, 1.2]),
        ((1.6, 2.0, 2.4), [1.4, 2.0, 2.9]),
    ],
)
def test_assignments_may_leave_the_scales_to_try_by_as_much_again(factors, kept):
    scales = [0.5, 0.7, 0.85, 0.96, 1.0, 1.04, 1.2, 1.4, 2.0, 2.9, 4.0]
    assert assigned(scales, factors) == pytest.approx(kept)


def test_no_assignment_is_no_placement():
    assert assigned([], (1.0,)) == []


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
