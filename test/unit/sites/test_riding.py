# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lifts and stairs are noticed, ramps and drift are not; a ride ends a claim and begins anew."""

import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import SCAN_NS, drive, recorded
from planted_site import MOVED, EvenMatcher, laid_elsewhere
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.errors import HintError
from fpnet_core.geometry import SE2
from fpnet_core.sites import Link, LinkKind, Site, Storey
from fpnet_core.sites.ride import RideWatch
from fpnet_core.sites.site_localizer import SiteLocalizer, continued
from fpnet_core.types import Status


def rides(path, period_ns=SCAN_NS):
    """Rides that a path of (way, height) leads to."""
    watch, found = RideWatch(), []
    for index, (x, z) in enumerate(path):
        T = np.eye(4)
        T[0, 3], T[2, 3] = x, z
        found.append(watch.follow(index * period_ns, T))
    return [ride for ride in found if ride is not None]


def level(x0, metres, z=0.0, step=0.1):
    return [(x0 + step * k, z) for k in range(round(metres / step))]


def test_a_lift_begins_and_ends_one_ride():
    up = [(5.0, 0.1 * k) for k in range(36)]
    begun, over = rides(level(0.0, 5.0) + up + [(5.0, 3.5)] * 20 + level(5.0, 4.0, 3.5))
    assert not begun.is_over
    assert over.is_over
    assert over.rise_m == pytest.approx(3.5, abs=0.25)


def test_stairs_down_are_a_ride():
    stairs = [(5.0 + 0.1 * k, -0.06 * k) for k in range(56)]
    begun, over = rides(level(0.0, 5.0) + stairs + level(10.5, 8.0, -3.3))
    assert begun.rise_m < 0.0
    assert over.rise_m == pytest.approx(-3.3, abs=0.25)


@pytest.mark.parametrize('slope', [0.05, 0.125, -0.2])
def test_drift_and_ramps_are_none(slope):
    assert rides([(0.1 * k, slope * 0.1 * k) for k in range(400)]) == []


def test_odometry_that_jumps_is_none():
    assert rides(level(0.0, 5.0) + level(5.0, 5.0, 4.0)) == []


def reading(grid):
    pixels = np.zeros((4, 4, 3), np.uint8)
    stated = DrawingScale(0.05, 0.05, 0.05, ScaleSource.STATED)
    return Reading(grid, stated, np.eye(3), 'drawn', Drawing(pixels, 'plan.yaml', 'map_server'))


def site():
    low = Storey('low', reading(plan_grid()), level=0, elevation_m=0.0)
    high = Storey('high', reading(laid_elsewhere(plan_grid())), level=1, elevation_m=3.5)
    lift = Link('A', LinkKind.LIFT, {'low': np.array([0.0, 0.0]), 'high': np.array([1.0, 1.0])})
    return Site('tower', (low, high), (lift,))


def driven(localizer, scans, height_m=0.0, start_ns=0):
    outputs = []
    for index, (points, T, stamp_ns) in enumerate(scans):
        raised = np.array(T)
        raised[2, 3] += height_m
        localizer.add_scan(points, raised, start_ns + stamp_ns)
        if index % 5 == 4:
            outputs.append(localizer.update(start_ns + stamp_ns))
    return outputs


@pytest.fixture(scope='module')
def ridden():
    """Outputs before, in and after a ride from low to high, on storeys that look the same."""
    localizer = SiteLocalizer(FpnetConfig(), EvenMatcher())
    localizer.set_site(site())
    localizer.tell_level('low')
    before = driven(localizer, recorded())
    points, T, stamp_ns = recorded()[-1]
    for k in range(1, 36):
        raised = np.array(T)
        raised[2, 3] = 0.1 * k
        localizer.add_scan(points, raised, stamp_ns + k * SCAN_NS)
        if k == 20:
            inside = localizer.update(stamp_ns + k * SCAN_NS)
    top = np.array(T)
    top[2, 3] = 3.5
    for k in range(36, 50):
        localizer.add_scan(points, top, stamp_ns + k * SCAN_NS)
    stopped = localizer.output
    back = [(p, T_there, t) for p, T_there, t in recorded()[::-1]]
    times = [t for _, _, t in recorded()]
    back = [(p, T_there, t) for (p, T_there, _), t in zip(back, times, strict=True)]
    after = driven(localizer, back, 3.5, stamp_ns + 50 * SCAN_NS)
    return before, inside, stopped, after


