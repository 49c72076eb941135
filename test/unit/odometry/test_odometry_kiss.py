# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""KISS-ICP behind its guard: planted motion comes back, bad sweeps leave the state alone."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fpnet_core.config import OdometryConfig
from fpnet_core.errors import CloudFormatError, OdometryError
from fpnet_core.io.scans import Scan
from fpnet_core.odometry.kiss import STALE_BEFORE_RESTART, KissOdometry
from fpnet_core.odometry.registration import MIN_POINTS

CONFIG = OdometryConfig(max_range=20.0, min_range=0.5, voxel_size=0.2)


def room(rng, count=6000):
    """Points on the walls, floor and ceiling of a room of 9 x 6 x 3 m, off centre."""
    size = np.array([9.0, 6.0, 3.0])
    points = rng.uniform(0.0, size, (count, 3))
    face = rng.integers(0, 3, count)
    side = rng.integers(0, 2, count)
    points[np.arange(count), face] = side * size[face]
    return points - [3.0, 2.0, 1.2]


def motion(k):
    """Pose of the sensor after k sweeps: 8 cm ahead, 1.5 cm to the left, 0.02 rad each."""
    c, s = np.cos(0.02 * k), np.sin(0.02 * k)
    T = np.eye(4)
    T[:2, :2] = [[c, -s], [s, c]]
    T[:2, 3] = 0.08 * k, 0.015 * k
    return T


def seen_from(T, points):
    return (points - T[:3, 3]) @ T[:3, :3]


def test_planted_motion_is_recovered():
    rng = np.random.default_rng(7)
    odometry = KissOdometry(CONFIG)
    for k in range(12):
        sweep = odometry.register_scan(Scan(k, seen_from(motion(k), room(rng))))
    np.testing.assert_allclose(sweep.T_odom_sensor, motion(11), atol=0.03)


def rings(x, rng, deviation_m):
    """A sweep of 16 beams in a bare hall of 14 x 6 x 2.7 m, ``x`` [m] along its middle."""
    elevation, azimuth = np.deg2rad(np.linspace(-15.0, 15.0, 16)), np.deg2rad(np.arange(900) * 0.4)
    up, turn = (angle.ravel() for angle in np.meshgrid(elevation, azimuth))
    ray = np.stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)], axis=1)
    ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
    sensor = np.array([x, 3.0, 0.6])
    reach = (np.where(ray > 0.0, [14.0, 6.0, 2.7], 0.0) - sensor) / ray
    return ray * (reach.min(axis=1) + rng.normal(0.0, deviation_m, len(ray)))[:, None]


def corridor(x, rng, deviation_m):
    """A planar sweep of 720 rays in a bare corridor of 14 x 2 m, ``x`` [m] along it."""
    turn = np.deg2rad(np.arange(720) * 0.5 + 0.01)
    ray = np.stack([np.cos(turn), np.sin(turn), np.zeros(720)], axis=1)
    reach = (np.where(ray[:, :2] > 0.0, [14.0, 2.0], 0.0) - [x, 1.1]) / ray[:, :2]
    return ray * (reach.min(axis=1) + rng.normal(0.0, deviation_m, 720))[:, None]


# With KISS-ICP's choice of points the corridor is 0.4 m too short, the hall 0 to 1.2
# of 8 m, and 2 to 4 m where ranges are exact; with all points of a sweep at once 6.5 m.
@pytest.mark.parametrize('deviation_m', [0.0, 0.015])
# Without times all of it has to be right as well: simulators give none.
@pytest.mark.parametrize('has_times', [True, False])
@pytest.mark.parametrize(('seen', 'tolerance_m'), [(rings, 0.15), (corridor, 0.25)])
def test_bare_walls_and_rings_do_not_hold_the_robot_in_its_place(
    seen, tolerance_m, has_times, deviation_m
):
    rng, odometry = np.random.default_rng(3), KissOdometry(OdometryConfig())
    path = np.arange(2.0, 10.0, 0.07)
    for x in path:
        sweep = seen(x, rng, deviation_m)
        times = np.linspace(0.0, 1e-6, len(sweep)) if has_times else None  # all seen at once
        scan = Scan(round(x / 0.07) * 100_000_000, sweep, times)
        T = odometry.register_scan(scan).T_odom_sensor
    np.testing.assert_allclose(T[:3, 3], [path[-1] - path[0], 0.0, 0.0], atol=tolerance_m)
    assert Rotation.from_matrix(T[:3, :3]).magnitude() < np.deg2rad(2.0)


