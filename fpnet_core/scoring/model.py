# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Network of the placement scorer: from features to the log odds of each placement and of none.

The same small network processes the features of each placement, so that their order does not
matter; pooled features of the best and of all give the odds of "correct plan, but none of these"
and of "plan of another building". Several networks with different seeds are averaged by their log
probabilities. Evaluation needs no deep-learning framework.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.weights import Weights, check_shapes, network_of, read_weights
from fpnet_core.scoring.evidence import CONTEXT, FIGURES, Evidence
from fpnet_core.small_networks import silu, standardised

Array = NDArray[np.float64]

SCORER_SCHEMA = 1
"""Given: incremented when a feature changes its meaning."""

SCORER_NAME = 'scorer.safetensors'


@dataclass(frozen=True, eq=False)
class PlacementModel:
    """
    Weights of the network: ``tensors`` of all ``members``, which are the first axis.

    Letters: ``D`` features, ``G`` context features, ``h`` width. ``figure_mean``, ``figure_scale
    (D,)``, ``context_mean``, ``context_scale (G,)`` standardise; ``first (m, h, D + G)``,
    ``second (m, h, h)``, ``value (m, h)``, ``direct (m, D)`` process one placement; ``none_first
    (m, h, 2 h + G)`` and ``none_second (m, 2, h)`` process all; biases are named accordingly.
    """

    tensors: dict[str, NDArray[np.float32]]

    @classmethod
    def indifferent(cls) -> PlacementModel:
        """Return a model with zero weights: all hypotheses are equally probable."""
        zeros = {name: np.zeros(shape, np.float32) for name, shape in shapes(1, 1).items()}
        ones = ('figure_scale', 'context_scale')
        return cls(zeros | {name: np.ones_like(zeros[name]) for name in ones})

    @property
    def members(self) -> int:
        """Number of networks in the ensemble."""
        return len(self.tensors['value'])

    def log_probability(self, evidence: Evidence) -> Array:
        """
        Return ``(C + 2,)``: each placement, none of them, and another building's plan.

        The prior odds of the plan are even. Without placements the last two remain.
        """
        t = self._doubles
        x = standardised(evidence.figures, t['figure_mean'], t['figure_scale'])
        g = standardised(evidence.context, t['context_mean'], t['context_scale'])
        return _normalised(np.mean(self._votes(x, g), axis=0))

    @cached_property
    def _doubles(self) -> dict[str, Array]:
        return {name: value.astype(np.float64) for name, value in self.tensors.items()}

    def _votes(self, x: Array, g: Array) -> Array:
        """Return each member's ``(m, C + 2)`` for features ``(C, D)`` and context ``(G,)``."""
        t, members = self._doubles, self.members
        inputs = np.concatenate([x, np.broadcast_to(g, (len(x), len(g)))], axis=1)
        hidden = silu(inputs @ t['first'].swapaxes(1, 2) + t['first_bias'][:, None])
        hidden = silu(hidden @ t['second'].swapaxes(1, 2) + t['second_bias'][:, None])
        scores = _times(hidden, t['value']) + t['direct'] @ x.T + t['value_bias'][:, None]
        pooled = mean = np.zeros((members, hidden.shape[2]))
        if len(x):
            share = np.exp(_normalised(scores))
            pooled, mean = _times(hidden.swapaxes(1, 2), share), hidden.mean(axis=1)
        whole = np.concatenate([pooled, mean, np.broadcast_to(g, (members, len(g)))], axis=1)
        none = silu(_times(t['none_first'], whole) + t['none_first_bias'])
        none = _times(t['none_second'], none) + t['none_second_bias']
        return _normalised(np.concatenate([scores, none], axis=1))


def _times(matrices: Array, vectors: Array) -> Array:
    """Return each member's matrix ``(m, R, K)`` times its vector ``(m, K)``, ``(m, R)``."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])


def _normalised(logits: Array) -> Array:
    return np.asarray(logits - np.logaddexp.reduce(logits, axis=-1, keepdims=True))


def read_scorer(path: Path | None = None) -> PlacementModel:
    """
    Read a trained placement scorer; None reads the packaged one.

    Raises
    ------
    WeightsError
        If the file is missing or damaged, or was made for other features.
    """
    return model_of(read_weights(path, SCORER_SCHEMA, SCORER_NAME))


def model_of(weights: Weights) -> PlacementModel:
    """Return the model stored in a checkpoint."""
    names = {'figures': FIGURES, 'context': CONTEXT}
    network = network_of(weights, 'placement scorer', names, 'train scorer')
    expected = shapes(network['members'], network['width'])
    check_shapes('scorer weights', weights.tensors, expected)
    return PlacementModel(weights.tensors)


def shapes(members: int, width: int) -> dict[str, tuple[int, ...]]:
    """Return the shape of every tensor."""
    d, g, m, h = len(FIGURES), len(CONTEXT), members, width
    return {
        'figure_mean': (d,), 'figure_scale': (d,), 'context_mean': (g,), 'context_scale': (g,),
        'first': (m, h, d + g), 'first_bias': (m, h),
        'second': (m, h, h), 'second_bias': (m, h),
        'value': (m, h), 'value_bias': (m,), 'direct': (m, d),
        'none_first': (m, h, 2 * h + g), 'none_first_bias': (m, h),
        'none_second': (m, 2, h), 'none_second_bias': (m, 2),
    }  # fmt: skip
