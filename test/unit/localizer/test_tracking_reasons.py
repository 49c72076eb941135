# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A belief says why, whatever its status."""

from functools import cache

import numpy as np
from planted import submap_grid

from fpnet_core.config import LocalizerConfig
from fpnet_core.geometry import SE2, Placements
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

SCORER = PlacementScorer(PlacementModel({}), 0.5)  # these verdicts have been reached
HERE, THERE = SE2.from_xy_yaw(3.0, -2.0, 0.4), SE2.from_xy_yaw(-8.0, 5.0, -2.0)
NOTHING = np.log(1e-6)


@cache
def evidence():
    return map_evidence(submap_grid())


def posterior(*odds, none=NOTHING):
    """Return the verdict on placements of these odds against another building."""
    placements = Placements.of([HERE, THERE][: len(odds)])
    weights = np.log(np.array(odds, float))
    p = SCORER._probabilities(weights, none)
    rows = np.zeros((len(odds), len(FIGURES)), np.float32)
    rows[:, FIGURES.index('support')] = 0.7
    return Posterior(
        Placements(placements.linear, placements.translation, probability=p[:-2]),
        Evidence(rows, np.zeros(len(CONTEXT), np.float32)),
        weights, none, float(p[-2]), float(p[-1]),
    )  # fmt: skip


NOWHERE = posterior(1e-6)


def beliefs(*posteriors, mirrored=NOWHERE, needs_news=False):
    tracker = HypothesisTracker(LocalizerConfig(confirm_updates=3), SCORER)
    context = UpdateContext(evidence(), SE2.identity(), floor_m2=30.0, needs_news=needs_news)
    track = TrackState()
    found = []
    for each in posteriors:
        look = mirrored if tracker.wants_mirror(track) else None
        track, estimate = tracker.update(track, each, context, look)
        found.append(estimate)
    return found


def test_a_claim_is_counted_down_and_then_explained():
    found = beliefs(*[posterior(1e5, 1.0)] * 3)
    assert [estimate.status for estimate in found] == [Status.AMBIGUOUS] * 2 + [Status.LOCALIZED]
    assert found[0].reason == 'confirmed once, needs 2 more updates'
    assert found[1].reason == 'confirmed twice, needs 1 more update'
    assert found[2].reason.startswith('explains 70 % of ')


def test_a_robot_that_stands_still_is_told_what_is_missing():
    found = beliefs(*[posterior(1e5, 1.0)] * 4, needs_news=True)
    words = 'confirmed once, needs 2 more updates with new observations'
    assert [estimate.reason for estimate in found] == [words] * 4


def test_a_lost_claim_says_why():
    found = beliefs(*[posterior(1e5, 1.0)] * 3, posterior(1e-3))
    assert found[-1].status is Status.LOST
    assert found[-1].reason == 'explains 70 % of the observed walls: possibly another building'


def test_a_mirror_image_that_alone_fits_is_the_reason():
    found = beliefs(*[posterior(1e-2)] * 10, mirrored=posterior(1e9))
    assert (found[0].reason, found[0].is_mirrored) != (MIRRORED, True)
    assert found[-1].status is Status.SEARCHING
    assert (found[-1].reason, found[-1].is_mirrored) == (MIRRORED, True)


def test_a_mirror_image_that_fits_as_well_is_named():
    found = beliefs(posterior(1e5), mirrored=posterior(1e9))
    assert 'mirror' not in found[0].reason
    looked = beliefs(*[posterior(1e5)] * 5, mirrored=posterior(1.8e7))
    assert looked[-1].reason.endswith("the floorplan's mirror image fits equally well")
    assert looked[-1].status is Status.AMBIGUOUS
