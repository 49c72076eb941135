# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Accuracy of estimated scales: error of the median and coverage of the interval."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.segmentation.scale import SURE_FACTOR

Array = NDArray[np.float64]


def interval_figures(errors: Array, weight: Array | None = None) -> dict[str, float]:
    """
    Return the shares of estimates that are near the truth, cover it, and are called sure.

    Parameters
    ----------
    errors : (N, 3) log ratios of low, median and high to the true scale, N >= 1
    weight : (N,) of each estimate; None: equal weights

    Returns
    -------
    ``within_10``: medians within 10 %; ``held``: intervals that contain the truth; ``sure`` and
    ``sure_wrong``: estimates called sure, and those of them with a median more than 10 % off;
    ``spread``: median of high / low; ``log_rms``: RMS log error of the medians.
    """
    low, median, high = errors.T
    reach = np.log(SURE_FACTOR)
    sure = (high - median <= reach) & (median - low <= reach)
    is_near = np.abs(median) <= reach

    def share(of: NDArray[np.bool_]) -> float:
        return round(float(np.average(of, weights=weight)), 4)

    return {
        'estimates': len(errors),
        'within_10': share(is_near),
        'held': share((low <= 0.0) & (high >= 0.0)),
        'spread': round(float(np.exp(np.median(high - low))), 3),
        'sure': share(sure),
        'sure_wrong': share(sure & ~is_near),
        'log_rms': round(float(np.sqrt(np.average(median**2, weights=weight))), 4),
    }
