# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether probabilities mean what they say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BINS = 10


def expected_calibration_error(
    probability: NDArray[np.float64], is_right: NDArray[np.bool_], bins: int = BINS
) -> float:
    """
    Return the mean distance of stated probabilities ``(K,)`` from how often they were right.

    Over ``bins`` equal parts of [0, 1], weighted by how many fall into each; 0 for none.
    """
    if not len(probability):
        return 0.0
    part = np.minimum((probability * bins).astype(int), bins - 1)
    stated = np.bincount(part, weights=probability, minlength=bins)
    right = np.bincount(part, weights=is_right, minlength=bins)
    return float(np.abs(stated - right).sum() / len(probability))
