# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Array operations that differ between NumPy and PyTorch, and their NumPy implementation.

Importing PyTorch takes longer than matching two maps, and for graphs of a few hundred nodes its
calls cost more than NumPy's. The networks are therefore written for a :class:`Library`; training
uses another one (``fpnet_lab.training.networks.tensors``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math
from types import ModuleType
from typing import Any

import numpy as np

from fpnet_core.models import kernels
from fpnet_core.small_networks import Floats, product, rows_at_once

Array = Any
"""An array of NumPy or a tensor of PyTorch; only their common interface is used."""

MASKED = -1e4
"""Numerical: logit of padding; its ``exp`` is exactly zero in float32 and sums stay finite."""


@dataclass(frozen=True, eq=False)
class JointBias:
    """
    Additive attention bias for the nodes of two graphs, ``(B, heads, M+N, M+N)`` in blocks.

    ``ours (B, heads, M, M)`` and ``theirs (B, heads, N, N)`` apply within the graphs, ``across
    (heads,)`` between them; ``mask (B, M+N)`` is True for real nodes.
    """

    ours: Array
    theirs: Array
    across: Array
    mask: Array


@dataclass(frozen=True)
class Library:
    """
    An array library: its ``module``, and operations whose name or form differs between libraries.

    ``linear(x, weight, bias)`` maps the last axis; ``mixed(x, weight, bias)`` the last but one of
    ``x (B, F, K)``; ``attention(query, key, value, bias)`` are softmax-weighted sums of ``value
    (B, heads, M+N, d)`` with a :class:`JointBias` added to the scaled products.
    """

    module: ModuleType
    product: Callable[[Array, Array], Array]
    linear: Callable[[Array, Array, Array], Array]
    mixed: Callable[[Array, Array, Array], Array]
    layer_norm: Callable[[Array, Array, Array], Array]
    gelu: Callable[[Array], Array]
    attention: Callable[[Array, Array, Array, JointBias], Array]
    log_softmax: Callable[[Array, int], Array]
    log_sum_exp: Callable[[Array, int], Array]
    log_sigmoid: Callable[[Array], Array]
    identity_like: Callable[[Array], Array]


def _linear(x: Floats, weight: Floats, bias: Floats) -> Floats:
    out = product(x, weight.T)
    out += bias
    return out


def _mixed(x: Floats, weight: Floats, bias: Floats) -> Floats:
    # Columns of x are processed in chunks and keep their memory layout: the result is later read
    # by rows, which would otherwise not be contiguous.
    out = np.empty((len(x), len(weight), x.shape[-1]), dtype=np.result_type(x, weight))
    step = rows_at_once(*weight.shape)
    for start in range(0, x.shape[-1], step):
        part = slice(start, start + step)
        np.matmul(weight, x[..., part], out=out[..., part])
    out += bias[:, None]
    return out


def _layer_norm(x: Floats, weight: Floats, bias: Floats) -> Floats:
    out = np.empty(x.shape, dtype=x.dtype)
    width = x.shape[-1]
    kernels.layer_norm(x.reshape(-1, width), weight, bias, out.reshape(-1, width))
    return out


def gelu(x: Floats) -> Floats:
    """Return the Gaussian error linear unit ``x Phi(x)`` (...) of ``x (...)``."""
    out = np.empty(x.shape, dtype=x.dtype)
    kernels.gelu(x.reshape(-1), out.reshape(-1))
    return out


def _attention(query: Floats, key: Floats, value: Floats, bias: JointBias) -> Floats:
    out = np.empty_like(query)
    ahead = np.ascontiguousarray((key / math.sqrt(key.shape[-1])).swapaxes(-1, -2))
    padding = None if bias.mask.all() else np.where(bias.mask, 0.0, MASKED)[:, None, None, :]
    step, begin = rows_at_once(*ahead.shape[-2:]), 0
    for within in (bias.ours, bias.theirs):
        own = slice(begin, begin + within.shape[-1])
        for first in range(0, within.shape[-1], step):
            rows = slice(first, first + step)
            weight = query[..., own, :][..., rows, :] @ ahead
            if padding is not None:
                weight += padding
            # The kernel adds the bias by blocks; a full bias would be copied for every layer.
            kernels.soften(weight, within, first, begin, bias.across)
            np.matmul(weight, value, out=out[..., own, :][..., rows, :])
        begin = own.stop
    return out


def _log_softmax(x: Floats, axis: int) -> Floats:
    lowered = x - x.max(axis=axis, keepdims=True)
    return np.asarray(lowered - np.log(np.exp(lowered).sum(axis=axis, keepdims=True)))


def _log_sum_exp(x: Floats, axis: int) -> Floats:
    top = x.max(axis=axis, keepdims=True)
    return np.asarray(np.log(np.exp(x - top).sum(axis=axis)) + top.squeeze(axis))


def _log_sigmoid(x: Floats) -> Floats:
    return np.asarray(-np.logaddexp(np.zeros((), dtype=x.dtype), -x))


def _identity_like(square: Floats) -> Floats:
    return np.eye(square.shape[-1], dtype=square.dtype)


NUMPY = Library(
    np, product, _linear, _mixed, _layer_norm, gelu, _attention, _log_softmax, _log_sum_exp,
    _log_sigmoid, _identity_like,
)  # fmt: skip
"""NumPy arrays."""