def turn_error_deg(config, turn_rad):
    """Largest error of the heading while a planar scanner turns in place in a cluttered room."""
    rng = np.random.default_rng(13)
    boxes = rng.uniform([-3.0, -2.0], [6.0, 4.0], (12, 2))
    outline = [np.array([x, y]) for x in (0.0, 0.3) for y in np.linspace(0.0, 0.4, 9)]
    walls = np.vstack([room(rng, 1500)[:, :2], *(boxes + corner for corner in outline)])
    world = np.pad(walls, ((0, 0), (0, 1)))
    odometry, errors = KissOdometry(config), []
    for k in range(40):
        c, s = np.cos(turn_rad * k), np.sin(turn_rad * k)
        T = np.eye(4)
        T[:2, :2] = [[c, -s], [s, c]]
        seen = seen_from(T, world[rng.random(len(world)) < 0.5])
        seen += rng.normal(0.0, [0.01, 0.01, 0.0], seen.shape)
        found = odometry.register_scan(Scan(k, seen))
        apart = T[:2, :2].T @ found.T_odom_sensor[:2, :2]
        errors.append(abs(np.degrees(np.arctan2(apart[1, 0], apart[0, 0]))))
    return max(errors)


def test_flat_sweeps_get_the_voxels_of_planar_scanners():
    coarse = OdometryConfig(voxel_size=0.4, planar_voxel_size=0.4)
    fine = OdometryConfig(voxel_size=0.4, planar_voxel_size=0.1)
    assert turn_error_deg(fine, 0.05) < 0.7 * turn_error_deg(coarse, 0.05)


def distance_to_room(points):
    """Distance of each world point to the nearest wall, floor or ceiling."""
    low, high = np.array([-3.0, -2.0, -1.2]), np.array([6.0, 4.0, 1.8])
    return np.minimum(np.abs(points - low), np.abs(points - high)).min(axis=1)


def test_points_come_back_as_seen_from_where_the_sweep_ends():
    """The sensor moves during the sweep: walls are smeared, and sharp again afterwards."""
    rng = np.random.default_rng(8)
    odometry = KissOdometry(CONFIG)
    for k in range(6):
        world = room(rng, 3000)
        time = rng.uniform(0.0, 0.1, len(world))
        at = [motion(3 * (k + t / 0.1)) for t in time]
        skewed = np.array([seen_from(T, p[None])[0] for T, p in zip(at, world, strict=True)])
        sweep = odometry.register_scan(Scan((k + 1) * 100_000_000, skewed, time))
    end = motion(18)
    smeared = distance_to_room(skewed @ end[:3, :3].T + end[:3, 3]).mean()
    sharp = distance_to_room(sweep.points @ end[:3, :3].T + end[:3, 3]).mean()
    assert smeared > 0.04
    assert sharp < 0.4 * smeared


def test_a_robot_that_turns_from_the_beginning_does_not_keep_the_turn_of_its_first_sweep():
    """Its walls are bent by 3.4 degrees, and the map is not."""
    rng, odometry = np.random.default_rng(16), KissOdometry(CONFIG)
    for k in range(8):
        world = room(rng, 3000)
        time = np.sort(rng.uniform(0.0, 0.1, len(world)))
        at = [motion(3 * (k + t / 0.1)) for t in time]
        skewed = np.array([seen_from(T, p[None])[0] for T, p in zip(at, world, strict=True)])
        sweep = odometry.register_scan(Scan((k + 1) * 100_000_000, skewed, time))
    off = np.linalg.inv(sweep.T_odom_sensor) @ np.linalg.inv(motion(3)) @ motion(24)
    assert np.hypot(*off[:2, 3]) < 0.06
    assert abs(np.degrees(np.arctan2(off[1, 0], off[0, 0]))) < 0.5


