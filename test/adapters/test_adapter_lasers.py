# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""LaserScan and MultiEchoLaserScan of every library, to points; impossible ones say why."""

from array import array

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

pytest.importorskip('rclpy')

from sensor_msgs.msg import LaserEcho, LaserScan, MultiEchoLaserScan

from fpnet_core.errors import CloudFormatError
from msg_adapters.lasers import laser_from_msg

NAN, INF = float('nan'), float('inf')


def _scan(ranges, **changes) -> LaserScan:
    return LaserScan(
        **{
            'angle_min': -0.5,
            'angle_increment': 0.125,
            'time_increment': 0.001,
            'range_min': 0.1,
            'range_max': 10.0,
            'ranges': array('f', ranges),
            **changes,
        }
    )


def _multi(echoes, **changes) -> MultiEchoLaserScan:
    plain = _scan([], **changes)
    return MultiEchoLaserScan(
        angle_min=plain.angle_min,
        angle_increment=plain.angle_increment,
        time_increment=plain.time_increment,
        range_min=plain.range_min,
        range_max=plain.range_max,
        ranges=[LaserEcho(echoes=array('f', own)) for own in echoes],
    )


def test_ranges_become_points_with_the_time_of_their_rays(received):
    laser = laser_from_msg(received(_scan([1.0, 2.0, 3.0, 4.0])))
    angles = np.array([-0.5, -0.375, -0.25, -0.125])
    expected = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    expected *= np.array([1.0, 2.0, 3.0, 4.0])[:, None]
    np.testing.assert_allclose(laser.points, expected, atol=1e-6)
    np.testing.assert_allclose(laser.time_s, [0.0, 0.001, 0.002, 0.003], atol=1e-9)
    assert laser.points.dtype == np.float32


def test_rays_without_a_valid_range_are_dropped_and_their_time_goes_with_them(received):
    # 10.0 is range_max, which many drivers write for no return.
    ranges = [NAN, 0.05, 2.0, INF, -INF, 10.5, -1.0, 10.0, 9.5, 0.0]
    laser = laser_from_msg(received(_scan(ranges)))
    np.testing.assert_allclose(np.linalg.norm(laser.points, axis=1), [2.0, 9.5], rtol=1e-6)
    np.testing.assert_allclose(laser.time_s, [0.002, 0.008], atol=1e-9)


def test_the_nearest_valid_echo_counts(received):
    echoes = [[0.05, 3.0, 7.0], [], [NAN, INF], [6.0, 4.0], [12.0]]
    laser = laser_from_msg(received(_multi(echoes)))
    np.testing.assert_allclose(np.linalg.norm(laser.points, axis=1), [3.0, 4.0], rtol=1e-6)
    np.testing.assert_allclose(laser.time_s, [0.0, 0.003], atol=1e-9)


def test_clockwise_rays_and_no_time_between_them(received):
    msg = _scan([1.0, 1.0], angle_min=0.5, angle_increment=-1.0, time_increment=0.0)
    laser = laser_from_msg(received(msg))
    np.testing.assert_allclose(np.arctan2(*laser.points[:, 1::-1].T), [0.5, -0.5], atol=1e-6)
    np.testing.assert_array_equal(laser.time_s, [0.0, 0.0])


@pytest.mark.parametrize('msg', [_scan([]), _scan([INF] * 3), _multi([]), _multi([[], []])])
def test_a_scan_that_saw_nothing_has_no_points(received, msg):
    laser = laser_from_msg(received(msg))
    assert laser.points.shape == (0, 3)
    assert laser.time_s.shape == (0,)


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'range_max': 0.0}, 'range_max 0.0 m is not above range_min'),
        ({'range_min': 12.0}, 'range_max 10.0 m is not above range_min 12.0'),
        ({'range_min': NAN}, 'is not above'),
        ({'range_max': NAN}, 'is not above'),
        ({'angle_min': NAN}, 'expected finite radians'),
        ({'angle_increment': INF}, 'expected finite radians'),
        ({'angle_increment': 0.0}, 'angle_increment is 0 for 40 rays'),
        ({'angle_increment': 9.0}, '55.9 turns; expected radians'),
        ({'time_increment': NAN}, 'time_increment nan s'),
        ({'time_increment': 0.1}, 'expected seconds, and a sweep of at most 2 s'),
    ],
)
def test_impossible_scans_say_what_is_wrong(received, changes, message):
    with pytest.raises(CloudFormatError, match=message):
        laser_from_msg(received(_scan([1.0] * 40, **changes)))
    with pytest.raises(CloudFormatError, match=message):
        laser_from_msg(received(_multi([[1.0]] * 40, **changes)))


@settings(deadline=None)
@given(
    ranges=st.lists(st.floats(width=32), max_size=30),
    first=st.floats(-7.0, 7.0),
    step=st.floats(0.001, 0.2),
    low=st.floats(-1.0, 2.0),
    high=st.floats(2.5, 100.0, width=32),
)
def test_every_point_is_a_valid_range_at_its_ray_s_angle(ranges, first, step, low, high):
    changes = {'angle_min': first, 'angle_increment': step, 'range_min': low, 'range_max': high}
    msg = _scan(ranges, **changes)
    laser = laser_from_msg(msg)
    seen = np.array(msg.ranges, dtype=np.float64)
    is_valid = (seen >= msg.range_min) & (seen < msg.range_max) & (seen > 0.0)
    assert len(laser.points) == np.count_nonzero(is_valid)
    assert np.isfinite(laser.points).all()
    assert not laser.points[:, 2].any()
    ray = np.round(laser.time_s / msg.time_increment).astype(int)
    assert is_valid[ray].all()
    own = seen[ray]
    angle = msg.angle_min + ray * msg.angle_increment
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    np.testing.assert_allclose(laser.points[:, :2], own[:, None] * direction, rtol=1e-5, atol=1e-4)
