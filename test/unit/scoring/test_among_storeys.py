# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Placements on several storeys: one contest, one "none of these", priors of the storeys."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.geometry import SE2, Placements
from fpnet_core.scoring import (
    CONTEXT,
    FIGURES,
    Evidence,
    PlacementModel,
    PlacementScorer,
    read_scorer,
)
from fpnet_core.scoring.competing import Explained
from fpnet_core.scoring.evidence import on_one_plan

SCORER = PlacementScorer(read_scorer(), 0.99)
BLIND = PlacementScorer(PlacementModel.indifferent(), 0.99)
OF_DRAWINGS = {
    'log_plan_m2': (5.0, 6.5, 4.0),
    'plan_density': (0.9, 0.4, 1.3),
    'straightness': (0.6, 0.5, 0.8),
    'scale_range': (0.24, 0.0, 0.6),
}


def evidence(drawing, support, walls=200):
    """
    Evidence whose placements explain given shares of the walls, each its own part of them.

    What hangs on the ``drawing`` differs with its number, what hangs on the submap does not.
    """
    count = len(support)
    explained = np.zeros((count, walls), np.float32)
    for row, share in zip(explained, support, strict=True):
        row[: round(share * walls)] = 1.0
    figures = np.zeros((count, len(FIGURES)), np.float32)
    for name in ('support', 'bent_support', 'score', 'bent_score', 'seen', 'rooms_pure'):
        figures[:, FIGURES.index(name)] = support
    context = np.random.default_rng(1).normal(size=len(CONTEXT)).astype(np.float32)
    for name in ('log_plan_m2', 'plan_density', 'straightness', 'scale_range'):
        context[CONTEXT.index(name)] = OF_DRAWINGS[name][drawing]
    made = Evidence(figures, context, Explained(explained, explained, 0.5))
    return on_one_plan([made])  # with its rivals


NOTHING = Explained(np.zeros((0, 200), np.float32), np.zeros((0, 200), np.float32), 0.5)


def blank():
    """Evidence of no placements, which says nothing of the comparison either."""
    return Evidence(np.zeros((0, len(FIGURES)), np.float32), np.zeros(len(CONTEXT), np.float32))


def posterior(scorer, *support, drawing=0):
    found = evidence(drawing, support)
    places = [SE2.from_xy_yaw(10.0 * k, 1.0, 0.3) for k in range(len(support))]
    return scorer.weighed(Placements.of(places), found)


def among(scorer, *drawn, priors=None, is_fresh=None):
    return scorer.among_storeys(
        drawn, priors or [0.0] * len(drawn), is_fresh or [True] * len(drawn)
    )


def test_a_site_of_one_is_the_plan():
    alone = posterior(SCORER, 0.9, 0.4)
    (same,) = among(SCORER, alone)
    np.testing.assert_allclose(same.placements.probability, alone.placements.probability)
    assert same.none == pytest.approx(alone.none)
    assert same.elsewhere == 0.0


def test_equal_storeys_come_out_equal():
    here, there = among(SCORER, posterior(SCORER, 0.9, 0.4), posterior(SCORER, 0.9, 0.4))
    np.testing.assert_allclose(here.placements.probability, there.placements.probability)
    assert here.best < 0.5


def test_a_storey_without_placements_says_nothing_about_the_others():
    nowhere = SCORER.weighed(Placements.empty(), replace(blank(), explained=NOTHING))
    here, there = among(SCORER, nowhere, posterior(SCORER, 0.9, 0.5))
    alone = posterior(SCORER, 0.9, 0.5)
    assert here.best == 0.0
    np.testing.assert_allclose(there.weights, alone.weights, atol=1e-5)


def test_rivals_on_other_storeys_say_nothing_of_whether_any_is_right():
    alone = posterior(SCORER, 0.9, 0.3)
    alike = [posterior(SCORER, share, 0.3, drawing=2) for share in (0.82, 0.81, 0.8)]
    here, *others = among(SCORER, alone, *alike)
    assert here.best > max(each.best for each in others)
    assert here.none / here.best == pytest.approx(alone.none / alone.best, rel=0.2)


def test_what_was_found_earlier_stands():
    stale = replace(posterior(SCORER, 0.9), weights=np.array([3.0]))
    here, there = among(SCORER, posterior(SCORER, 0.7), stale, is_fresh=[True, False])
    assert there.weights.tolist() == [3.0]
    alone = posterior(SCORER, 0.7)
    np.testing.assert_allclose(here.weights, alone.weights)
    assert here.best < alone.best


def test_the_mirror_image_leaves_other_storeys_their_share():
    here, _ = among(BLIND, posterior(BLIND, 0.9), posterior(BLIND, 0.9))
    against = BLIND.against_mirror(here, posterior(BLIND, 0.9), 0.0)
    total = against.best + against.elsewhere + against.none + against.foreign
    assert total == pytest.approx(1.0)
    assert against.elsewhere == pytest.approx(against.best)
    assert against.mirror == pytest.approx(against.best)