def test_a_sweep_that_sees_nothing_in_range_at_its_end_is_of_its_end_all_the_same():
    """The last third of every sweep looks into the open; the others are brought to the stamp."""
    rng = np.random.default_rng(14)
    odometry = KissOdometry(CONFIG)
    for k in range(6):
        world = room(rng, 3000)
        time = np.sort(rng.uniform(0.0, 0.1, len(world)))
        time[-1] = 0.1
        at = [motion(3 * (k + t / 0.1)) for t in time]
        skewed = np.array([seen_from(T, p[None])[0] for T, p in zip(at, world, strict=True)])
        is_seen = time < 0.066
        skewed[~is_seen] *= 1e3
        sweep = odometry.register_scan(Scan((k + 1) * 100_000_000, skewed, time))
    expected = seen_from(motion(18), world[is_seen])
    expected = expected[np.linalg.norm(skewed[is_seen], axis=1) > CONFIG.min_range]
    assert len(sweep.points) == len(expected)
    assert np.abs(sweep.points - expected).mean() < 0.015


def test_times_without_spread_register_without_deskewing():
    """KISS-ICP aborts the whole process on such times; the second sweep is what does it."""
    rng = np.random.default_rng(9)
    odometry = KissOdometry(CONFIG)
    for k in range(3):
        points = room(rng)
        sweep = odometry.register_scan(Scan(k, points, np.full(len(points), 3.5)))
    assert np.isfinite(sweep.T_odom_sensor).all()


@pytest.mark.parametrize(
    ('points', 'time_s', 'message'),
    [
        (np.zeros((0, 3)), None, '0 of 0 points'),
        (np.full((500, 3), np.nan), None, '0 of 500'),
        (np.full((500, 3), 1e6), None, '0 of 500'),
        (np.zeros((500, 3)), None, '0 of 500'),
        (np.ones((MIN_POINTS - 1, 3)), None, 'expected at least'),
        (np.ones((500, 2)), None, r'expected points \(P, 3\)'),
        (np.ones((500, 3)), np.zeros(499), '500 points but times'),
    ],
)
def test_bad_sweeps_are_refused_and_change_nothing(points, time_s, message):
    rng = np.random.default_rng(10)
    guarded, plain = KissOdometry(CONFIG), KissOdometry(CONFIG)
    scans = [Scan(k, seen_from(motion(k), room(rng))) for k in range(3)]
    for scan in scans[:2]:
        guarded.register_scan(scan)
        plain.register_scan(scan)
    with pytest.raises(CloudFormatError, match=message):
        guarded.register_scan(Scan(2, points, time_s))
    np.testing.assert_allclose(
        guarded.register_scan(scans[2]).T_odom_sensor,
        plain.register_scan(scans[2]).T_odom_sensor,
        atol=1e-6,
    )


def test_poses_are_level_where_a_sensor_hangs_upside_down_and_askew():
    """They begin where the sensor is on the robot, and move as the robot does."""
    T_base_sensor = np.eye(4)
    T_base_sensor[:3, :3] = Rotation.from_euler('xyz', [3.1, 0.2, 0.7]).as_matrix()
    T_base_sensor[:3, 3] = 0.2, -0.1, 0.9
    rng, odometry = np.random.default_rng(15), KissOdometry(CONFIG)
    for k in range(8):
        points = seen_from(motion(k) @ T_base_sensor, room(rng)).astype(np.float32)
        sweep = odometry.register_scan(Scan(1000 + k, points, T_base_sensor=T_base_sensor))
        if k == 0:
            np.testing.assert_allclose(sweep.T_odom_sensor, T_base_sensor, atol=1e-9)
    np.testing.assert_allclose(sweep.T_odom_sensor, motion(7) @ T_base_sensor, atol=0.03)


def test_old_sweeps_are_refused_until_they_are_a_clock_that_went_back():
    """As the node does, so that a looping recording gives the same answer offline."""
    rng, odometry = np.random.default_rng(11), KissOdometry(CONFIG)

    def register(k, stamp_ns):
        return odometry.register_scan(Scan(stamp_ns, seen_from(motion(k), room(rng))))

    for k in range(4):
        T_odom_sensor = register(k, 1000 + k).T_odom_sensor
    moved = T_odom_sensor
    for _ in range(STALE_BEFORE_RESTART - 1):
        with pytest.raises(OdometryError, match='not newer'):
            register(0, 1003)
    T_odom_sensor = register(4, 1004).T_odom_sensor  # the refused ones left no trace
    np.testing.assert_allclose(T_odom_sensor, motion(4), atol=0.03)
    assert not np.allclose(T_odom_sensor, moved, atol=0.03)
    for _ in range(STALE_BEFORE_RESTART - 1):
        with pytest.raises(OdometryError):
            register(0, 5)
    np.testing.assert_array_equal(register(0, 5).T_odom_sensor, np.eye(4))
