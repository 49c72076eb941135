# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When a placement may be claimed, when a claim ends, and what a belief says of why."""

from functools import cache

import numpy as np
from planted import submap_grid

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.localizer.tracking import HypothesisTracker, TrackState, UpdateContext
from fpnet_core.pose import map_evidence
from fpnet_core.scoring import (
    CONTEXT,
    FIGURES,
    Evidence,
    PlacementModel,
    PlacementScorer,
    Posterior,
)
from fpnet_core.scoring.reasons import MIRRORED
from fpnet_core.types import Status

CONFIG = LocalizerConfig(confirm_updates=3, plan_prior=0.99)
SCORER = PlacementScorer(PlacementModel.indifferent(), CONFIG.plan_prior)
HERE, THERE = SE2.from_xy_yaw(3.0, -2.0, 0.4), SE2.from_xy_yaw(-8.0, 5.0, -2.0)


@cache
def evidence():
    return map_evidence(submap_grid())


def posterior(*placed, none=-2.0):
    """Posterior on (transform, weight) pairs; a weight is log odds against another building."""
    placements = Placements.of(Affine2D(T.linear, T.translation) for T, _ in placed)
    blank = Evidence(
        np.zeros((len(placed), len(FIGURES)), np.float32), np.zeros(len(CONTEXT), np.float32)
    )
    weights = np.array([weight for _, weight in placed], dtype=np.float64)
    return SCORER.normalized(placements, blank, weights, none)


GOOD = posterior((HERE, 8.0), (THERE, 0.0))
OTHER = posterior((THERE, 8.0), (HERE, 0.0))
TIE = posterior((HERE, 8.0), (THERE, 8.0))
UNSURE = posterior((HERE, 8.0), (THERE, 6.0))
POOR = posterior((HERE, -8.0), (THERE, -9.0), none=-9.0)
NOTHING = posterior()
NO_MIRROR = posterior((HERE, -6.0), none=-6.0)


class Following:
    """Goes on from where each tick has led."""

    def __init__(self):
        self._tracker = HypothesisTracker(CONFIG, SCORER)
        self.track = TrackState()

    @property
    def wants_mirror(self):
        return self._tracker.wants_mirror(self.track)

    def update(self, update, mirrored=None, sub=None, **options):
        context = UpdateContext(sub or evidence(), SE2.identity(), **options)
        self.track, estimate = self._tracker.update(self.track, update, context, mirrored)
        return estimate


def feed(following, *updates, mirrored=NO_MIRROR):
    """Update with each tick; the mirror image is looked at whenever it is asked for."""
    return [
        following.update(update, mirrored if following.wants_mirror else None).status
        for update in updates
    ]


def test_a_claim_asks_for_its_probability_at_every_tick_that_confirms_it():
    following = Following()
    assert feed(following, UNSURE, UNSURE, GOOD, GOOD) == [Status.AMBIGUOUS] * 4
    assert feed(following, UNSURE, GOOD, GOOD, GOOD)[-2:] == [Status.AMBIGUOUS, Status.LOCALIZED]


def test_a_claim_needs_the_same_winner_three_times():
    assert feed(Following(), GOOD, GOOD, GOOD) == [
        Status.AMBIGUOUS,
        Status.AMBIGUOUS,
        Status.LOCALIZED,
    ]


def test_looking_again_at_the_same_floor_confirms_nothing():
    following = Following()
    statuses = [
        following.update(GOOD, NO_MIRROR, floor_m2=floor_m2, needs_news=True).status
        for floor_m2 in (30.0, 30.0, 34.0, 36.0, 40.0, 40.5, 42.0)
    ]
    # Only 36 and 42 are news, of 30 and of 36.
    assert statuses == [Status.AMBIGUOUS] * 6 + [Status.LOCALIZED]


def test_a_change_of_winner_starts_the_count_again():
    statuses = feed(Following(), GOOD, GOOD, OTHER, OTHER, OTHER)
    assert statuses == [Status.AMBIGUOUS] * 4 + [Status.LOCALIZED]


def test_a_tie_is_never_claimed_and_its_halves_are_equal():
    following = Following()
    assert set(feed(following, *[TIE] * 10)) == {Status.AMBIGUOUS}
    estimate = following.update(TIE)
    np.testing.assert_allclose(estimate.scored.probability, 0.5, atol=0.001)


def test_a_claim_ends_when_its_evidence_does():
    assert feed(Following(), GOOD, GOOD, GOOD, POOR, NOTHING) == [
        Status.AMBIGUOUS, Status.AMBIGUOUS, Status.LOCALIZED, Status.LOST, Status.LOST,
    ]  # fmt: skip


def test_a_claim_is_kept_on_easier_terms_than_it_is_made():
    following = Following()
    assert feed(following, *[GOOD] * 3)[-1] is Status.LOCALIZED
    assert CONFIG.release_probability < UNSURE.best < CONFIG.accept_probability
    assert feed(following, UNSURE, TIE) == [Status.LOCALIZED, Status.AMBIGUOUS]


