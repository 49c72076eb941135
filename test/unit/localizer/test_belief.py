# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When a placement may be claimed, and when a claim ends."""

from dataclasses import replace
from functools import cache

import numpy as np
from planted import submap_grid

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2, Affine2D, Placement, Placements
from fpnet_core.localizer.belief import HypothesisTracker, posterior
from fpnet_core.pose import map_evidence
from fpnet_core.types import Status

# Not the constants in force, which every fit moves: what is tested is how they act.
CONFIG = LocalizerConfig(
    confirm_ticks=3, evidence_per_m=0.25, null_score=0.67, null_rise=0.9, rival_weight=0.76
)
HERE, THERE = SE2.from_xy_yaw(3.0, -2.0, 0.4), SE2.from_xy_yaw(-8.0, 5.0, -2.0)


@cache
def evidence():
    return map_evidence(submap_grid())


def placed(T, score):
    return Placement(Affine2D(T.linear, T.translation), score, np.eye(3))


def feed(tracker, *ticks, mirrored=0.3):
    """Update with each tick; the mirror image is looked at whenever it is asked for."""
    return [
        tracker.update(
            Placements.of(estimates),
            evidence(),
            SE2.identity(),
            mirrored if tracker.wants_mirror else None,
        ).status
        for estimates in ticks
    ]


def test_posterior_sums_below_one_and_a_tie_is_a_tie():
    p = posterior(np.array([0.8, 0.8, 0.3]), 200.0, CONFIG)
    assert p.sum() < 1.0
    assert p[0] == p[1]
    assert 0.35 < p[0] <= 0.5


def test_evidence_grows_with_the_walls_seen():
    scores = np.array([0.8, 0.7])
    few, many = (posterior(scores, length, CONFIG)[0] for length in (5.0, 200.0))
    assert few < 0.7 < 0.9 < many


def test_a_poor_score_that_stands_alone_beats_a_good_one_among_equals():
    alone = posterior(np.array([0.55, 0.3, 0.28]), 200.0, CONFIG)[0]
    among = posterior(np.array([0.8, 0.79, 0.79]), 200.0, CONFIG)[0]
    assert alone > 0.9 > 0.7 > among


def test_a_plan_known_to_be_of_the_building_needs_less_to_win_but_not_against_a_rival():
    known = CONFIG.model_copy(update={'plan_log_odds': 6.9})
    lone, tie = np.array([0.62, 0.3]), np.array([0.62, 0.61])
    assert posterior(lone, 200.0, known)[0] > 0.99
    assert posterior(lone, 200.0, known)[0] > posterior(lone, 200.0, CONFIG)[0]
    assert posterior(tie, 200.0, known)[0] < 0.8


def test_the_same_gap_says_more_between_good_scores():
    good, poor = (
        posterior(np.array([best, best - 0.04]), 200.0, CONFIG)[0] for best in (0.93, 0.72)
    )
    assert good > 0.99 > 0.95 > poor


def test_a_claim_asks_for_its_probability_at_every_tick_that_confirms_it():
    tracker = HypothesisTracker(CONFIG, 1.0)
    sure, unsure = (placed(HERE, 0.9),), (placed(HERE, 0.9), placed(THERE, 0.88))
    assert feed(tracker, unsure, unsure, sure, sure) == [Status.AMBIGUOUS] * 4
    assert feed(tracker, unsure, sure, sure, sure)[-2:] == [Status.AMBIGUOUS, Status.LOCALIZED]


def test_rivals_that_are_all_poor_are_none_of_these():
    poor = (placed(HERE, 0.4), placed(THERE, 0.35))
    assert feed(HypothesisTracker(CONFIG, 1.0), poor, poor) == [Status.SEARCHING] * 2


def test_a_low_score_loses_against_none_of_these():
    assert posterior(np.array([CONFIG.null_score - 0.1]), 60.0, CONFIG)[0] < 0.05


def test_a_claim_needs_the_same_winner_three_times():
    good = (placed(HERE, 0.85), placed(THERE, 0.5))
    assert feed(HypothesisTracker(CONFIG, 1.0), good, good, good) == [
        Status.AMBIGUOUS,
        Status.AMBIGUOUS,
        Status.LOCALIZED,
    ]


def test_looking_again_at_the_same_walls_confirms_nothing():
    tracker = HypothesisTracker(CONFIG, 1.0)
    good = Placements.of([placed(HERE, 0.85), placed(THERE, 0.5)])
    grown = [
        replace(evidence(), walls=evidence().walls[: round(share * len(evidence().walls))])
        for share in (0.6, 0.6, 0.61, 0.61, 0.7, 0.72, 0.72, 0.9)
    ]
    statuses = [
        tracker.update(good, sub, SE2.identity(), 0.3, needs_news=True).status for sub in grown
    ]
    # Only 0.7 and 0.9 are news, of 0.6 and of 0.7.
    assert statuses == [Status.AMBIGUOUS] * 7 + [Status.LOCALIZED]


