# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import numpy as np
from scipy.spatial.transform import Rotation

from fpnet_core.geometry.gyro_track import MAX_GAP_NS, GyroTrack

STEP_NS = 5_000_000
START_NS = 1_750_000_000_000_000_000


def turned_deg(before, after):
    return np.rad2deg(Rotation.from_matrix(before.T @ after).as_rotvec())


def filled(count, rate_of, horizon_ns=None):
    track = GyroTrack(horizon_ns)
    for k in range(count):
        track.add(START_NS + k * STEP_NS, rate_of(k * STEP_NS / 1e9))
    return track


def test_rates_add_up_to_the_turn_between_two_times():
    axis = np.array([0.1, -0.2, 0.97])
    track = filled(401, lambda t: axis * (2.0 + 8.0 * t))
    stamps = START_NS + np.array([3_000_000, 101_234_567, 203_000_000, 1_999_999_999])
    orientations = [track.at(int(stamp)) for stamp in stamps]
    seconds = (stamps - START_NS) / 1e9
    angle = 2.0 * seconds + 4.0 * seconds**2
    for k in range(len(stamps) - 1):
        turn = Rotation.from_rotvec(axis * (angle[k + 1] - angle[k])).as_matrix()
        np.testing.assert_allclose(orientations[k].T @ orientations[k + 1], turn, atol=1e-4)


def test_in_a_gap_and_beyond_the_end_nothing_is_known_and_turns_after_it_are():
    track = filled(21, lambda _: [0.0, 0.0, 1.0])
    resumed_ns = START_NS + 20 * STEP_NS + 2 * MAX_GAP_NS
    assert track.at(START_NS) is not None
    assert track.at(START_NS + 21 * STEP_NS) is None, 'later than all rates'
    for k in range(60):
        track.add(resumed_ns + k * STEP_NS, [0.0, 0.0, 1.0])
    assert track.at(resumed_ns + STEP_NS) is None, 'the gap is in between'
    before, after = (track.at(resumed_ns + k * STEP_NS) for k in (11, 51))
    np.testing.assert_allclose(turned_deg(before, after), [0, 0, np.rad2deg(0.2)], atol=1e-6)


def test_where_the_clock_goes_back_the_track_starts_anew_and_disorder_is_dropped():
    track = filled(100, lambda _: [0.0, 0.0, 1.0])
    track.add(START_NS + 98 * STEP_NS, [0.0, 0.0, 50.0])
    assert len(track) == 100
    track.add(START_NS, [0.0, 0.0, 1.0])
    assert (len(track), track.newest_ns) == (1, START_NS)