def test_no_claim_without_a_look_at_the_mirror_image():
    following = Following()
    for _ in range(10):
        assert following.update(GOOD).status is Status.AMBIGUOUS


def test_a_building_that_is_its_own_mirror_image_can_be_claimed():
    statuses = feed(Following(), *[GOOD] * 4, mirrored=GOOD)
    assert statuses[-1] is Status.LOCALIZED


REACHED = PlacementScorer(PlacementModel({}), 0.5)  # these verdicts have been reached


def verdict(*odds):
    """Return the verdict on placements of these odds against another building."""
    placements = Placements.of([HERE, THERE][: len(odds)])
    weights, none = np.log(np.array(odds, float)), np.log(1e-6)
    p = REACHED._probabilities(weights, none)
    rows = np.zeros((len(odds), len(FIGURES)), np.float32)
    rows[:, FIGURES.index('support')] = 0.7
    return Posterior(
        Placements(placements.linear, placements.translation, probability=p[:-2]),
        Evidence(rows, np.zeros(len(CONTEXT), np.float32)),
        weights, none, float(p[-2]), float(p[-1]),
    )  # fmt: skip


NOWHERE = verdict(1e-6)


def beliefs(*posteriors, mirrored=NOWHERE, needs_news=False):
    tracker = HypothesisTracker(LocalizerConfig(confirm_updates=3), REACHED)
    context = UpdateContext(evidence(), SE2.identity(), floor_m2=30.0, needs_news=needs_news)
    track = TrackState()
    found = []
    for each in posteriors:
        look = mirrored if tracker.wants_mirror(track) else None
        track, estimate = tracker.update(track, each, context, look)
        found.append(estimate)
    return found


def test_a_claim_is_counted_down_and_then_explained():
    found = beliefs(*[verdict(1e5, 1.0)] * 3)
    assert [estimate.status for estimate in found] == [Status.AMBIGUOUS] * 2 + [Status.LOCALIZED]
    assert found[0].reason == 'confirmed once, needs 2 more updates'
    assert found[1].reason == 'confirmed twice, needs 1 more update'
    assert found[2].reason.startswith('explains 70 % of ')


def test_a_robot_that_stands_still_is_told_what_is_missing():
    found = beliefs(*[verdict(1e5, 1.0)] * 4, needs_news=True)
    words = 'confirmed once, needs 2 more updates with new observations'
    assert [estimate.reason for estimate in found] == [words] * 4


def test_a_lost_claim_says_why():
    found = beliefs(*[verdict(1e5, 1.0)] * 3, verdict(1e-3))
    assert found[-1].status is Status.LOST
    assert found[-1].reason == 'explains 70 % of the observed walls: possibly another building'


def test_a_mirror_image_that_alone_fits_is_the_reason():
    found = beliefs(*[verdict(1e-2)] * 10, mirrored=verdict(1e9))
    assert (found[0].reason, found[0].is_mirrored) != (MIRRORED, True)
    assert found[-1].status is Status.SEARCHING
    assert (found[-1].reason, found[-1].is_mirrored) == (MIRRORED, True)


def test_a_mirror_image_that_fits_as_well_is_named():
    found = beliefs(verdict(1e5), mirrored=verdict(1e9))
    assert 'mirror' not in found[0].reason
    looked = beliefs(*[verdict(1e5)] * 5, mirrored=verdict(1.8e7))
    assert looked[-1].reason.endswith("the floorplan's mirror image fits equally well")
    assert looked[-1].status is Status.AMBIGUOUS


def test_nothing_found_is_searching():
    assert feed(Following(), NOTHING, NOTHING) == [Status.SEARCHING] * 2


def test_rivals_that_are_all_poor_are_none_of_these():
    assert feed(Following(), POOR, POOR) == [Status.SEARCHING] * 2


def test_a_look_as_sure_as_all_of_them_needs_no_more_floor():
    """As where a floorplan comes after the robot has seen the building."""
    for weight, driven_m, status in (
        (13.0, 20.0, Status.AMBIGUOUS),
        (15.0, 0.0, Status.AMBIGUOUS),  # it stands
        (15.0, 20.0, Status.LOCALIZED),
    ):
        following, update = Following(), posterior((HERE, weight), (THERE, 0.0), none=-9.0)
        seen = {'floor_m2': 90.0, 'driven_m': driven_m, 'needs_news': True}
        for _ in range(CONFIG.confirm_updates):
            estimate = following.update(update, NO_MIRROR, **seen)
        assert estimate.status is status


def test_the_mirror_image_is_looked_at_now_and_then_but_not_under_a_claim():
    following = Following()
    wanted = []
    for _ in range(2 * CONFIG.mirror_check_updates):
        wanted.append(following.wants_mirror)
        feed(following, TIE)
    assert sum(wanted) == 2
    feed(following, *[GOOD] * 4)
    assert not following.wants_mirror
