# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The judge's network: from figures to how much speaks for each placement and for none of them.

Each placement's figures go through the same small network, so that their order is of no
importance; what it makes of the best and of all together weighs "the plan is right but none of
these is" and "the plan is of another building". A few networks of different seeds vote by their
mean log probability. It is evaluated without a deep-learning framework.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from fpnet_core.io.weights import Weights, check_shapes, network_of, read_weights
from fpnet_core.judging.evidence import CONTEXT, FIGURES, Evidence
from fpnet_core.small_networks import silu, standardised

Array = NDArray[np.float64]

JUDGE_SCHEMA = 1
"""Given: grows when a figure changes its meaning."""

JUDGE_NAME = 'judge.safetensors'


@dataclass(frozen=True, eq=False)
class JudgeModel:
    """
    ``tensors`` of all members, the first axis counts them; ``members`` is how many.

    Letters: ``D`` figures, ``G`` context figures, ``h`` width. ``figure_mean``, ``figure_scale
    (D,)``, ``context_mean``, ``context_scale (G,)`` standardise; ``first (m, h, D + G)``,
    ``second (m, h, h)``, ``value (m, h)``, ``direct (m, D)`` see a placement; ``none_first
    (m, h, 2 h + G)`` and ``none_second (m, 2, h)`` see all of them; biases are called alike.
    """

    tensors: dict[str, NDArray[np.float32]]

    @classmethod
    def indifferent(cls) -> JudgeModel:
        """Return a model that knows nothing: all that may be is equally probable."""
        zeros = {name: np.zeros(shape, np.float32) for name, shape in shapes(1, 1).items()}
        ones = ('figure_scale', 'context_scale')
        return cls(zeros | {name: np.ones_like(zeros[name]) for name in ones})

    @property
    def members(self) -> int:
        """Count the networks that vote."""
        return len(self.tensors['value'])

    def log_probability(self, evidence: Evidence) -> Array:
        """
        Return ``(C + 2,)``: of each placement, of none here, and of another building's plan.

        The plan is taken for the right one at even odds. No placements leave the last two.
        """
        t = {name: value.astype(np.float64) for name, value in self.tensors.items()}
        x = standardised(evidence.figures, t['figure_mean'], t['figure_scale'])
        g = standardised(evidence.context, t['context_mean'], t['context_scale'])
        votes = [self._vote(t, m, x, g) for m in range(self.members)]
        return _normalised(np.mean(votes, axis=0))

    @staticmethod
    def _vote(t: dict[str, Array], m: int, x: Array, g: Array) -> Array:
        inputs = np.concatenate([x, np.broadcast_to(g, (len(x), len(g)))], axis=1)
        hidden = silu(inputs @ t['first'][m].T + t['first_bias'][m])
        hidden = silu(hidden @ t['second'][m].T + t['second_bias'][m])
        scores = hidden @ t['value'][m] + x @ t['direct'][m] + t['value_bias'][m]
        share = np.exp(scores - scores.max()) if len(x) else scores
        pooled = share / share.sum() @ hidden if len(x) else np.zeros(hidden.shape[1])
        mean = hidden.mean(axis=0) if len(x) else np.zeros(hidden.shape[1])
        whole = np.concatenate([pooled, mean, g])
        none = silu(t['none_first'][m] @ whole + t['none_first_bias'][m])
        none = t['none_second'][m] @ none + t['none_second_bias'][m]
        return _normalised(np.concatenate([scores, none]))


def _normalised(logits: Array) -> Array:
    return np.asarray(logits - logsumexp(logits))


def read_judge(path: Path | None = None) -> JudgeModel:
    """
    Read a trained judge; None reads the packaged one.

    Raises
    ------
    WeightsError
        If a file is missing or damaged, or was made for other figures.
    """
    return model_of(read_weights(path, JUDGE_SCHEMA, JUDGE_NAME))


def model_of(weights: Weights) -> JudgeModel:
    """Return the model that a checkpoint holds."""
    names = {'figures': FIGURES, 'context': CONTEXT}
    network = network_of(weights, 'judge', names, 'train-judge')
    expected = shapes(network['members'], network['width'])
    check_shapes('judge weights', weights.tensors, expected)
    return JudgeModel(weights.tensors)


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
