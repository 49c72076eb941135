# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What was seen last is kept apart from what the whole submap shows."""

import numpy as np

from fpnet_core.submaps.recent import RecentReturns


def wall(x):
    return np.stack([np.full(200, x), np.linspace(0.0, 4.0, 200)], axis=-1)


def test_nothing_seen_gives_no_points():
    assert RecentReturns().points().shape == (0, 2)


def test_only_the_last_metres_of_the_path_are_kept():
    recent = RecentReturns()
    for place in np.arange(0.0, 30.0, 0.1):
        recent.add(wall(place + 2.0), np.array([place, 0.0]), 0.0)
    seen = recent.points()
    assert 4.0 < np.ptp(seen[:, 0]) < 9.0
    assert seen[:, 0].max() > 31.0


def test_a_robot_that_stands_keeps_what_it_saw_on_the_way():
    recent = RecentReturns()
    recent.add(wall(1.0), np.zeros(2), 0.0)
    for _ in range(100):
        recent.add(wall(2.0), np.array([1.0, 0.0]), 0.0)
    assert set(np.unique(recent.points()[:, 0])) == {1.0, 2.0}


def test_turning_in_place_counts_as_motion():
    recent = RecentReturns()
    for yaw in (0.0, 0.1, 0.5):
        recent.add(wall(10.0 * yaw), np.zeros(2), yaw)
    assert set(np.unique(recent.points()[:, 0])) == {0.0, 5.0}


def test_points_are_even_however_often_a_wall_is_seen():
    recent = RecentReturns()
    for place in np.arange(0.0, 5.0, 0.3):
        recent.add(wall(2.0), np.array([0.0, place]), 0.0)
    assert len(recent.points()) <= 41
