# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar scanners in the frame of the base: mounted, merged, and without the robot's motion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry.motion import carried
from fpnet_core.io.laser_sweeps import LaserSweep, SweepMerger, merged, mounted
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


def test_a_mounted_scanner_s_points_lie_in_the_base_s_plane():
    sweep = mounted(laser(((2.0, 1.0),)), START_NS, place(0.3, -0.2, 0.4, yaw=np.pi / 2), 'front')
    np.testing.assert_allclose(sweep.points, [[0.3 - 1.0, -0.2 + 2.0, 0.0]], atol=1e-6)
    np.testing.assert_allclose(sweep.viewpoints, [[0.3, -0.2, 0.0]], atol=1e-6)


def test_upside_down_left_is_right():
    sweep = mounted(laser(((2.0, 1.0),)), START_NS, place(0.0, 0.0, 0.4, roll=np.pi), 'under')
    np.testing.assert_allclose(sweep.points, [[2.0, -1.0, 0.0]], atol=1e-6)


@pytest.mark.parametrize('roll', [0.0, np.pi])
def test_a_tilted_scanner_is_refused_with_its_angle(roll):
    small, large = np.radians(2.5), np.radians(8.0)
    mounted(laser(), START_NS, place(0.0, 0.0, 0.2, roll=roll, pitch=small), 'front')
    with pytest.raises(
        CloudFormatError, match=r"'front' is tilted by 8.0 degrees; its beam would"
    ):
        mounted(laser(), START_NS, place(0.0, 0.0, 0.2, roll=roll, pitch=large), 'front')


def test_the_stamp_of_a_sweep_is_that_of_its_last_return():
    sweep = mounted(laser(np.ones((5, 2))), START_NS, np.eye(4), 'laser')
    assert (sweep.first_ns, sweep.stamp_ns) == (START_NS, START_NS + 40 * MS)
    np.testing.assert_allclose(sweep.time_s, 0.01 * np.arange(5))
    empty = mounted(laser(np.zeros((0, 2))), START_NS, np.eye(4), 'laser')
    assert (empty.first_ns, empty.stamp_ns) == (START_NS, START_NS)


def test_merged_sweeps_keep_the_time_and_viewpoint_of_every_point():
    front = mounted(laser(np.ones((2, 2))), START_NS, place(0.3, 0.0, 0.2), 'front')
    rear = mounted(laser(np.ones((3, 2))), START_NS + 5 * MS, place(-0.3, 0.0, 0.2), 'rear')
    both = merged([front, rear])
    np.testing.assert_allclose(both.time_s, [0.0, 0.01, 0.005, 0.015, 0.025])
    np.testing.assert_allclose(both.viewpoints[:, 0], [0.3, 0.3, -0.3, -0.3, -0.3], atol=1e-6)
    assert both.stamp_ns == START_NS + 25 * MS


def test_a_moving_robot_s_sweep_comes_out_as_from_its_end():
    """Rays at 20 instants from a base that drives and turns; a wall is straight afterwards."""
    rng = np.random.default_rng(4)
    world = np.stack([np.full(20, 3.0), rng.uniform(-2.0, 2.0, 20), np.zeros(20)], axis=1)
    step = place(0.01, 0.002, 0.0, yaw=0.004)
    poses = [np.linalg.matrix_power(step, k) for k in range(20)]
    seen = np.array([(p - T[:3, 3]) @ T[:3, :3] for p, T in zip(world, poses, strict=True)])
    origin = np.zeros((20, 3), dtype=np.float32)
    stamps = START_NS + np.arange(20) * 4 * MS
    sweep = LaserSweep(seen.astype(np.float32), stamps, origin, int(stamps[-1]))
    still = sweep.without_motion(np.linalg.inv(poses[0]) @ poses[-1])
    T = poses[-1]
    assert np.ptp((seen @ T[:3, :3].T + T[:3, 3])[:, 0]) > 0.1
    np.testing.assert_allclose(still.points @ T[:3, :3].T + T[:3, 3], world, atol=1e-5)
    begins = still.viewpoints @ T[:3, :3].T + T[:3, 3]
    np.testing.assert_allclose(begins, [pose[:3, 3] for pose in poses], atol=1e-5)
    assert still.stamp_ns == sweep.stamp_ns


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
