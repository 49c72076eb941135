# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Compiled loops of a network on arrays: what takes NumPy many passes over memory, in one or two.

All constants are of single precision, as the networks are: one of double precision would make
doubles of a whole loop. Sums may be taken in any order, by several at once.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]

_ANY_ORDER = {'reassoc', 'contract', 'nsz'}  # given: what Numba's fastmath calls it

# Numerical: Taylor's series of 2^x, which is exact to single precision for half of one.
_P7, _P6, _P5, _P4, _P3, _P2, _P1 = (
    np.float32(math.log(2.0) ** k / math.factorial(k)) for k in range(7, 0, -1)
)
_LOG2_E = np.float32(1.0 / math.log(2.0))  # given
_LEAST = np.float32(-126.0)  # given: exponent of the smallest number with all its digits
_EXPONENT_BIAS, _MANTISSA_BITS = np.int32(127), np.int32(23)  # given: of single precision

# Given: the error function by Abramowitz and Stegun, equation 7.1.26, within 1.5e-7, about one
# unit of single precision in the last place.
_ERF_P = np.float32(0.3275911)
_ERF_1, _ERF_2, _ERF_3, _ERF_4, _ERF_5 = (  # given: same
    np.float32(a) for a in (0.254829592, -0.284496736, 1.421413741, -1.453152027, 1.061405429)
)
_EPSILON = np.float32(1e-5)  # given: what layer normalisation adds to a variance, as in training
_ROOT_HALF = np.float32(math.sqrt(0.5))  # given
_ZERO, _HALF, _ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)  # given


@numba.njit(inline='always', fastmath=_ANY_ORDER)
def _exponential(x: Any) -> Any:
    """Return ``exp(x)`` of ``x <= 0``; unlike the library's, for several numbers at once."""
    power = max(x * _LOG2_E, _LEAST)
    whole = np.floor(power + _HALF)
    f = power - whole
    series = ((((((_P7 * f + _P6) * f + _P5) * f + _P4) * f + _P3) * f + _P2) * f + _P1) * f + _ONE
    bits = np.int32((np.int32(whole) + _EXPONENT_BIAS) << _MANTISSA_BITS)
    return series * bits.view(np.float32)


@numba.njit(cache=True, nogil=True, fastmath=_ANY_ORDER, error_model='numpy')
def gelu(x: Floats, out: Floats) -> None:
    """Write the Gaussian error linear unit ``x Phi(x)`` of ``x (P,)`` to ``out (P,)``."""
    for k in range(len(x)):
        size = abs(x[k])
        z = size * _ROOT_HALF
        t = _ONE / (_ONE + _ERF_P * z)
        tail = ((((_ERF_5 * t + _ERF_4) * t + _ERF_3) * t + _ERF_2) * t + _ERF_1) * t
        # Half the tail of |x|: x Phi(x) is that much below x above zero, and is it below.
        out[k] = max(x[k], _ZERO) - _HALF * size * tail * _exponential(-z * z)


@numba.njit(cache=True, nogil=True, fastmath=_ANY_ORDER)
def layer_norm(x: Floats, weight: Floats, bias: Floats, out: Floats) -> None:
    """Write the rows of ``x (R, W)``, each standardised, times ``weight`` plus ``bias (W,)``."""
    width = x.shape[1]
    for r in range(len(x)):
        row, own = x[r], out[r]
        total, square = _ZERO, _ZERO
        for k in range(width):
            total += row[k]
        mean = total / np.float32(width)
        for k in range(width):
            square += (row[k] - mean) * (row[k] - mean)
        factor = _ONE / np.sqrt(square / np.float32(width) + _EPSILON)
        for k in range(width):
            own[k] = (row[k] - mean) * factor * weight[k] + bias[k]


@numba.njit(cache=True, nogil=True)
def soften(logits: Floats, within: Floats, first: int, begin: int, across: Floats) -> None:
    """
    Make weights of attention ``logits (B, heads, T, S)`` in place: add their bias, then softmax.

    Targets are the nodes of one graph from the ``first`` on, sources those of two. The target's
    own graph starts at ``begin`` among these and is biased by the targets' rows of ``within
    (B, heads, R, R)``, the other one by ``across (heads,)``.
    """
    end = begin + within.shape[-1]
    for b in range(logits.shape[0]):
        for h in range(logits.shape[1]):
            for i in range(logits.shape[2]):
                row = logits[b, h, i]
                top = _biased(row[begin:end], within[b, h, first + i])
                top = max(top, _raised(row[:begin], across[h]), _raised(row[end:], across[h]))
                _normalised(row, top)


@numba.njit(nogil=True, fastmath=_ANY_ORDER)
def _biased(row: Floats, bias: Floats) -> np.int32:
    """
    Add ``bias (S,)`` in place and return the largest sum, rounded.

    Any number near it keeps an exponential finite, and the largest whole one is found for several
    at once.
    """
    top = np.int32(-(2**31) + 1)
    for j in range(len(row)):
        value = row[j] + bias[j]
        row[j] = value
        top = max(top, np.int32(value))
    return top


@numba.njit(nogil=True, fastmath=_ANY_ORDER)
def _raised(row: Floats, by: Any) -> np.int32:
    """Do the same with one number for all."""
    top = np.int32(-(2**31) + 1)
    for j in range(len(row)):
        value = row[j] + by
        row[j] = value
        top = max(top, np.int32(value))
    return top


@numba.njit(nogil=True, fastmath=_ANY_ORDER)
def _normalised(row: Floats, top: np.int32) -> None:
    """Replace logits by their exponentials over the sum of these; ``top`` is near the largest."""
    total, level = _ZERO, np.float32(top)
    for j in range(len(row)):
        share = _exponential(row[j] - level)
        row[j] = share
        total += share
    factor = _ONE / total
    for j in range(len(row)):
        row[j] *= factor
