# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Counts and scores of correct region matches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.matches import IGNORE
from fpnet_lab.metrics.averages import mean


@dataclass(frozen=True)
class MatchCounts:
    """Numbers of correct, predicted and true matches."""

    correct: int
    predicted: int
    true: int

    def __add__(self, other: MatchCounts) -> MatchCounts:
        """Return the pooled counts of two pairs of graphs."""
        return MatchCounts(
            self.correct + other.correct, self.predicted + other.predicted, self.true + other.true
        )

    @property
    def precision(self) -> float:
        """Share of predicted matches that are correct; 0 without predictions."""
        return self.correct / self.predicted if self.predicted else 0.0

    @property
    def recall(self) -> float:
        """Share of true matches that were found; 1 if there were none."""
        return self.correct / self.true if self.true else 1.0

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall; 1 without true and predicted matches."""
        both = self.predicted + self.true
        return 2.0 * self.correct / both if both else 1.0


def count_matches(pairs: NDArray[np.int64], labels: NDArray[np.int64]) -> MatchCounts:
    """
    Compare ``pairs (K, 2)`` [plan, submap] with ``labels (N,)`` of the submap's regions.

    Labels are plan indices, UNMATCHED or IGNORE; predictions on IGNORE regions do not count.
    """
    truth = labels[pairs[:, 1]]
    scored = truth != IGNORE
    return MatchCounts(
        correct=int(np.count_nonzero(scored & (truth == pairs[:, 0]))),
        predicted=int(np.count_nonzero(scored)),
        true=int(np.count_nonzero(labels >= 0)),
    )


def matching_score(counts: Sequence[MatchCounts]) -> float:
    """
    Return the paper's MS: correct over predicted matches, averaged over graph pairs.

    A pair without predictions scores 0 if it has true matches, otherwise it is left out.
    """
    scores = [item.precision for item in counts if item.predicted or item.true]
    return mean(scores) or 0.0
