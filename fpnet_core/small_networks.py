# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Building blocks of small networks that run without a learning framework."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

Array = NDArray[np.float64]
Floats = NDArray[np.floating[Any]]

_SINGLE_THREAD = 2**18
"""
Numerical: multiplications up to which OpenBLAS computes a product on the calling thread.

Graphs are too small to gain from more threads, and a thread pool waits for its slowest member at
every product: beside other busy programs a match took a hundred times as long.
"""


CLIP = 4.0
"""Numerical: features are clipped to this many standard deviations."""


def standardised(
    values: NDArray[np.floating], mean: Array, spread: Array, most: float = CLIP
) -> Array:
    """
    Return ``values (..., D)`` in standard deviations from their ``mean (D,)``, NaN as 0.

    They are clipped to ``most``, so that values outside the training range do not count more.
    """
    return np.clip(np.nan_to_num((values - mean) / spread), -most, most)


def silu(x: Array) -> Array:
    """Return the sigmoid-weighted linear unit (...) of ``x (...)`` (Elfwing et al., 2018)."""
    return np.asarray(x * expit(x))


def product(a: Floats, b: Floats) -> Floats:
    """Return ``a (..., T, K) @ b (..., K, S)``, computed on the calling thread only."""
    rows = rows_at_once(*b.shape[-2:])
    if a.shape[-2] <= rows:
        return np.asarray(a @ b)
    lead = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    out = np.empty((*lead, a.shape[-2], b.shape[-1]), dtype=np.result_type(a, b))
    for start in range(0, a.shape[-2], rows):
        part = slice(start, start + rows)
        np.matmul(a[..., part, :], b, out=out[..., part, :])
    return out


def rows_at_once(inner: int, columns: int) -> int:
    """Return how many rows times ``(inner, columns)`` are computed on the calling thread."""
    return max(1, _SINGLE_THREAD // max(inner * columns, 1))
