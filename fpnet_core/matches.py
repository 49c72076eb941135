# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results of a matcher for two graphs: region pairs and complete assignments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import Similarity2D

UNMATCHED, IGNORE = -1, -2
"""Given: label of a node without a partner, and of a node that losses and metrics ignore."""

LEAST_DECADES = 3.0
"""Chosen: pairs less probable than one in a thousand are treated alike."""

WELL_SEEN = 0.9
"""Observed fraction from which the size, corners and doors of a room are reliable. Chosen."""


@dataclass(frozen=True, eq=False)
class MatchHypothesis:
    """
    One complete assignment of regions and the placement that it is based on.

    ``pairs (K, 2) int64``, columns [plan, sub], are one-to-one; ``probability`` is that of the
    whole placement against all others and against none; ``S_plan_sub`` maps the coordinates of
    the submap graph to those of the plan graph.
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
    that compute none.
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
