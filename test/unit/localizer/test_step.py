# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Has the odometry measured the motion between two scans, or has it broken?"""

import numpy as np
from planted_drive import SCAN_NS, drive, recorded, scan
import pytest

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2
from fpnet_core.localizer.odometry_monitor import KnownWalls, OdometryMonitor
from fpnet_core.submaps import SubmapBuilder

AT = 40


class Following:
    """What a localizer asks of every scan."""

    def __init__(self, scans, knows_all=True):
        self._knows_all = knows_all
        self.continuity, self.builder = OdometryMonitor(LocalizerConfig()), SubmapBuilder()
        self._walls = KnownWalls()
        self.breaks = [self.take(*each) for each in scans]

    def take(self, points, T_odom_sensor, stamp_ns):
        look = self.builder.look(points, T_odom_sensor)
        _, before = self.continuity.last or (0, T_odom_sensor)
        known = self._walls.around(before[:2, 3], self.builder.recent_xy, None, None)
        broken = self.continuity.check(
            stamp_ns, T_odom_sensor, look.body_xy, known, self._knows_all
        )
        self.builder.add(look, stamp_ns)
        self.continuity.go_on_from(stamp_ns, T_odom_sensor)
        return broken


def moved(x_m, y_m, yaw_rad, at=AT, points=None, later_s=0.0):
    """Return the scan ``at`` by an odometry that has moved the robot besides."""
    seen, T_odom_sensor, stamp_ns = recorded()[at]
    jump = SE2.from_xy_yaw(x_m, y_m, yaw_rad).as_matrix4()
    stamp_ns += round(later_s * 1e9)
    return seen if points is None else points, T_odom_sensor @ jump, stamp_ns


def test_a_drive_goes_on_through_doors_and_turns():
    assert not any(Following(recorded()).breaks)


@pytest.mark.parametrize('degrees', [-30.0, -10.0, 10.0, 20.0, 30.0, 90.0])
def test_a_frame_that_turns_is_found_where_it_is(degrees):
    following = Following(recorded()[:AT])
    points, T_odom_sensor, stamp_ns = moved(0.0, 0.0, np.deg2rad(degrees))
    broken = following.take(points, T_odom_sensor, stamp_ns)
    assert 'degrees' in broken.reason
    assert broken.probability > 0.99
    true = SE2.from_matrix4(recorded()[AT][1])
    found = broken.T_old_new @ SE2.from_matrix4(T_odom_sensor)
    assert np.hypot(*(found.translation - true.translation)) < 0.1
    assert abs(found.yaw - true.yaw) < np.deg2rad(2.0)


@pytest.mark.parametrize('shift', [(0.8, 0.0), (-1.2, 0.7), (3.0, -2.0)])
def test_a_frame_that_jumps_is_found_where_it_is(shift):
    following = Following(recorded()[:AT])
    points, T_odom_sensor, stamp_ns = moved(*shift, 0.0)
    broken = following.take(points, T_odom_sensor, stamp_ns)
    assert broken.probability > 0.99
    true = recorded()[AT][1][:2, 3]
    found = broken.T_old_new.apply(T_odom_sensor[:2, 3])
    assert np.hypot(*(found - true)) < 0.1


def test_a_robot_that_is_set_down_elsewhere_is_nowhere_near():
    (x, y, _), rng = drive()[5], np.random.default_rng(3)
    following = Following(recorded()[:AT])
    points = scan((x, y), 1.1, rng)
    broken = following.take(*moved(0.0, 0.0, 0.0, points=points))
    assert broken is not None
    assert broken.probability < 0.5


def test_an_odometry_that_was_blind_for_seconds_is_found_out():
    """It thinks that the robot has hardly moved."""
    scans = recorded()
    following = Following(scans[:AT])
    points, T_true, _ = scans[AT + 8]
    stamp_ns, T_odom_sensor = scans[AT - 1][2] + 5 * 10**9, scans[AT][1]
    broken = following.take(points, T_odom_sensor, stamp_ns)
    assert broken is not None
    if broken.T_old_new is not None:
        found = broken.T_old_new.apply(T_odom_sensor[:2, 3])
        assert np.hypot(*(found - T_true[:2, 3])) < 0.2


def test_people_who_hide_half_of_the_walls_break_nothing():
    following = Following(recorded()[:AT])
    points, T_odom_sensor, stamp_ns = recorded()[AT]
    crowd = points.copy()
    crowd[: len(points) // 2] *= 0.3
    assert following.take(crowd, T_odom_sensor, stamp_ns) is None


def test_seconds_without_a_scan_break_nothing_where_the_odometry_went_on():
    scans = recorded()
    following = Following(scans[:AT])
    points, T_odom_sensor, _ = scans[AT + 8]
    assert following.take(points, T_odom_sensor, scans[AT - 1][2] + 5 * 10**9) is None


def test_a_scanner_that_sees_nothing_leaves_it_to_the_motion():
    following = Following(recorded()[:AT])
    nothing = np.zeros((0, 3), np.float32)
    for k in range(3):
        points, T_odom_sensor, stamp_ns = moved(0.1 * k, 0.0, 0.0, points=nothing)
        assert following.take(points, T_odom_sensor, stamp_ns + k * SCAN_NS) is None
    points, T_odom_sensor, stamp_ns = moved(20.0, 0.0, 0.0, points=nothing)
    broken = following.take(points, T_odom_sensor, stamp_ns + 3 * SCAN_NS)
    assert 'jumped by 19.8' in broken.reason
