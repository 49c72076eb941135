# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from fpnet_core.io.pointcloud2 import CloudArrays, sweep_seconds
from fpnet_core.io.sweep_stamps import SweepStamps

S = 1_000_000_000
NOW_NS = 1_700_000_000 * S
PERIOD_NS = S // 10


def cloud(times):
    points = np.zeros((3, 3), dtype=np.float32)
    if times is None:
        return CloudArrays(points, None)
    found = sweep_seconds(np.array(times, dtype=np.float64))
    return CloudArrays(points, found.since_first_s, None, found.first_s)


@given(
    end_s=st.floats(-0.1, 0.2).filter(lambda s: abs(s) > 0.003),
    unit=st.sampled_from([1.0, 1e3, 1e6, 1e9]),
    is_absolute=st.booleans(),
    start_s=st.floats(100.0, 2e9),
)
def test_times_tell_the_end_in_any_unit_on_either_clock(end_s, unit, is_absolute, start_s):
    stamp_ns = round(start_s * S)
    origin_s = stamp_ns / S if is_absolute else 0.0
    times = (origin_s + end_s + np.array([-0.1, -0.04, 0.0])) * unit
    pose_ns = SweepStamps(say=pytest.fail).pose_ns(cloud(times), stamp_ns)
    assert pose_ns - stamp_ns == pytest.approx(end_s * S, abs=5_000)


@pytest.mark.parametrize('last_s', [-0.0014, 0.0, 0.0014])
def test_an_end_at_the_stamp_leaves_the_stamp(last_s):
    """By which others know the cloud: the last firing is never quite at it."""
    assert SweepStamps().pose_ns(cloud([-0.1, last_s]), NOW_NS) == NOW_NS


@pytest.mark.parametrize(
    ('said', 'after_s'), [('start', 0.1), ('middle', 0.05), ('end', 0.0), ('auto', 0.1)]
)
def test_what_somebody_says_of_the_stamp_comes_before_the_origin_of_times(said, after_s):
    assert SweepStamps(said).pose_ns(cloud([0.0, 0.1]), NOW_NS) == NOW_NS + round(after_s * S)


@pytest.mark.parametrize(
    ('said', 'after_s'), [('start', 0.05), ('middle', 0.0), ('end', -0.05), ('auto', 0.0)]
)
@pytest.mark.parametrize('times', [None, [0.0, 0.0, 0.0]])
def test_without_times_the_pose_is_that_of_the_middle(said, after_s, times):
    lines = []
    stamps = SweepStamps(said, lines.append)
    gaps = [PERIOD_NS, PERIOD_NS, 3 * PERIOD_NS, PERIOD_NS, PERIOD_NS]  # two clouds got lost
    stamp_ns = NOW_NS
    for gap_ns in gaps:
        pose_ns = stamps.pose_ns(cloud(times), stamp_ns)
        stamp_ns += gap_ns
    assert pose_ns == stamp_ns - gaps[-1] + round(after_s * S)
    assert len(lines) == (1 if said == 'auto' else 0)


def test_times_of_another_clock_are_told_once():
    lines = []
    stamps = SweepStamps(say=lines.append)
    for k in range(3):
        up_s = 512.0 + 0.1 * k
        assert stamps.pose_ns(cloud([up_s, up_s + 0.1]), NOW_NS + k) == NOW_NS + k
    assert len(lines) == 1
    assert 'another clock' in lines[0]
    assert 'scans.stamp' in lines[0]


def test_relative_and_absolute_times_are_kept_apart_near_the_start_of_a_simulated_clock():
    stamps = SweepStamps(say=pytest.fail)
    assert stamps.pose_ns(cloud([0.0, 0.1]), S) == S + PERIOD_NS
    assert stamps.pose_ns(cloud([1.0, 1.1]), S) == S + PERIOD_NS
