# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Does the judge learn what decides, and is what is written what was learned?"""

import numpy as np
import pytest

from fpnet_core.config import LocalizerConfig
from fpnet_core.errors import WeightsError
from fpnet_core.geometry import SE2, Placements
from fpnet_core.scoring import CONTEXT, FIGURES, Evidence, PlacementScorer, read_scorer
from fpnet_lab.training.scorer import ScorerTraining, fit_scorer, stack_trials, write_scorer
from fpnet_lab.training.scorer_figures import held_back_figures, mean_log_probability, reliability
from fpnet_lab.training.scorer_trials import Trial, right_placements

SUPPORT = FIGURES.index('support')
QUICK = ScorerTraining(members=2, width=8, epochs=60, batch_size=64, learning_rate=1e-2)


def planted_trials(count, seed):
    """Trials in which walls decide: the right placement explains far more of them."""
    rng = np.random.default_rng(seed)
    trials = []
    for number in range(count):
        placements = int(rng.integers(2, 6))
        is_own = bool(rng.random() < 0.5)
        figures = rng.normal(size=(placements, len(FIGURES))).astype(np.float32)
        figures[:, SUPPORT] = rng.uniform(0.2, 0.5, placements)
        right = np.zeros(placements, dtype=np.bool_)
        if is_own and rng.random() < 0.9:
            right[rng.integers(placements)] = True
            figures[right, SUPPORT] = rng.uniform(0.8, 1.0)
        evidence = Evidence(figures, np.zeros(len(CONTEXT), np.float32))
        trials.append(Trial(evidence, right, is_own, 'planted', f'building {number % 8}'))
    return trials


@pytest.fixture(scope='module')
def fitted():
    trials = planted_trials(600, 1)
    return trials, fit_scorer(stack_trials(trials), QUICK)


@pytest.fixture(scope='module')
def model(fitted, tmp_path_factory):
    path = tmp_path_factory.mktemp('judge') / 'scorer.safetensors'
    write_scorer(path, fitted[1], QUICK, {})
    return read_scorer(path)


def test_what_decides_is_learned(model):
    unseen = planted_trials(300, 2)
    scorer = PlacementScorer(model, 0.5)
    own = [scorer.best_of(t.evidence, t.right) for t in unseen if t.right.any()]
    foreign = [scorer.best_of(t.evidence, t.right)[0] for t in unseen if not t.is_own]
    assert np.mean([is_right for _, is_right in own]) > 0.97
    assert np.mean([p for p, _ in own]) > 0.9
    assert np.mean(foreign) < 0.1


def test_the_written_judge_says_what_the_networks_said(fitted, model):
    trials, networks = fitted
    data = stack_trials(trials[:20])
    said = mean_log_probability(networks, data).numpy()
    for row, trial in enumerate(trials[:20]):
        count = len(trial.right)
        mine = model.log_probability(trial.evidence)
        np.testing.assert_allclose(mine[:-2], said[row, :count], atol=1e-4)
        np.testing.assert_allclose(mine[-2:], said[row, -2:], atol=1e-4)


def test_the_same_trials_and_seed_give_the_same_judge():
    data = stack_trials(planted_trials(80, 3))
    config = ScorerTraining(members=1, width=4, epochs=3)
    first, second = (fit_scorer(data, config)[0].state_dict() for _ in range(2))
    for name, value in first.items():
        np.testing.assert_array_equal(value.numpy(), second[name].numpy())


def test_a_judge_that_may_not_look_at_what_decides_cannot_tell(tmp_path):
    config = ScorerTraining(members=1, width=8, epochs=20, without=('support',))
    networks = fit_scorer(stack_trials(planted_trials(300, 1)), config)
    write_scorer(tmp_path / 'blind.safetensors', networks, config, {})
    scorer = PlacementScorer(read_scorer(tmp_path / 'blind.safetensors'), 0.5)
    unseen = [trial for trial in planted_trials(200, 2) if trial.right.any()]
    right = [scorer.best_of(trial.evidence, trial.right)[1] for trial in unseen]
    assert np.mean(right) < 0.6


def test_weights_of_other_figures_are_refused(fitted, tmp_path):
    path = tmp_path / 'scorer.safetensors'
    write_scorer(path, fitted[1], QUICK, {})
    manifest = path.with_suffix('.json')
    manifest.write_text(manifest.read_text().replace('"support_fine"', '"something_else"'))
    with pytest.raises(WeightsError, match='figures differ'):
        read_scorer(path)


def test_figures_of_judges_that_have_not_seen_the_building(fitted):
    figures = held_back_figures(fitted[0], QUICK)['planted']
    assert figures['trials'] == 600.0
    assert figures['right'] > 0.85
    assert figures['claimed_wrong_0.95'] == 0.0
    assert figures['ece'] < 0.08


def test_reliability_counts_claims_where_they_are_wrong(model):
    evidence = Evidence(
        np.zeros((2, len(FIGURES)), np.float32), np.zeros(len(CONTEXT), np.float32)
    )
    evidence.figures[:, SUPPORT] = 0.95, 0.3  # a sure placement and a poor one
    first, second, none = (np.array(x) for x in ((True, False), (False, True), (False, False)))
    trials = [
        Trial(evidence, first, True, 'a', 'a'),
        Trial(evidence, second, True, 'a', 'a'),
        Trial(evidence, none, False, 'a', 'a'),
    ]
    eager = LocalizerConfig(match_probability=0.9)
    found = reliability(trials, model, eager)
    assert (found.own_trials, found.claims, found.wrong_claims) == (2, 2, 1)
    assert (found.foreign_trials, found.foreign_claims) == (1, 1)
    assert found.right_best == 0.5
    assert found.count.sum() == 3
    # It says at least 0.9 of all three and is right about one.
    assert found.ece == pytest.approx(float(np.nansum(found.claimed)) - 1 / 3, abs=0.02)
    assert found.ece > 0.5


def test_a_placement_is_right_within_the_benchmarks_bounds_and_no_further():
    truth = SE2.from_xy_yaw(4.0, -3.0, 0.7)
    points = np.random.default_rng(0).uniform(-5.0, 5.0, (200, 2))
    near, far, turned = (
        SE2.from_xy_yaw(*shift, turn) @ truth
        for shift, turn in (((0.5, 0.0), 0.0), ((2.5, 0.0), 0.0), ((0.0, 0.0), np.deg2rad(7.0)))
    )
    placed = Placements.of([truth, near, far, turned])
    right = right_placements(placed, points, truth.apply(points), 50.0)
    assert right.tolist() == [True, True, False, False]
    assert right_placements(placed, points, truth.apply(points), 90.0).tolist()[2]
