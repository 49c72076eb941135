# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When the other localizer is told its pose: never while ours is unsure, and rarely."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_ros.seeding import (
    PoseAgreement,
    SeedingState,
    Situation,
    advise,
    is_restart,
)
from fpnet_ros.settings import SeederParameters
from msg_adapters.poses import StampedPose, UncertainPose

LIMITS = SeederParameters()
HERE = (4.0, -2.0, 3.0)


def at(x, y, yaw, second=0.0, sigma_m=0.1):
    pose = StampedPose(round(second * NS_PER_S), 'map', SE2.from_xy_yaw(x, y, yaw))
    return UncertainPose(pose, np.diag([sigma_m**2, sigma_m**2, 0.03**2]))


def seen(second=0.0, other=None, status=Status.LOCALIZED, **changes):
    """Our localizer stands at HERE; ``other`` is the other one's pose at the same time."""
    ours = at(*HERE, second)
    pair = None if other is None else (ours, other)
    return replace(Situation(round(second * NS_PER_S), status, ours, pair), **changes)


def follow(state, situations, limits=LIMITS):
    """Return the state after all situations, and the seconds of the seeds."""
    seeds = []
    for situation in situations:
        state, advice = advise(state, situation, limits)
        if advice.seed:
            seeds.append(situation.now_ns / NS_PER_S)
    return state, seeds


def compared(x, y, yaw, until, start=1.0, **changes):
    """Two poses a second of the other localizer, which is at a place."""
    return [
        seen(second, at(x, y, yaw, second, **changes)) for second in np.arange(start, until, 0.5)
    ]


def test_it_is_told_once_and_not_while_it_agrees():
    situations = [seen(0.0), seen(0.2), *compared(4.3, -2.2, -3.1, 60.0), seen(61.0)]
    assert follow(SeedingState(), situations)[1] == [0.0]


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'status': None}, 'our localizer is silent'),
        ({'status': Status.AMBIGUOUS}, 'our localizer is ambiguous'),
        ({'status': Status.LOST}, 'our localizer is lost'),
        ({'ours': None}, 'has not published its pose'),
        ({'ours': at(*HERE, 7.0)}, 'is 3.0 s old'),
        ({'ours': at(*HERE, 10.0, sigma_m=2.0)}, 'is unsure by 2.0 m'),
        ({'is_heard': False}, 'nobody subscribes'),
    ],
)
@pytest.mark.parametrize('agreement', [PoseAgreement.UNKNOWN, PoseAgreement.ELSEWHERE])
def test_it_refuses_while_it_is_unsure(changes, reason, agreement):
    new = agreement is PoseAgreement.UNKNOWN
    state = SeedingState(is_new=new, agreement=agreement)
    after, advice = advise(state, seen(10.0, **changes), LIMITS)
    assert not advice.seed
    assert reason in advice.said
    # What is due stays due, unless our own pose was withdrawn: then both are compared anew.
    assert after.is_due == (new or changes.get('status', Status.LOCALIZED) is Status.LOCALIZED)


@pytest.mark.parametrize('place', [(7.0, -2.0, 3.0), (4.0, -2.0, 0.0), (4.9, -0.9, 3.0)])
def test_it_is_told_again_after_it_was_elsewhere_for_a_while(place):
    state, seeds = follow(SeedingState(is_new=False), compared(*place, 3.9))
    assert seeds == []
    assert state.agreement is PoseAgreement.UNKNOWN
    assert follow(state, compared(*place, 4.1, start=4.0))[1] == [4.0]


def test_what_both_covariances_allow_is_not_elsewhere():
    assert follow(SeedingState(is_new=False), compared(6.5, -2.0, 3.0, 60.0, sigma_m=1.0))[1] == []


def test_one_that_spread_out_is_told_though_its_mean_agrees():
    state, seeds = follow(SeedingState(is_new=False), compared(*HERE, 3.9, sigma_m=4.0))
    assert seeds == []
    state, advice = advise(state, seen(5.0, at(*HERE, 5.0, sigma_m=4.0)), LIMITS)
    assert advice.seed
    assert 'unsure' in advice.said


def test_moments_elsewhere_and_poses_from_before_the_seed_do_not_count():
    elsewhere = (9.0, 9.0, 0.0)
    blinking = [each for k in range(20) for each in (
        *compared(*elsewhere, 3.0 * k + 2.9, start=3.0 * k + 0.5),
        *compared(*HERE, 3.0 * k + 3.1, start=3.0 * k + 3.0),
    )]  # fmt: skip
    assert follow(SeedingState(is_new=False), blinking)[1] == []
    state = SeedingState(is_new=False, seeded_ns=60 * NS_PER_S)
    assert follow(state, compared(*elsewhere, 60.0))[1] == []


def test_one_that_ignores_its_pose_is_told_less_and_less_often():
    seeds = follow(SeedingState(), [seen(0.0), *compared(9.0, 9.0, 0.0, 300.0)])[1]
    gaps = np.diff(seeds)
    assert (np.diff(gaps) >= 0.0).all()
    assert gaps[0] >= 2.0 * LIMITS.elsewhere_s
    assert 40.0 < gaps[-1] < 60.0


def test_after_an_agreement_it_is_told_soon_again():
    ignored = [seen(0.0), *compared(9.0, 9.0, 0.0, 60.0)]
    state, _ = follow(SeedingState(), [*ignored, *compared(*HERE, 200.0, start=199.0)])
    assert follow(state, compared(9.0, 9.0, 0.0, 205.0, start=200.0))[1] == [203.0]


def test_it_may_only_watch():
    watching = LIMITS.model_copy(update={'reseed': False})
    state, seeds = follow(SeedingState(is_new=False), compared(9.0, 9.0, 0.0, 30.0), watching)
    assert seeds == []
    _, advice = advise(state, seen(30.0), watching)
    assert advice.is_trouble
    assert 'elsewhere, off by 12.1 m and 172 degrees' in advice.said
    assert follow(SeedingState(), [seen(0.0)], watching)[1] == [0.0]


def test_a_silent_one_is_said_but_not_told():
    moved = replace(seen(9.0), ours=at(20.0, 5.0, 0.0, 9.0))
    state, seeds = follow(SeedingState(), [seen(0.0), moved])
    assert seeds == [0.0]
    _, advice = advise(state, moved, LIMITS)
    assert advice.is_trouble
    assert 'publishes no pose' in advice.said


@pytest.mark.parametrize(
    ('before', 'now', 'is_new', 'expected'),
    [
        ('a', 'a', False, False),
        ('a', '', False, True),  # it ended
        ('', 'a', False, True),  # it came back, after a seed on request
        ('a', 'ab', False, True),  # killed and respawned: the dead one lingers
        ('ab', 'b', False, False),  # the dead one's lease expires
        ('', 'a', True, False),
    ],
)
def test_a_restarted_localizer_is_known_by_its_subscription(before, now, is_new, expected):
    sides = ({bytes(each, 'ascii') for each in side} for side in (before, now))
    assert is_restart(*sides, is_new) is expected
