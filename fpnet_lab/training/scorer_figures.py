# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calibration and accuracy of a placement scorer on held-out trials and buildings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
import torch

from fpnet_core.config import LocalizerConfig
from fpnet_core.scoring import PlacementModel, PlacementScorer
from fpnet_lab.metrics import Reliability, expected_calibration_error, reliability_bins
from fpnet_lab.training.scorer import (
    PlacementNetwork,
    ScorerTraining,
    TrialTensors,
    fit_scorer,
    stack_trials,
)
from fpnet_lab.training.scorer_trials import Trial

Array = NDArray[np.float64]

CLAIMS = (0.9, 0.95, 0.97, 0.99)
"""
Candidate acceptance thresholds; their error rates determine the configured one. Chosen.
"""

# Chosen, not measured:
FOLDS = 4
_FOLD_MEMBERS = 2


def reliability(
    trials: Sequence[Trial], model: PlacementModel, config: LocalizerConfig
) -> Reliability:
    """Compare the stated probability of each trial's best placement with the truth."""
    own = np.array([trial.is_own for trial in trials], dtype=np.bool_)
    share = float(np.clip(own.mean(), 0.01, 0.99)) if len(own) else 0.5
    stated = [
        PlacementScorer(model, share).best_of(trial.evidence, trial.right) for trial in trials
    ]
    p = np.array([each[0] for each in stated], dtype=np.float64)
    right = np.array([each[1] for each in stated], dtype=np.bool_)
    in_force = PlacementScorer(model, config.plan_prior)
    claim = (
        np.array([in_force.best_of(t.evidence, t.right)[0] for t in trials])
        >= config.match_probability
    )
    claimed, true, count = reliability_bins(p, right)
    return Reliability(
        claimed=claimed,
        true=true,
        count=count,
        ece=expected_calibration_error(p, right),
        own_trials=int(own.sum()),
        claims=int((claim & own).sum()),
        wrong_claims=int((claim & own & ~right).sum()),
        foreign_trials=int((~own).sum()),
        foreign_claims=int((claim & ~own).sum()),
        right_best=float(right[own].mean()) if own.any() else 0.0,
    )


def held_back_figures(
    trials: Sequence[Trial], config: ScorerTraining
) -> dict[str, dict[str, float]]:
    """
    Return figures per kind of trial, each by a scorer fitted without the trial's building.

    ``right`` is the share of trials on correct plans with a right best placement. For each
    threshold in :data:`CLAIMS`, ``claimed_right_P`` and ``claimed_wrong_P`` are shares of trials
    on correct plans, ``foreign_claimed_P`` of those on other plans; ``ece`` is the expected
    calibration error with a prior equal to the share of correct plans among the trials.
    """
    data = stack_trials(trials)
    names = sorted({_building(trial) for trial in trials})
    fold_of = {name: number % FOLDS for number, name in enumerate(names)}
    folds = np.array([fold_of[_building(trial)] for trial in trials])
    log_p = torch.zeros((len(trials), data.there.shape[1] + 2))
    for fold in range(FOLDS):
        inside, outside = (
            torch.from_numpy(np.flatnonzero(x)) for x in (folds != fold, folds == fold)
        )
        if len(inside) and len(outside):
            networks = fit_scorer(data.where(inside), replace(config, members=_FOLD_MEMBERS))
            log_p[outside] = mean_log_probability(networks, data.where(outside))
    kinds = np.array([trial.kind for trial in trials])
    return {
        str(kind): _figures(log_p.double().numpy()[kinds == kind], data, kinds == kind)
        for kind in sorted(set(kinds))
    }


def mean_log_probability(networks: Sequence[PlacementNetwork], data: TrialTensors) -> torch.Tensor:
    """Return the mean log probability of the members, normalized, ``(N, K + 2)``."""
    with torch.inference_mode():
        votes = [net(data.figures, data.context, data.there) for net in networks]
        return torch.log_softmax(torch.stack(votes).mean(dim=0), dim=1)


def at_prior(log_p: Array, plan_prior: float) -> Array:
    """Return the probabilities ``(N, K + 2)`` for a given prior of the correct plan."""
    moved = log_p.copy()
    moved[:, -1] -= np.log(plan_prior / (1.0 - plan_prior))
    share = np.exp(moved - moved.max(axis=1, keepdims=True))
    return np.asarray(share / share.sum(axis=1, keepdims=True))


def _figures(log_p: Array, data: TrialTensors, chosen: NDArray[np.bool_]) -> dict[str, float]:
    config = LocalizerConfig()
    right, own = data.right.numpy()[chosen], data.own.numpy()[chosen]
    p = at_prior(log_p, config.plan_prior)[:, :-2]
    best = p.argmax(axis=1)
    rows = np.arange(len(p))
    is_right = right[rows, best]
    even = at_prior(log_p, float(np.clip(own.mean(), 0.01, 0.99)))[rows, best]
    found = {
        'trials': float(len(p)),
        'ece': expected_calibration_error(even, is_right),
        'right': _mean(is_right[own]),
    }
    for threshold in CLAIMS:
        is_claim = p[rows, best] >= threshold
        found[f'claimed_right_{threshold:g}'] = _mean((is_claim & is_right)[own])
        found[f'claimed_wrong_{threshold:g}'] = _mean((is_claim & ~is_right)[own])
        found[f'foreign_claimed_{threshold:g}'] = _mean(is_claim[~own])
    return {name: round(float(value), 4) for name, value in found.items()}


def _mean(values: NDArray[np.bool_]) -> float:
    return float(values.mean()) if len(values) else 0.0


def _building(trial: Trial) -> str:
    """Return the name of a group to leave out: data sets name one building in several ways."""
    return trial.building.removesuffix('_scan').removesuffix('_filled')
