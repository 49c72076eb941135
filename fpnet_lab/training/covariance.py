# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fit of the pose covariance model to the pose errors of simulated recordings.

Maximum likelihood of normally distributed errors with equal weight for each run. The variances are
too small for unseen buildings; left-out buildings show by how much, and they are enlarged so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from fpnet.accuracy import GATE_95
from fpnet_core.pose.uncertainty import FIGURES, UncertaintyModel
from fpnet_core.pose_covariance import Growth, carried
from fpnet_lab.training.covariance_drives import Samples

Array = NDArray[np.float64]

# Numerical: start of the optimization: logarithms of variances,
_POSITION, _YAW = 2.0 * np.log(0.1), 2.0 * np.log(0.012)
# numerical: and of odometry noise [1, m/s, rad/m, rad/s]; bounds of the latter.
_GROWTH, _GROWTH_BOUNDS = np.log([0.03, 0.01, 0.003, 0.003]), (np.log(1e-3), np.log(0.2))
_LEAST_STD = 1e-6  # numerical: of a constant feature


@dataclass(frozen=True)
class CovarianceTraining:
    """Settings of a fit."""

    ridge: float = 0.01
    """Penalty on the weights of standardised features."""
    folds: int = 5
    """Number of groups of buildings to leave out together."""
    every: int = 2
    """Stride over the poses: errors of neighbouring poses are correlated."""
    aim: float = 2.5
    """Mean normalised squared error on left-out buildings. Three degrees of freedom would give 3,
    but errors have heavier tails: with 3, one in twelve was beyond the 95 % gate."""


def fit_covariance(samples: Samples, config: CovarianceTraining) -> UncertaintyModel:
    """Return the maximum likelihood model."""
    weight = _run_weights(samples)
    mean = weight @ samples.figures
    std = np.sqrt(weight @ (samples.figures - mean) ** 2) + _LEAST_STD
    few = samples.where(np.arange(0, len(samples), config.every))
    share = _run_weights(few)
    size = samples.figures.shape[1]

    def cost(parameters: Array) -> float:
        model = _model(parameters, mean, std)
        weights = np.concatenate([model.position[1:], model.yaw[1:]])
        return float(share @ _log_loss(model, few) + config.ridge * weights @ weights)

    start = np.concatenate([[_POSITION], np.zeros(size), [_YAW], np.zeros(size), _GROWTH])
    bounds = [(None, None)] * (2 * size + 2) + [_GROWTH_BOUNDS] * len(_GROWTH)
    return _model(minimize(cost, start, method='L-BFGS-B', bounds=bounds).x, mean, std)


def _model(parameters: Array, mean: Array, std: Array) -> UncertaintyModel:
    size = len(mean) + 1
    position, yaw, growth = np.split(parameters, [size, 2 * size])
    lost = Growth(*np.exp(growth).tolist())
    return UncertaintyModel(mean, std, position, yaw, lost)


def covariances_of(model: UncertaintyModel, samples: Samples) -> Array:
    """Return the covariances ``(N, 3, 3)`` predicted by a model."""
    cov = model.covariances(samples.figures, samples.information)
    return carried(cov, samples.away, samples.age_s, model.growth)


def normalised_errors_of(model: UncertaintyModel, samples: Samples) -> Array:
    """Return the normalised squared errors ``(N,)``."""
    return _normalised(covariances_of(model, samples), samples.error)


def _normalised(cov: Array, error: Array) -> Array:
    solved = np.linalg.solve(cov, error[..., None])[..., 0]
    return np.asarray((error * solved).sum(axis=1))


def _log_loss(model: UncertaintyModel, samples: Samples) -> Array:
    """Return the negative log-likelihood of the errors ``(N,)`` [nats], up to a constant."""
    cov = covariances_of(model, samples)
    return np.asarray(
        0.5 * (np.linalg.slogdet(cov)[1] + _normalised(cov, samples.error)), dtype=np.float64
    )


def _run_weights(samples: Samples) -> Array:
    """Return weights ``(N,)`` that sum to one, with equal totals for all runs."""
    counts = np.bincount(samples.run)
    weight = 1.0 / counts[samples.run]
    return np.asarray(weight / weight.sum())


def held_back_errors(
    samples: Samples, config: CovarianceTraining, on_fold: Callable[[float], None] = lambda _: None
) -> Array:
    """Return normalised squared errors ``(N,)`` on buildings left out of the fit."""
    nees = np.zeros(len(samples))
    for fold in range(config.folds):
        is_out = samples.building % config.folds == fold
        model = fit_covariance(samples.where(~is_out), config)
        nees[is_out] = normalised_errors_of(model, samples.where(is_out))
        on_fold(1.0)
    return nees


def enlarged(model: UncertaintyModel, factor: float) -> UncertaintyModel:
    """Return the model with all variances multiplied by ``factor``."""
    growth = Growth(**{k: v * float(np.sqrt(factor)) for k, v in asdict(model.growth).items()})
    first = np.eye(len(FIGURES) + 1)[0] * np.log(factor)
    return replace(model, position=model.position + first, yaw=model.yaw + first, growth=growth)


def consistency(nees: Array, run: NDArray[np.int64]) -> dict[str, float]:
    """Return mean, worst run's mean and share inside the 95 % gate; runs have equal weights."""
    counts = np.maximum(np.bincount(run), 1)
    means = np.bincount(run, nees) / counts
    inside = np.bincount(run, nees <= GATE_95) / counts
    is_there = np.bincount(run) > 0
    return {
        'runs': int(is_there.sum()),
        'nees_mean': round(float(means[is_there].mean()), 3),
        'nees_worst_run': round(float(means.max()), 2),
        'inside_95': round(float(inside[is_there].mean()), 4),
    }


def stored(model: UncertaintyModel, facts: dict[str, Any]) -> dict[str, Any]:
    """Return the model with ``facts`` in the format of :meth:`UncertaintyModel.from_json`."""
    arrays = {
        name: np.round(getattr(model, name), 5).tolist()
        for name in ('mean', 'std', 'position', 'yaw')
    }
    growth = {name: round(value, 6) for name, value in asdict(model.growth).items()}
    return {
        'figures': list(FIGURES), **arrays, 'growth': growth, **facts,
    }  # fmt: skip
