# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a matcher says of two graphs: partners of regions, and whole assignments of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import Similarity2D

UNMATCHED, IGNORE = -1, -2
"""Given: label of a node without a partner, and of a node that losses and metrics leave out."""

LEAST_DECADES = 3.0
"""Chosen: pairs less probable than one in a thousand tell no more than such."""

WELL_SEEN = 0.9
"""Observed fraction from which a room's size, corners and doors are its own. Chosen."""


@dataclass(frozen=True, eq=False)
class MatchHypothesis:
    """
    One complete assignment of regions and the placement that it comes from.

    ``pairs (K, 2) int64``, columns [plan, sub], are one-to-one; ``probability`` is that of the
    whole placement, against all others and against none; ``S_plan_sub`` maps the submap graph's
    coordinates to the plan graph's.
    """

    pairs: NDArray[np.int64]
    probability: float
    S_plan_sub: Similarity2D

    def __post_init__(self) -> None:
        """Check the shape."""
        freeze_field(self, 'pairs', np.int64, (None, 2))


@dataclass(frozen=True, eq=False)
class MatchResult:
    """
    Region correspondences, columns [plan, sub].

    ``pairs (K, 2) int64`` are one-to-one, ``scores (K,)`` in [0, 1]; ``probability (M, N)`` is
    the soft assignment without its dustbins: row sums and column sums are at most 1.
    ``hypotheses`` are the best complete assignments, most probable first; empty for matchers
    that do not find any.
    """

    pairs: NDArray[np.int64]
    scores: NDArray[np.float32]
    probability: NDArray[np.float32]
    hypotheses: tuple[MatchHypothesis, ...] = ()

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        freeze_field(self, 'pairs', np.int64, (None, 2))
        freeze_field(self, 'scores', np.float32, (len(self.pairs),))
        freeze_field(self, 'probability', np.float32, (None, None))
        for column in range(2):
            if len(np.unique(self.pairs[:, column])) != len(self.pairs):
                raise ValueError('MatchResult.pairs: not one-to-one')
