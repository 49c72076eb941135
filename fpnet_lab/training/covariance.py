# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fitting how far poses may be off: the errors of drives are to be probable.

Maximum likelihood of normal errors, each run weighing the same. Buildings that are left out tell
by how much the variances are too small for buildings that nobody has seen, and they are enlarged.
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

# Numerical: where the search begins: logarithms of variances,
_POSITION, _YAW = 2.0 * np.log(0.1), 2.0 * np.log(0.012)
# numerical: and of what odometry loses [1, m/s, rad/m, rad/s]; how far the latter may go.
_GROWTH, _GROWTH_BOUNDS = np.log([0.03, 0.01, 0.003, 0.003]), (np.log(1e-3), np.log(0.2))
_LEAST_STD = 1e-6  # numerical: of a figure that never varies


@dataclass(frozen=True)
class CovarianceTraining:
    """Settings of a fit."""

    ridge: float = 0.01
    """On the weights of standardised figures."""
    folds: int = 5
    """Of buildings that are left out together."""
    every: int = 2
    """One in so many poses is looked at: neighbours are off alike."""
    aim: float = 2.5
    """Mean normalised squared error of the buildings left out. Three degrees of freedom would make
    it 3, but errors have longer tails: one in twelve was beyond the 95 % gate then."""


def fit_covariance(samples: Samples, config: CovarianceTraining) -> UncertaintyModel:
    """Return the model under which the errors are most probable."""
    weight = _run_weights(samples)
    mean = weight @ samples.figures
    std = np.sqrt(weight @ (samples.figures - mean) ** 2) + _LEAST_STD
    few = samples.where(np.arange(0, len(samples), config.every))
    share = _run_weights(few)
    size = samples.figures.shape[1]

    def cost(parameters: Array) -> float:
        model = _model(parameters, mean, std)
        weights = np.concatenate([model.position[1:], model.yaw[1:]])
        return float(share @ _surprise(model, few) + config.ridge * weights @ weights)

    start = np.concatenate([[_POSITION], np.zeros(size), [_YAW], np.zeros(size), _GROWTH])
    bounds = [(None, None)] * (2 * size + 2) + [_GROWTH_BOUNDS] * len(_GROWTH)
    return _model(minimize(cost, start, method='L-BFGS-B', bounds=bounds).x, mean, std)


def _model(parameters: Array, mean: Array, std: Array) -> UncertaintyModel:
    size = len(mean) + 1
    position, yaw, growth = np.split(parameters, [size, 2 * size])
    lost = Growth(*np.exp(growth).tolist())
    return UncertaintyModel(mean, std, position, yaw, lost)


def covariances_of(model: UncertaintyModel, samples: Samples) -> Array:
    """Return the covariances ``(N, 3, 3)`` that a model gives."""
    cov = model.covariances(samples.figures, samples.information)
    return carried(cov, samples.away, samples.age_s, model.growth)


def normalised_errors_of(model: UncertaintyModel, samples: Samples) -> Array:
    """Return the normalised squared errors ``(N,)``."""
    return _normalised(covariances_of(model, samples), samples.error)


def _normalised(cov: Array, error: Array) -> Array:
    solved = np.linalg.solve(cov, error[..., None])[..., 0]
    return np.asarray((error * solved).sum(axis=1))


def _surprise(model: UncertaintyModel, samples: Samples) -> Array:
    """Return what the errors cost ``(N,)`` [nats]."""
    cov = covariances_of(model, samples)
    return np.asarray(
        0.5 * (np.linalg.slogdet(cov)[1] + _normalised(cov, samples.error)), dtype=np.float64
    )


def _run_weights(samples: Samples) -> Array:
    """Return weights ``(N,)`` that add up to one, the same for each run."""
    counts = np.bincount(samples.run)
    weight = 1.0 / counts[samples.run]
    return np.asarray(weight / weight.sum())


def held_back_errors(
    samples: Samples, config: CovarianceTraining, on_fold: Callable[[float], None] = lambda _: None
) -> Array:
    """Return normalised squared errors ``(N,)``, each building's by a model that knows others."""
    nees = np.zeros(len(samples))
    for fold in range(config.folds):
        is_out = samples.building % config.folds == fold
        model = fit_covariance(samples.where(~is_out), config)
        nees[is_out] = normalised_errors_of(model, samples.where(is_out))
        on_fold(1.0)
    return nees


def enlarged(model: UncertaintyModel, factor: float) -> UncertaintyModel:
    """Return the model with all variances larger by a factor."""
    growth = Growth(**{k: v * float(np.sqrt(factor)) for k, v in asdict(model.growth).items()})
    first = np.eye(len(FIGURES) + 1)[0] * np.log(factor)
    return replace(model, position=model.position + first, yaw=model.yaw + first, growth=growth)


def consistency(nees: Array, run: NDArray[np.int64]) -> dict[str, float]:
    """Return mean, worst run's mean and share inside the 95 % gate, each run weighing the same."""
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
    """Return the model as :meth:`UncertaintyModel.from_json` reads it, with ``facts`` beside."""
    arrays = {
        name: np.round(getattr(model, name), 5).tolist()
        for name in ('mean', 'std', 'position', 'yaw')
    }
    growth = {name: round(value, 6) for name, value in asdict(model.growth).items()}
    return {
        'figures': list(FIGURES), **arrays, 'growth': growth, **facts,
    }  # fmt: skip
