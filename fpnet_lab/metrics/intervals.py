# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What became of estimated scales: how near their medians are, and what their intervals hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.segmentation.scale import SURE_FACTOR

Array = NDArray[np.float64]


def interval_figures(errors: Array, weight: Array | None = None) -> dict[str, float]:
    """
    Return shares of estimates that are near, hold the truth, and are called sure.

    Parameters
    ----------
    errors : (N, 3) logarithms of low, median and high over the truth, N of at least one
    weight : (N,) of each estimate; None weighs all the same

    Returns
    -------
    ``within_10`` of medians within ten per cent; ``held`` of intervals that hold the truth;
    ``sure`` and ``sure_wrong``, those called sure and those of them more than ten per cent off;
    ``spread``, the median of high over low; ``log_rms``, of the medians' errors.
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