def test_two_claims_and_nothing_between(ridden):
    before, inside, stopped, after = ridden
    assert before[-1].status is Status.LOCALIZED
    assert before[-1].storey == 'low'
    assert inside.status is not Status.LOCALIZED
    assert stopped.reason.startswith('new submap: the robot has moved up by 3.')
    claims = {output.storey for output in after if output.status is Status.LOCALIZED}
    assert claims == {'high'}


def test_a_word_on_another_level_ends_the_claim(ridden):
    localizer = SiteLocalizer(FpnetConfig(), EvenMatcher())
    with pytest.raises(HintError, match='no site'):
        localizer.tell_level('low')
    localizer.set_site(site())
    localizer.tell_level('low')
    claimed = driven(localizer, recorded())[-1]
    assert claimed.storey == 'low'
    localizer.tell_level('0')  # where it is
    assert localizer.output is claimed
    with pytest.raises(HintError, match='an elevation of nan m is not valid'):
        localizer.tell_elevation(float('nan'))
    assert localizer.output is claimed
    localizer.tell_elevation(3.4)
    assert localizer.output.status is Status.WAITING
    assert 'the robot is at 3.4 m now' in localizer.output.reason


def test_a_lift_that_shuts_ends_the_claim_and_a_word_inside_counts():
    x, y, _ = drive()[-1]
    at = A_BUILDING_PLAN.inv().apply(np.array([x, y]))
    lift = Link('A', LinkKind.LIFT, {'low': at, 'high': MOVED.apply(at)})
    localizer = SiteLocalizer(FpnetConfig(), EvenMatcher())
    localizer.set_site(Site('tower', site().storeys, (lift,)))
    localizer.tell_level('low')
    assert driven(localizer, recorded())[-1].storey == 'low'
    points, T, stamp_ns = recorded()[-1]
    cabin = (points / np.linalg.norm(points, axis=1)[:, None]).astype(np.float32)
    for k in range(1, 11):
        localizer.add_scan(cabin, T, stamp_ns + k * SCAN_NS)
    assert localizer.output.status is Status.WAITING
    assert localizer.output.reason == 'new submap: the robot is in a closed lift'
    localizer.tell_level('high')
    localizer.add_scan(points, T, stamp_ns + 11 * SCAN_NS)
    assert localizer.output.reason == 'new submap: the lift has opened'
    back = [(p, T_there, t) for (p, T_there, _), (_, _, t) in
            zip(recorded()[::-1], recorded(), strict=True)]  # fmt: skip
    after = driven(localizer, back, start_ns=stamp_ns + 12 * SCAN_NS)
    claims = {output.storey for output in after if output.status is Status.LOCALIZED}
    assert claims == {'high'}


def test_plans_that_lie_on_each_other_carry_a_placement_on():
    low, high = site().storeys
    T_low, T_high = SE2.from_xy_yaw(1.0, 2.0, 0.3), SE2.from_xy_yaw(-4.0, 0.5, 1.1)
    placed = Site(
        'tower',
        (
            Storey('low', low.plan, T_site_plan=T_low),
            Storey('high', high.plan, T_site_plan=T_high),
        ),
    )
    A_low_odom = SE2.from_xy_yaw(3.0, 4.0, -0.7)
    starts = continued(placed, 'low', A_low_odom)
    np.testing.assert_allclose(starts['low'].matrix, A_low_odom.matrix, atol=1e-12)
    np.testing.assert_allclose(
        (T_high @ starts['high']).matrix, (T_low @ A_low_odom).matrix, atol=1e-12
    )
    assert set(continued(site(), 'low', A_low_odom)) == {'low'}  # where nobody gets out
