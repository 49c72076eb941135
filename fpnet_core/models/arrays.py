# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What a network is written with that arrays and tensors do not share; here for NumPy.

Importing PyTorch takes longer than matching two maps, and for graphs of a few hundred nodes its
calls cost more than NumPy's. So networks that robots run are written for a :class:`Library`, of
which training has another (:mod:`fpnet_core.models.tensors`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math
from types import ModuleType
from typing import Any

import numpy as np

from fpnet_core.small_networks import Floats, product, rows_at_once

Array = Any
"""An array of NumPy or a tensor of PyTorch; what both have in common is used of it."""

MASKED = -1e4
"""
Numerical: logit of padding: ``exp`` of it is exactly zero in float32, and sums of it stay finite.
"""

# Given: the error function by Abramowitz and Stegun, equation 7.1.26, within 1.5e-7, about one
# unit of single precision in the last place.
_ERF_P = 0.3275911
_ERF_A = (1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592)  # given: same
_EPSILON = 1e-5  # given: what layer normalisation adds to a variance, as in training


@dataclass(frozen=True, eq=False)
class JointBias:
    """
    What is added to attention among the nodes of two graphs, ``(B, heads, M+N, M+N)`` in blocks.

    ``ours (B, heads, M, M)`` and ``theirs (B, heads, N, N)`` within the graphs, ``across
    (heads,)`` between them; ``mask (B, M+N)`` is True for real nodes.
    """

    ours: Array
    theirs: Array
    across: Array
    mask: Array


@dataclass(frozen=True)
class Library:
    """
    Arrays of one kind: their ``module``, and what has no name or form in common.

    ``linear(x, weight, bias)`` maps the last axis; ``mixed(x, weight, bias)`` the last but one
    of ``x (B, F, K)``; ``attention(query, key, value, bias)`` are softmax-weighted sums of
    ``value (B, heads, M+N, d)`` with a :class:`JointBias` added to the scaled products.
    """

    module: ModuleType
    product: Callable[[Array, Array], Array]
    linear: Callable[[Array, Array, Array], Array]
    mixed: Callable[[Array, Array, Array], Array]
    layer_norm: Callable[[Array, Array, Array], Array]
    gelu: Callable[[Array], Array]
    attention: Callable[[Array, Array, Array, JointBias], Array]
    log_softmax: Callable[[Array, int], Array]
    log_sigmoid: Callable[[Array], Array]
    identity_like: Callable[[Array], Array]


def _linear(x: Floats, weight: Floats, bias: Floats) -> Floats:
    out = product(x, weight.T)
    out += bias
    return out


def _mixed(x: Floats, weight: Floats, bias: Floats) -> Floats:
    # Transposed views: the many columns of x are the rows that are taken in turn.
    out = product(x.swapaxes(-1, -2), weight.T)
    out += bias
    return out.swapaxes(-1, -2)


def _layer_norm(x: Floats, weight: Floats, bias: Floats) -> Floats:
    centred = x - x.mean(axis=-1, keepdims=True)
    variance = np.square(centred).mean(axis=-1, keepdims=True)
    centred /= np.sqrt(variance + _EPSILON)
    return np.asarray(centred * weight + bias)


def gelu(x: Floats) -> Floats:
    """Return the Gaussian error linear unit ``x Phi(x)`` (...) of ``x (...)``."""
    z = np.abs(x) * math.sqrt(0.5)
    t = 1.0 / (1.0 + _ERF_P * z)
    tail = np.zeros_like(t)
    for coefficient in _ERF_A:
        tail += coefficient
        tail *= t
    tail *= np.exp(-z * z)
    # Half the tail of |x|: x Phi(x) is that much below x above zero, and is it below.
    tail *= 0.5 * np.abs(x)
    return np.asarray(np.maximum(x, 0.0) - tail)


def _attention(query: Floats, key: Floats, value: Floats, bias: JointBias) -> Floats:
    out = np.empty_like(query)
    ahead = np.ascontiguousarray((key / math.sqrt(key.shape[-1])).swapaxes(-1, -2))
    padding = None if bias.mask.all() else np.where(bias.mask, 0.0, MASKED)[:, None, None, :]
    step, plan_count = rows_at_once(*ahead.shape[-2:]), bias.ours.shape[-1]
    plan, sub = slice(None, plan_count), slice(plan_count, None)
    for home, away, within in ((plan, sub, bias.ours), (sub, plan, bias.theirs)):
        for start in range(0, within.shape[-1], step):
            rows = slice(start, start + step)
            # A whole bias would be copied together for every layer; its blocks are added in place.
            weight = query[..., home, :][..., rows, :] @ ahead
            weight[..., home] += within[..., rows, :]
            weight[..., away] += bias.across[:, None, None]
            if padding is not None:
                weight += padding
            weight -= weight.max(axis=-1, keepdims=True)
            np.exp(weight, out=weight)
            part = out[..., home, :][..., rows, :]
            np.matmul(weight, value, out=part)
            part /= weight.sum(axis=-1, keepdims=True)
    return out


def _log_softmax(x: Floats, axis: int) -> Floats:
    lowered = x - x.max(axis=axis, keepdims=True)
    return np.asarray(lowered - np.log(np.exp(lowered).sum(axis=axis, keepdims=True)))


def _log_sigmoid(x: Floats) -> Floats:
    return np.asarray(-np.logaddexp(np.zeros((), dtype=x.dtype), -x))


def _identity_like(square: Floats) -> Floats:
    return np.eye(square.shape[-1], dtype=square.dtype)


NUMPY = Library(
    np, product, _linear, _mixed, _layer_norm, gelu, _attention, _log_softmax, _log_sigmoid,
    _identity_like,
)  # fmt: skip
"""On NumPy's arrays."""
