# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting what weighs the readings of a drawing, on readings whose truth is known."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import GroupKFold, cross_val_predict

from fpnet_core.drawings.plausible import FEATURES, powers

Array = NDArray[np.float64]

_STRENGTH = 0.3  # inverse of the ridge that keeps the weights of rare figures small
_FOLDS = 5
_MAX_ITERATIONS = 2000


def fit_readings(
    figures: Array, is_right: NDArray[np.bool_], sheets: NDArray[np.int64], seed: int
) -> tuple[dict[str, Any], Array]:
    """
    Fit the plausibility of readings.

    Parameters
    ----------
    figures : (R, F), in the order of :data:`fpnet_core.drawings.plausible.FEATURES`
    is_right : (R,), whether the rooms agree with the truth
    sheets : (R,), which sheet a reading is of; folds do not share sheets
    seed : of the solver

    Returns
    -------
    The weights as they are stored, and the probabilities (R,) of folds that were left out.
    """
    mean, std = figures.mean(axis=0), figures.std(axis=0) + 1e-9
    inputs = powers((figures - mean) / std)
    model = LogisticRegression(C=_STRENGTH, max_iter=_MAX_ITERATIONS, random_state=seed)
    held_out = cross_val_predict(
        model, inputs, is_right, groups=sheets, cv=GroupKFold(_FOLDS), method='predict_proba'
    )[:, 1]
    model.fit(inputs, is_right)
    stored = {
        'features': list(FEATURES),
        'mean': mean.round(6).tolist(),
        'std': std.round(6).tolist(),
        'weight': model.coef_[0].round(6).tolist(),
        'bias': round(float(model.intercept_[0]), 6),
        'training': {
            'readings': len(figures),
            'sheets': len(np.unique(sheets)),
            'right': int(is_right.sum()),
            'seed': seed,
        },
    }
    return stored, held_out
