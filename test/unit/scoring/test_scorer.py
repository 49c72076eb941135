# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is believed of placements: priors, rivals, the mirror image, and order."""

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

HERE, THERE, ELSEWHERE = (SE2.from_xy_yaw(x, -2.0, 0.4) for x in (3.0, 9.0, -7.0))
BLIND = PlacementModel.indifferent()


def blank(count):
    return Evidence(
        np.zeros((count, len(FIGURES)), np.float32), np.zeros(len(CONTEXT), np.float32)
    )


def posterior(scorer, weights, none=-5.0):
    placements = Placements.of((HERE, THERE, ELSEWHERE)[: len(weights)])
    return scorer.normalized(placements, blank(len(weights)), np.array(weights), none)


def test_probabilities_add_up_and_are_ranked():
    found = posterior(PlacementScorer(BLIND, 0.9), [1.0, 3.0, -2.0])
    p = found.placements.probability
    assert p.sum() + found.none + found.foreign == pytest.approx(1.0)
    assert (np.diff(p) < 0.0).all()
    np.testing.assert_array_equal(found.placements.matrix[0], THERE.matrix)


def test_weights_are_log_odds_against_another_building():
    # exp(2) * 0.9 : exp(-5) * 0.9 : 0.1
    found = posterior(PlacementScorer(BLIND, 0.9), [2.0])
    total = 0.9 * np.exp(2.0) + 0.9 * np.exp(-5.0) + 0.1
    assert found.best == pytest.approx(0.9 * np.exp(2.0) / total)
    assert found.foreign == pytest.approx(0.1 / total)


def test_a_stronger_prior_on_the_plan_helps_against_others_plans_and_not_against_a_rival():
    weak, strong = (PlacementScorer(BLIND, prior) for prior in (0.5, 0.999))
    assert posterior(strong, [1.0]).best > 0.99 > 0.8 > posterior(weak, [1.0]).best
    assert posterior(strong, [1.0, 1.0]).best == pytest.approx(0.5, abs=0.005)


def test_the_mirror_image_takes_what_it_is_worth():
    scorer = PlacementScorer(BLIND, 0.99)
    drawn, mirrored = posterior(scorer, [5.0]), posterior(scorer, [12.0])
    even = scorer.against_mirror(drawn, mirrored, 7.0)
    assert even.best == pytest.approx(0.5, abs=0.01)
    assert even.none == pytest.approx(0.5, abs=0.01)
    assert scorer.against_mirror(drawn, posterior(scorer, [-9.0]), 7.0).best > 0.98


def test_a_doubt_takes_what_it_is_worth():
    scorer = PlacementScorer(BLIND, 0.99)
    stated, doubt = posterior(scorer, [2.0]), posterior(scorer, [8.0, 1.0], none=3.0)
    both = scorer.with_wide_prior(stated, doubt, -6.0)
    np.testing.assert_allclose(both.weights, [2.0, 2.0, -5.0])
    assert np.exp(both.none_weight) == pytest.approx(np.exp(-5.0) + np.exp(-3.0))
    p = both.placements.probability
    assert p.sum() + both.none + both.foreign == pytest.approx(1.0)
    assert p[0] == pytest.approx(p[1])
    certain = scorer.with_wide_prior(stated, doubt, -60.0)
    assert certain.best == pytest.approx(stated.best)


def test_a_word_decides_between_places_that_look_alike():
    scorer = PlacementScorer(BLIND, 0.99)
    found = posterior(scorer, [8.0, 8.0, 8.0])
    with_hint = scorer.with_hint(found, np.array([False, True, False]))
    assert with_hint.best > 0.99 > 0.34 > found.best
    np.testing.assert_array_equal(with_hint.placements.matrix[0], found.placements.matrix[1])


@pytest.mark.parametrize('weights', [[8.0, 2.0, -5.0], [3.0, 3.0], [-2.0]])
def test_a_word_for_the_best_place_never_makes_less_sure_and_proves_nothing(weights):
    scorer = PlacementScorer(BLIND, 0.99)
    found = posterior(scorer, weights)
    with_hint = scorer.with_hint(found, np.arange(len(weights)) == 0)
    assert with_hint.best >= found.best
    assert with_hint.none / with_hint.foreign == pytest.approx(found.none / found.foreign)
    assert with_hint.best / with_hint.none == pytest.approx(found.best / found.none)


def test_walls_that_contradict_outweigh_a_word():
    scorer = PlacementScorer(BLIND, 0.99)
    found = posterior(scorer, [12.0, -4.0])
    with_hint = scorer.with_hint(found, np.array([False, True]))
    np.testing.assert_array_equal(with_hint.placements.matrix[0], found.placements.matrix[0])
    assert 0.9 < with_hint.best < found.best


def test_the_order_of_placements_changes_nothing():
    rng = np.random.default_rng(5)
    figures = rng.normal(size=(6, len(FIGURES))).astype(np.float32)
    context = rng.normal(size=len(CONTEXT)).astype(np.float32)
    model, order = read_scorer(), rng.permutation(6)
    straight = model.log_probability(Evidence(figures, context))
    shuffled = model.log_probability(Evidence(figures[order], context))
    np.testing.assert_allclose(shuffled[:-2], straight[:-2][order], atol=1e-9)
    np.testing.assert_allclose(shuffled[-2:], straight[-2:], atol=1e-9)


def test_figures_beyond_all_experience_count_no_more_than_the_utmost_experience():
    model = read_scorer()
    far = blank(2)
    figures = np.full_like(far.figures, 1e6)
    further = Evidence(10.0 * figures, far.context)
    np.testing.assert_allclose(
        model.log_probability(Evidence(figures, far.context)), model.log_probability(further)
    )


def test_placements_that_say_the_same_can_be_left_out():
    scorer = PlacementScorer(BLIND, 0.99)
    found = posterior(scorer, [2.0, 2.0, -5.0])
    one = scorer.reduced(found, np.array([0, 2]))
    assert len(one.placements) == len(one.evidence) == 2
    assert one.best > 0.98 > 0.51 > found.best
