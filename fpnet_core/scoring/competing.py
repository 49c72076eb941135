# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pairwise comparison of placements where they disagree; symmetric evidence cancels out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.scoring import kernels

Array = NDArray[np.float64]
Figures = dict[str, Array]

NOISE_M = 1.0
"""Contested length that counts as noise: walls are observed in pieces this long. Chosen."""

_ALONE = (
    'rival_net', 'rival_bent_net', 'rival_z', 'rival_contested',
    'rival_doors', 'rival_rooms', 'rival_match', 'rival_denied',
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Explained:
    """
    Which of a submap's walls each of ``C`` placements explains.

    ``likelihood`` and ``bent_likelihood (C, P)`` are those of the wall samples on the plan as
    drawn and deformed; a sample represents ``metres``. Placements of one submap on different plans
    use the same samples.
    """

    likelihood: NDArray[np.float32]
    bent_likelihood: NDArray[np.float32]
    metres: float

    def take(self, index: NDArray[np.int64]) -> Explained:
        """Return the values of the placements at ``index``."""
        return Explained(self.likelihood[index], self.bent_likelihood[index], self.metres)

    def joined(self, other: Explained) -> Explained:
        """Return the values of the placements of both."""
        return Explained(
            np.concatenate([self.likelihood, other.likelihood]),
            np.concatenate([self.bent_likelihood, other.bent_likelihood]),
            self.metres,
        )


def rival_figures(figures: Figures, explained: Explained) -> Figures:
    """Return each placement's features relative to its strongest competitor, ``(C,)`` each."""
    count = len(explained.likelihood)
    if count == 1:
        alone = dict.fromkeys(_ALONE, np.zeros(1))
        return alone | {
            'rival_score': figures['score'],
            'rival_bent_score': figures['bent_score'],
        }
    net, total = kernels.contested(explained.likelihood)
    bent_net, _ = kernels.contested(explained.bent_likelihood)
    other = ~np.eye(count, dtype=np.bool_)
    rows = np.arange(count)
    # The strongest competitor explains most of the walls that only one of the two explains.
    strongest = np.where(other, bent_net, np.inf).argmin(axis=1)
    net_m, bent_m, total_m = (
        x[rows, strongest] * explained.metres for x in (net, bent_net, total)
    )
    match = figures['match_rooms'] + figures['match_doors']
    return {
        'rival_net': _signed_log(net_m),
        'rival_bent_net': _signed_log(bent_m),
        'rival_z': bent_m / np.sqrt(total_m + NOISE_M),
        'rival_contested': np.log1p(total_m),
        'rival_score': _less_best_other(figures['score'], other),
        'rival_bent_score': _less_best_other(figures['bent_score'], other),
        'rival_doors': figures['doors_met'] - figures['doors_met'][strongest],
        'rival_rooms': _less_best_other(figures['rooms_pure'], other),
        'rival_match': _less_best_other(match, other),
        'rival_denied': figures['denied_m'] - figures['denied_m'][strongest],
    }


def _signed_log(values: Array) -> Array:
    return np.asarray(np.sign(values) * np.log1p(np.abs(values)))


def _less_best_other(values: Array, other: NDArray[np.bool_]) -> Array:
    return np.asarray(values - np.where(other, values, -np.inf).max(axis=1))
