# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What was seen last is kept apart from what the whole submap shows."""

import numpy as np

from fpnet_core.submaps.recent import RecentReturns, is_last_seen


def wall(x):
    return np.stack([np.full(200, x), np.linspace(0.0, 4.0, 200)], axis=-1)


def seen(recent, returns, xy, yaw):
    recent.add(returns, np.ones(len(returns), dtype=bool), xy, yaw)


def test_only_the_last_metres_of_the_path_are_kept():
    recent = RecentReturns()
    for place in np.arange(0.0, 30.0, 0.1):
        seen(recent, wall(place + 2.0), np.array([place, 0.0]), 0.0)
    points = recent.points()
    assert 4.0 < np.ptp(points[:, 0]) < 9.0
    assert points[:, 0].max() > 31.0


def test_a_robot_that_stands_keeps_what_it_saw_on_the_way():
    recent = RecentReturns()
    seen(recent, wall(1.0), np.zeros(2), 0.0)
    for _ in range(100):
        seen(recent, wall(2.0), np.array([1.0, 0.0]), 0.0)
    assert set(np.unique(recent.points()[:, 0])) == {1.0, 2.0}


def test_walls_are_what_nothing_was_seen_behind():
    """A cabinet two metres away, over which the wall is seen; beside it the wall alone."""
    cabinet, far = wall(2.0)[:50], wall(5.0)
    is_wall = is_last_seen(np.concatenate([cabinet, far]))
    assert not is_wall[:50].any()
    assert is_wall[50:].all()
    recent = RecentReturns()
    recent.add(np.concatenate([cabinet, far]), is_wall, np.zeros(2), 0.0)
    assert len(recent.newest()) == 250
    np.testing.assert_array_equal(recent.newest_walls(), far)


def test_a_wall_at_a_slant_is_a_wall_all_along():
    assert is_last_seen(np.stack([np.linspace(0.2, 8.0, 400), np.full(400, 1.0)], axis=-1)).all()
    assert is_last_seen(np.zeros((0, 2))).shape == (0,)
