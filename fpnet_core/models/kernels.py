# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Compiled loops of a network on arrays, with fewer memory passes than NumPy.

All constants are single precision, like the networks: a single double constant would promote a
whole loop. Sums may be reordered and vectorised.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]

_ANY_ORDER = {'reassoc', 'contract', 'nsz'}  # given: names of Numba's fastmath flags

# Numerical: Taylor series of 2^x, exact to single precision for |x| up to one half.
_P7, _P6, _P5, _P4, _P3, _P2, _P1 = (
    np.float32(math.log(2.0) ** k / math.factorial(k)) for k in range(7, 0, -1)
)
_LOG2_E = np.float32(1.0 / math.log(2.0))  # given
_LEAST = np.float32(-126.0)  # given: exponent of the smallest normal number
_EXPONENT_BIAS, _MANTISSA_BITS = np.int32(127), np.int32(23)  # given: of single precision

# Given: the error function by Abramowitz and Stegun, equation 7.1.26, within 1.5e-7, about one
# unit in the last place of single precision.
_ERF_P = np.float32(0.3275911)
_ERF_1, _ERF_2, _ERF_3, _ERF_4, _ERF_5 = (  # given: same
    np.float32(a) for a in (0.254829592, -0.284496736, 1.421413741, -1.453152027, 1.061405429)
)
_EPSILON = np.float32(1e-5)  # given: variance offset of layer normalisation, as in training
_ROOT_HALF = np.float32(math.sqrt(0.5))  # given
_ZERO, _HALF, _ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)  # given


@numba.njit(inline='always', fastmath=_ANY_ORDER)
def _exponential(x: Any) -> Any:
    """Return ``exp(x)`` for ``x <= 0``; unlike the library's, the compiler vectorises it."""
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
        # With h = |x| erfc(|x| / sqrt(2)) / 2, x Phi(x) is x - h above zero and -h below.
        out[k] = max(x[k], _ZERO) - _HALF * size * tail * _exponential(-z * z)


@numba.njit(cache=True, nogil=True, fastmath=_ANY_ORDER)
def layer_norm(x: Floats, weight: Floats, bias: Floats, out: Floats) -> None:
    """Write the rows of ``x (R, W)``, standardised, times ``weight`` plus ``bias (W,)``."""
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


@numba.njit(cache=True, nogil=True, fastmath=_ANY_ORDER)
def soften(logits: Floats, within: Floats, first: int, begin: int, across: Floats) -> None:
    """
    Convert attention ``logits (B, heads, T, S)`` to weights in place: add the bias, then softmax.

    Targets are one graph's nodes from ``first`` on, sources the nodes of both graphs. The target's
    own graph starts at source ``begin`` and is biased by the targets' rows of ``within (B, heads,
    R, R)``, the other one by ``across (heads,)``.
    """
    end = begin + within.shape[3]
    for b in range(logits.shape[0]):
        for h in range(logits.shape[1]):
            for i in range(logits.shape[2]):
                row, bias, by = logits[b, h, i], within[b, h, first + i], across[h]
                # Any value near the largest logit keeps the exponentials finite, and the maximum
                # of integers vectorises.
                top = np.int32(-(2**31) + 1)
                own = row[begin:end]
                for j in range(len(own)):
                    own[j] += bias[j]
                    top = max(top, np.int32(own[j]))
                for other in (row[:begin], row[end:]):
                    for j in range(len(other)):
                        other[j] += by
                        top = max(top, np.int32(other[j]))
                total, level = _ZERO, np.float32(top)
                for j in range(len(row)):
                    row[j] = _exponential(row[j] - level)
                    total += row[j]
                factor = _ONE / total
                for j in range(len(row)):
                    row[j] *= factor
