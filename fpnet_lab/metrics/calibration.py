# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calibration of stated probabilities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BINS = 10  # numerical


@dataclass(frozen=True, eq=False)
class Reliability:
    """
    Stated probability against observed frequency, in bins of the best placement's probability.

    ``claimed`` (stated), ``true`` and ``count`` are ``(10,)``, NaN in empty bins; ``ece`` is the
    expected calibration error at a prior equal to the share of correct plans among the trials.
    At the configured prior and threshold, ``claims`` trials are accepted on the correct plan,
    ``wrong_claims`` of them wrongly, and ``foreign_claims`` on another building's plan.
    """

    claimed: NDArray[np.float64]
    true: NDArray[np.float64]
    count: NDArray[np.int64]
    ece: float
    own_trials: int
    claims: int
    wrong_claims: int
    foreign_trials: int
    foreign_claims: int
    right_best: float


def reliability_bins(
    probability: NDArray[np.float64], is_right: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """
    Return mean probability, share of right ones and count in :data:`BINS` equal bins of [0, 1].

    Each is ``(BINS,)``; the first two are NaN in empty bins.
    """
    part = np.minimum((probability * BINS).astype(np.int64), BINS - 1)
    count = np.bincount(part, minlength=BINS)
    filled = np.where(count > 0, count, np.nan)
    stated = np.bincount(part, weights=probability, minlength=BINS) / filled
    right = np.bincount(part, weights=is_right, minlength=BINS) / filled
    return stated, right, count


def expected_calibration_error(
    probability: NDArray[np.float64], is_right: NDArray[np.bool_]
) -> float:
    """
    Return the mean distance between stated probabilities ``(K,)`` and observed frequencies.

    The mean is over the :func:`reliability_bins`, weighted by their counts; 0 for no trials.
    """
    if not len(probability):
        return 0.0
    stated, right, count = reliability_bins(probability, is_right)
    return float(np.nansum(np.abs(stated - right) * count) / len(probability))


def brier_score(probability: NDArray[np.float64], is_right: NDArray[np.bool_]) -> float:
    """Return the mean squared distance of probabilities ``(K,)`` from 0 or 1 (Brier 1950)."""
    return float(np.mean((probability - is_right) ** 2)) if len(probability) else 0.0