def test_a_change_of_winner_starts_the_count_again():
    here = (placed(HERE, 0.85), placed(THERE, 0.5))
    there = (placed(THERE, 0.85), placed(HERE, 0.5))
    statuses = feed(HypothesisTracker(CONFIG, 1.0), here, here, there, there, there)
    assert statuses == [Status.AMBIGUOUS] * 4 + [Status.LOCALIZED]


def test_a_winner_that_only_stretches_elsewhere_is_the_same_one():
    stretched = np.diag([1.2, 1.0])
    robot = np.array([30.0, 0.0])
    there = placed(SE2.identity(), 0.85)
    deformed = Placement(Affine2D(stretched, robot - stretched @ robot), 0.85, np.eye(3))
    for robot_xy, status in ((robot, Status.LOCALIZED), (None, Status.AMBIGUOUS)):
        tracker = HypothesisTracker(CONFIG, 2.0)
        for best in (there, deformed, there, deformed):
            tick = Placements.of([best, placed(THERE, 0.4)]), evidence(), SE2.identity()
            belief = tracker.update(*tick, mirrored_score=0.3, robot_xy=robot_xy)
        assert belief.status is status


def test_a_tie_is_never_claimed():
    tie = (placed(HERE, 0.9), placed(THERE, 0.9))
    assert set(feed(HypothesisTracker(CONFIG, 1.0), *[tie] * 10)) == {Status.AMBIGUOUS}


def test_a_claim_ends_when_its_evidence_does():
    tracker = HypothesisTracker(CONFIG, 1.0)
    good = (placed(HERE, 0.85), placed(THERE, 0.5))
    bad = (placed(HERE, 0.2),)
    assert feed(tracker, good, good, good, bad, ()) == [
        Status.AMBIGUOUS,
        Status.AMBIGUOUS,
        Status.LOCALIZED,
        Status.LOST,
        Status.LOST,
    ]


def test_a_belief_tells_how_probable_each_placement_is():
    tracker = HypothesisTracker(CONFIG, 1.0)
    found = Placements.of([placed(HERE, 0.85), placed(THERE, 0.5)])
    belief = tracker.update(found, evidence(), SE2.identity())
    expected = posterior(found.score, evidence().wall_length_m, CONFIG)
    np.testing.assert_array_equal(belief.judged.probability, expected)
    np.testing.assert_array_equal(belief.judged.matrix, found.matrix)
    assert belief.best.probability == belief.probability == expected[0]
    poor = tracker.update(Placements.of([placed(HERE, 0.2)]), evidence(), SE2.identity())
    assert poor.best is None
    assert poor.judged.probability.tolist() == [poor.probability]


def test_nothing_found_is_searching():
    assert feed(HypothesisTracker(CONFIG, 1.0), (), ()) == [Status.SEARCHING] * 2


def test_no_claim_without_a_look_at_the_mirror_image():
    tracker = HypothesisTracker(CONFIG, 1.0)
    good = Placements.of([placed(HERE, 0.85), placed(THERE, 0.5)])
    for _ in range(10):
        assert tracker.update(good, evidence(), SE2.identity()).status is Status.AMBIGUOUS


def test_a_mirror_image_that_fits_much_better_is_the_reason():
    tracker = HypothesisTracker(CONFIG, 1.0)
    poor = Placements.of([placed(HERE, 0.7), placed(THERE, 0.65)])
    beliefs = [tracker.update(poor, evidence(), SE2.identity(), 0.95) for _ in range(3)]
    assert beliefs[0].reason == ''
    assert beliefs[-1].status is Status.SEARCHING
    assert 'mirrored' in beliefs[-1].reason


def test_a_building_that_is_its_own_mirror_image_can_be_claimed():
    good = (placed(HERE, 0.9), placed(THERE, 0.5))
    statuses = feed(HypothesisTracker(CONFIG, 1.0), *[good] * 4, mirrored=0.9)
    assert statuses[-1] is Status.LOCALIZED


def test_the_mirror_image_is_looked_at_now_and_then_but_not_under_a_claim():
    tracker = HypothesisTracker(CONFIG, 1.0)
    tie, good = (placed(HERE, 0.9), placed(THERE, 0.9)), (placed(HERE, 0.85), placed(THERE, 0.5))
    wanted = []
    for _ in range(2 * CONFIG.mirror_check_ticks):
        wanted.append(tracker.wants_mirror)
        feed(tracker, tie)
    assert sum(wanted) == 2
    feed(tracker, *[good] * 4)
    assert not tracker.wants_mirror
