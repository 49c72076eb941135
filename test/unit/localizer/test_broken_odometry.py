# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Odometry that breaks under a claim: what is published."""

import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import drive, recorded
import pytest

from fpnet_core.config import load_config
from fpnet_core.geometry import SE2, angle_between
from fpnet_core.localizer import Localizer
from fpnet_core.matches import MatchResult

AT, TICK_EVERY = 50, 5
OFF_M, OFF_RAD = 0.5, np.deg2rad(5.0)


class IndifferentMatcher:
    """Holds every pair for equally likely, so that the raster alone has to decide."""

    def match(self, plan, sub, explored_area_m2):
        shape = (len(plan), len(sub))
        return MatchResult(np.zeros((0, 2)), np.zeros(0), np.full(shape, 0.01))


def published(scans):
    """Return of every scan whether a pose was published, and whether it was right."""
    localizer, found = Localizer(load_config(None, {}), IndifferentMatcher()), []
    localizer.set_plan(plan_grid())
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(scans):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % TICK_EVERY == TICK_EVERY - 1:
            localizer.update(stamp_ns)
        pose = localizer.output.pose(T_odom_sensor)
        found.append(None if pose is None else is_right(pose, index))
    return found


def is_right(pose, index):
    x, y, yaw = drive()[index]
    off_m = np.linalg.norm(A_BUILDING_PLAN.apply(pose.translation) - (x, y))
    off_rad = angle_between(A_BUILDING_PLAN.apply_yaw(pose.yaw), yaw)
    return bool(off_m < OFF_M and abs(off_rad) < OFF_RAD)


def broken(jump):
    """Return the drive whose odometry moves the robot besides, from one scan on."""
    scans = recorded()
    at = scans[AT][1]
    moved = at @ jump.as_matrix4() @ np.linalg.inv(at)
    after = [(points, moved @ T, stamp_ns) for points, T, stamp_ns in scans[AT:]]
    return [*scans[:AT], *after]


@pytest.mark.parametrize(
    'jump',
    [SE2.from_xy_yaw(0.0, 0.0, np.deg2rad(turn)) for turn in (-25.0, 12.0)]
    + [SE2.from_xy_yaw(-1.5, 1.0, 0.0)],
)
def test_no_pose_follows_a_frame_that_jumps_and_two_looks_bring_it_back(jump):
    found = published(broken(jump))
    assert found[AT - 1] is True
    assert False not in found[AT - 10 :]
    assert found[AT] is None
    assert found[AT + 3 * TICK_EVERY] is True
    assert set(found[AT + 3 * TICK_EVERY :]) == {True}


def test_the_same_drive_unbroken_is_never_interrupted():
    assert set(published(recorded())[AT - 10 :]) == {True}
