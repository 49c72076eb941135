# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Are probabilities compared with the truth, and constants found that make them agree?"""

import numpy as np
import pytest

from fpnet_core.config import LocalizerConfig
from fpnet_core.evaluation.calibration import (
    Trial,
    fit_posterior,
    mean_surprise,
    reliability,
)

TRUE = LocalizerConfig(evidence_per_m=0.1, null_score=0.6, null_rise=1.5)


def drawn_trials(count, seed):
    """Trials whose truth is drawn from the posterior of ``TRUE`` itself."""
    rng = np.random.default_rng(seed)
    trials = []
    for _ in range(count):
        scores = np.sort(rng.uniform(0.4, 0.95, rng.integers(1, 6)))[::-1]
        trial = Trial(scores, rng.uniform(5, 120), None, False)
        pick = rng.choice(len(scores) + 1, p=trial.probabilities(TRUE))
        truth = None if pick == len(scores) else int(pick)
        trials.append(Trial(scores, trial.wall_length_m, truth, False))
    return trials


def test_fitting_recovers_the_constants_that_made_the_trials():
    trials = drawn_trials(500, 1)
    fitted = fit_posterior(trials, LocalizerConfig())
    assert fitted['evidence_per_m'] == pytest.approx(0.1, rel=0.4)
    assert fitted['null_score'] == pytest.approx(0.6, abs=0.25)
    best = LocalizerConfig().model_copy(update=fitted)
    assert mean_surprise(trials, best) <= mean_surprise(trials, TRUE) + 1e-6


def test_the_true_posterior_is_reliable_and_a_boastful_one_is_not():
    trials = drawn_trials(1000, 2)
    boastful = TRUE.model_copy(update={'evidence_per_m': 1.0})
    assert reliability(trials, TRUE).ece < 0.04
    assert reliability(trials, boastful).ece > 0.1


def test_claims_are_counted_where_they_are_wrong():
    sure = np.array([0.95, 0.4])
    trials = [
        Trial(sure, 300.0, 0, False),
        Trial(sure, 300.0, 1, False),
        Trial(sure, 300.0, None, True),
        Trial(np.zeros(0), 300.0, None, True),
    ]
    result = reliability(trials, TRUE)
    assert (result.claims, result.wrong_claims) == (3, 2)
    assert (result.foreign_trials, result.foreign_claims) == (2, 1)
    assert result.right_best == 0.5
    assert result.count.sum() == 3
