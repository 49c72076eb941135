# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar scanners in the frame of the base: mounted, merged, and without the robot's motion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fpnet_core.geometry.motion import carried
from fpnet_core.io.laser_sweeps import SweepMerger, mounted
from fpnet_core.io.laserscan import LaserPoints

MS = 1_000_000
START_NS = 1_700_000_000_000 * MS


def place(x, y, z, *, roll=0.0, pitch=0.0, yaw=0.0):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler('xyz', [roll, pitch, yaw]).as_matrix()
    T[:3, 3] = x, y, z
    return T


def laser(xy=((2.0, 1.0),), step_s=0.01):
    points = np.pad(np.array(xy, dtype=np.float32), ((0, 0), (0, 1)))
    return LaserPoints(points, step_s * np.arange(len(points)))


def sweep_at(offset_ms, count=3):
    points = laser(np.ones((count, 2)), step_s=1e-4)
    return mounted(points, START_NS + offset_ms * MS, np.eye(4), 'laser')


def test_carrying_by_a_whole_motion_undoes_it_and_by_none_changes_nothing():
    T = place(0.4, -0.1, 0.0, yaw=0.7)
    points = np.random.default_rng(5).normal(size=(6, 3))
    np.testing.assert_array_equal(carried(points, T, np.zeros(6)), points)
    undone = (points - T[:3, 3]) @ T[:3, :3]
    np.testing.assert_allclose(carried(points, T, -np.ones(6)), undone, atol=1e-12)
    halves = carried(carried(points, T, np.full(6, 0.5)), T, np.full(6, 0.5))
    np.testing.assert_allclose(halves, points @ T[:3, :3].T + T[:3, 3], atol=1e-12)
    assert carried(np.zeros((0, 3)), T, np.zeros(0)).shape == (0, 3)


def names(merger, arrivals):
    """How many points each merged sweep has, of scanners with 1, 10 and 100."""
    counts = {'a': 1, 'b': 10, 'c': 100}
    done = []
    for name, at_ms in arrivals:
        done += merger.add(name, sweep_at(at_ms, counts[name]))
    return [len(sweep.points) for sweep in done], [len(s.points) for s in merger.flush()]


@pytest.mark.parametrize(
    ('scanners', 'arrivals', 'complete', 'left'),
    [
        (1, [('a', 0), ('a', 100)], [1, 1], []),
        (2, [('a', 0), ('b', 20), ('a', 100), ('b', 120)], [11, 11], []),
        (2, [('a', 0), ('b', 20), ('b', 120), ('a', 100)], [11, 11], []),
        (2, [('a', 0), ('a', 100), ('a', 200)], [1, 1], [1]),  # b is dead
        (2, [('a', 0), ('b', 25), ('b', 50), ('b', 75), ('a', 100)], [11, 10, 11], []),
        (2, [('a', 0), ('b', 900), ('a', 1000), ('b', 1900)], [1, 11], [10]),  # clocks apart
        (3, [('a', 0), ('b', 10), ('a', 100), ('b', 110), ('c', 120)], [11, 111], []),
    ],
)
def test_one_sweep_of_each_scanner_and_none_lost(scanners, arrivals, complete, left):
    assert names(SweepMerger(scanners), arrivals) == (complete, left)
