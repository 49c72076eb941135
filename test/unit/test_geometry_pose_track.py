# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses over time: between samples, at their ends, in gaps, and where a clock goes back."""

import numpy as np
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.geometry.pose_track import MAX_GAP_NS, PoseTrack

S = 10**9


def T(x, y=0.0, yaw=0.0):
    return SE2.from_xy_yaw(x, y, yaw).as_matrix4()


def test_a_track_interpolates_within_and_not_beyond():
    track = PoseTrack.of([(100, T(1.0, 2.0, 0.2)), (200_000_100, T(2.0, 4.0, 0.6))], 'base')
    np.testing.assert_allclose(track.at(50_000_100), T(1.25, 2.5, 0.3), atol=1e-9)
    np.testing.assert_array_equal(track.at(100), T(1.0, 2.0, 0.2))
    assert track.at(99) is None
    assert track.at(200_000_101) is None
    assert (track.child_frame, len(track)) == ('base', 2)
    assert PoseTrack().at(0) is None


@pytest.mark.parametrize(('gap_ns', 'is_known'), [(MAX_GAP_NS, True), (MAX_GAP_NS + 2, False)])
def test_a_robot_may_have_turned_in_a_gap(gap_ns, is_known):
    track = PoseTrack.of([(0, T(0.0)), (gap_ns, T(1.0))])
    assert (track.at(gap_ns // 2) is not None) == is_known


@pytest.mark.parametrize(('turned', 'is_known'), [(1.5, True), (np.pi, False)])
def test_nothing_is_known_between_two_messages_that_no_robot_turns_between(turned, is_known):
    track = PoseTrack.of([(0, T(0.0)), (S // 50, T(0.1, 0.0, turned))])
    assert (track.at(S // 100) is not None) == is_known
    assert ('turns by 180 degrees' in track.reason(S // 100)) != is_known
    np.testing.assert_array_equal(track.at(0), T(0.0))


def test_a_drive_forgets_and_starts_anew_where_the_clock_goes_back():
    track = PoseTrack(horizon_ns=2 * S)
    for k in range(50):
        track.add(k * S // 10, T(float(k)))
    assert len(track) == 21
    track.add(48 * S // 10 - S // 20, T(9.0))  # late, no clock that went back
    assert len(track) == 22
    track.add(0, T(-1.0))
    assert len(track) == 1
    np.testing.assert_array_equal(track.at(0), T(-1.0))
