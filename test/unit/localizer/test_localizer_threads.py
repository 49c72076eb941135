# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calls that come while a tick is at work in another thread."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Event

import numpy as np
from planted import plan_grid
from planted_drive import SCAN_NS, recorded
import pytest

from fpnet_core.config import load_config
from fpnet_core.geometry import SE2
from fpnet_core.localizer import Localizer
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.matches import MatchResult
from fpnet_core.types import Status

WAIT_S = 60.0


class StoppingMatcher:
    """Holds every pair for equally likely; can be told to stop a tick in the middle."""

    def __init__(self):
        self.reached, self.go_on = Event(), Event()
        self.go_on.set()

    def match(self, plan, sub, explored_area_m2):
        self.reached.set()
        assert self.go_on.wait(WAIT_S)
        return MatchResult(np.zeros((0, 2)), np.zeros(0), np.full((len(plan), len(sub)), 0.01))


@pytest.fixture
def stopped():
    """A localizer that would claim with the tick that runs, and that tick, held in the middle."""
    matcher = StoppingMatcher()
    localizer = Localizer(load_config(None, {'localizer.search_every_updates': 1}), matcher)
    localizer.set_plan(plan_grid())
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % 20 == 19:  # every one of them searches
            localizer.update(stamp_ns)
    assert localizer.output.status is Status.LOCALIZED
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    localizer.add_scan(points, T_odom_sensor, stamp_ns + SCAN_NS)
    matcher.reached.clear()
    matcher.go_on.clear()
    with ThreadPoolExecutor(1) as pool:
        update = pool.submit(localizer.update, stamp_ns + SCAN_NS)
        assert matcher.reached.wait(WAIT_S)
        try:
            yield localizer, matcher, update
        finally:
            matcher.go_on.set()


def finish(matcher, update):
    matcher.go_on.set()
    return update.result(WAIT_S)


def test_scans_are_added_and_poses_asked_for_in_the_meantime(stopped):
    localizer, matcher, update = stopped
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    localizer.add_scan(points, T_odom_sensor, stamp_ns + 2 * SCAN_NS)
    assert localizer.output.pose(T_odom_sensor) is not None
    assert not update.done()
    output = finish(matcher, update)
    assert output.status is Status.LOCALIZED
    assert output.submap.stamp_ns == stamp_ns + SCAN_NS  # of what it was started with
    assert localizer.update(0).submap.stamp_ns == stamp_ns + 2 * SCAN_NS


@pytest.mark.parametrize(
    'overtake',
    [lambda localizer: localizer.set_plan(plan_grid()), Localizer.reset, Localizer.relocalize],
)
def test_a_tick_that_was_overtaken_claims_nothing(stopped, overtake):
    localizer, matcher, update = stopped
    overtake(localizer)
    assert localizer.output.status is Status.WAITING
    assert finish(matcher, update).status is Status.WAITING
    assert localizer.output.status is Status.WAITING
    assert len(localizer.output.estimates) == 0


def test_a_new_odometry_frame_overtakes_a_tick(stopped):
    localizer, matcher, update = stopped
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    far = T_odom_sensor.copy()
    far[0, 3] += 100.0
    localizer.add_scan(points, far, stamp_ns + 2 * SCAN_NS)
    assert finish(matcher, update).status is Status.WAITING
    assert localizer.output.pose(far) is None


def test_a_plan_that_comes_in_the_middle_of_a_tick_is_the_next_ones(stopped):
    localizer, matcher, update = stopped
    grid = plan_grid()
    moved = replace(grid, T_frame_grid=SE2.from_xy_yaw(100.0, 0.0, 0.0) @ grid.T_frame_grid)
    old = localizer.snapshot
    localizer.set_plan(moved)
    new = localizer.snapshot
    assert (old.output.status, new.output.status) == (Status.LOCALIZED, Status.WAITING)
    assert (old.plan.given is moved, new.plan.given is moved) == (False, True)
    finish(matcher, update)
    assert localizer.snapshot is new
    statuses = []
    for number in range(2, 6):  # scans have gone on, and the old tick's count for nothing
        points, T_odom_sensor, stamp_ns = recorded()[-1]
        localizer.add_scan(points, T_odom_sensor, stamp_ns + number * SCAN_NS)
        statuses.append(localizer.update(0).status)
    assert statuses[0] is not Status.LOCALIZED
    assert statuses[-1] is Status.LOCALIZED
    assert localizer.snapshot.plan.given is moved
    assert localizer.output.pose(T_odom_sensor).x == pytest.approx(
        old.output.pose(T_odom_sensor).x + 100.0, abs=0.1
    )


def test_two_ticks_at_a_time_follow_one_another(stopped):
    localizer, matcher, update = stopped
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    localizer.add_scan(points, T_odom_sensor, stamp_ns + 2 * SCAN_NS)
    with ThreadPoolExecutor(1) as pool:
        second = pool.submit(localizer.update, 0)
        with pytest.raises(TimeoutError):
            second.result(0.2)
        first = finish(matcher, update)
        assert first.submap.stamp_ns == stamp_ns + SCAN_NS
        assert second.result(WAIT_S).submap.stamp_ns == stamp_ns + 2 * SCAN_NS
    assert localizer.output is second.result()


def test_scans_ticks_and_looks_from_three_threads_end_as_one_after_the_other():
    """Whatever the order was, the submap is that of all scans, and every look is of one plan."""
    localizer = Localizer(load_config(), StoppingMatcher())
    localizer.set_plan(plan_grid())
    done, looks = Event(), []

    def tick_on():
        while not done.is_set():
            localizer.update(0)

    def look_on():
        while not done.wait(0.001):
            looks.append(localizer.snapshot)

    with ThreadPoolExecutor(2) as pool:
        others = [pool.submit(tick_on), pool.submit(look_on)]
        for scan in recorded()[:30]:
            localizer.add_scan(*scan)
        localizer.set_plan(plan_grid())
        done.set()
        for other in others:
            other.result(WAIT_S)
    plain = Localizer(load_config(), StoppingMatcher())
    plain.set_plan(plan_grid())
    for scan in recorded()[:30]:
        plain.add_scan(*scan)
    found, expected = localizer.update(0), plain.update(0)
    np.testing.assert_array_equal(found.submap.grid.cells, expected.submap.grid.cells)
    plans = [id(look.plan.given) for look in looks]
    assert len(set(plans)) <= 2
    assert plans == sorted(plans, key=plans.index), 'an old plan never comes back'


def test_a_tick_that_a_word_has_overtaken_changes_nothing(stopped):
    localizer, matcher, update = stopped
    said = localizer.output
    localizer.suggest(PoseHint(SE2.identity(), SE2.identity()))
    assert localizer.output is said, 'the claim stands until the word is weighed'
    assert finish(matcher, update) is said
