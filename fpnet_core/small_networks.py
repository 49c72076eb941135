# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What small networks are made of where no learning framework is loaded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

Array = NDArray[np.float64]


def standardised(values: NDArray[np.floating], mean: Array, spread: Array, most: float) -> Array:
    """
    Return ``values (..., D)`` in standard deviations from their ``mean (D,)``, NaN as 0.

    They are held to ``most`` of them: nothing unseen counts more.
    """
    return np.clip(np.nan_to_num((values - mean) / spread), -most, most)


def silu(x: Array) -> Array:
    """Return the sigmoid-weighted linear unit (...) of ``x (...)`` (Elfwing et al., 2018)."""
    return np.asarray(x * expit(x))
