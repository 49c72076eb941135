# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When does an odometry frame end, and what is known across the break?"""

import numpy as np
import pytest

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2
from fpnet_core.localizer.odometry_monitor import OdometryMonitor

SECOND = 10**9
CONFIG = LocalizerConfig(max_speed_mps=2.0, stale_scans_before_restart=3)


def pose(x, y=0.0, yaw=0.0):
    return SE2.from_xy_yaw(x, y, yaw).as_matrix4()


def after(x=0.0):
    continuity = OdometryMonitor(CONFIG)
    assert continuity.check(SECOND, pose(x)) is None
    continuity.go_on_from(SECOND, pose(x))
    return continuity


def test_a_jump_breaks_and_says_where_the_new_frame_lies_in_the_old_one():
    broken = after(x=5.0).check(2 * SECOND, pose(-20.0, 1.0, 0.5))
    assert 'jumped by 25' in broken.reason
    there = broken.T_old_new.apply(np.array([-20.0, 1.0]))
    assert there == pytest.approx([5.0, 0.0])


@pytest.mark.parametrize(('scans_hz', 'breaks'), [(10.0, True), (5.0, False)])
def test_a_frame_that_is_flipped_breaks_unless_a_robot_may_have_turned(scans_hz, breaks):
    upright = np.array([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1.0]])  # has no yaw
    for mount in (np.eye(4), upright):
        continuity = OdometryMonitor(CONFIG)
        continuity.go_on_from(SECOND, pose(5.0) @ mount)
        broken = continuity.check(SECOND + round(SECOND / scans_hz), pose(5.0, 0.0, np.pi) @ mount)
        assert (broken is not None) is breaks
        assert broken is None or 'jumped by 180 degrees' in broken.reason


def test_a_new_frame_may_come_with_an_earlier_clock():
    continuity = after(x=3.0)
    continuity.expect_new_frame()
    broken = continuity.check(SECOND // 2, pose(0.0))
    assert 'restarted' in broken.reason
    assert broken.T_old_new.translation == pytest.approx([3.0, 0.0])
