# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether probabilities mean what they say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BINS = 10  # numerical


@dataclass(frozen=True, eq=False)
class Reliability:
    """
    Stated against true, in bins of the best placement's probability.

    ``claimed``, ``true`` and ``count`` are ``(10,)``, NaN where a bin is empty; ``ece`` is the
    expected calibration error: at a prior that is the share of own plans among the trials, since
    no other can be right on average. Claims are made at the prior and the claim probability in
    force: ``claims`` on own plans, ``wrong_claims`` among them, and ``foreign_claims``.
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
    Return mean probability, share of right ones and count in :data:`BINS` equal parts of [0, 1].

    Each ``(BINS,)``, the first two NaN where a bin is empty.
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
    Return the mean distance of stated probabilities ``(K,)`` from how often they were right.

    Over the :func:`reliability_bins`, weighted by how many fall into each; 0 for none.
    """
    if not len(probability):
        return 0.0
    stated, right, count = reliability_bins(probability, is_right)
    return float(np.nansum(np.abs(stated - right) * count) / len(probability))
