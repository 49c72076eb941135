# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calls that come while a tick is at work in another thread."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np
from planted import plan_grid
from planted_drive import SCAN_NS, recorded
import pytest

from fpnet_core.config import load_config
from fpnet_core.localizer import Localizer
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
    localizer = Localizer(load_config(None, {'localizer.search_every_ticks': 1}), matcher)
    localizer.set_plan(plan_grid())
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % 5 == 4:
            localizer.tick(stamp_ns)
    assert localizer.output.status is Status.LOCALIZED
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    localizer.add_scan(points, T_odom_sensor, stamp_ns + SCAN_NS)
    matcher.reached.clear()
    matcher.go_on.clear()
    with ThreadPoolExecutor(1) as pool:
        tick = pool.submit(localizer.tick, stamp_ns + SCAN_NS)
        assert matcher.reached.wait(WAIT_S)
        try:
            yield localizer, matcher, tick
        finally:
            matcher.go_on.set()


def finish(matcher, tick):
    matcher.go_on.set()
    return tick.result(WAIT_S)


def test_scans_are_added_and_poses_asked_for_in_the_meantime(stopped):
    localizer, matcher, tick = stopped
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    localizer.add_scan(points, T_odom_sensor, stamp_ns + 2 * SCAN_NS)
    assert localizer.output.pose(T_odom_sensor) is not None
    assert not tick.done()
    output = finish(matcher, tick)
    assert output.status is Status.LOCALIZED
    assert output.submap.stamp_ns == stamp_ns + SCAN_NS  # of what it was started with
    assert localizer.tick(0).submap.stamp_ns == stamp_ns + 2 * SCAN_NS


@pytest.mark.parametrize(
    'overtake',
    [
        lambda localizer: localizer.set_plan(plan_grid()),
        Localizer.reset,
        Localizer.relocalize,
    ],
)
def test_a_tick_that_was_overtaken_claims_nothing(stopped, overtake):
    localizer, matcher, tick = stopped
    overtake(localizer)
    assert localizer.output.status is Status.WAITING
    assert finish(matcher, tick).status is Status.WAITING
    assert localizer.output.status is Status.WAITING
    assert len(localizer.output.estimates) == 0


def test_a_new_odometry_frame_overtakes_a_tick(stopped):
    localizer, matcher, tick = stopped
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    far = T_odom_sensor.copy()
    far[0, 3] += 100.0
    localizer.add_scan(points, far, stamp_ns + 2 * SCAN_NS)
    assert finish(matcher, tick).status is Status.WAITING
    assert localizer.output.pose(far) is None
