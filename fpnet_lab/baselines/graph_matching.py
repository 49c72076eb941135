# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Classical graph matching as region matchers, solved by pygmtools on its NumPy backend.

The affinity of two pairs of regions decreases with the difference of their distances, in the
nominal metres of each map; the affinity of one pair with the difference of its descriptors.
Rooms and doors are matched separately: the affinity matrix has (M N)^2 entries.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from fpnet_core.graphs.layout import POSITION
from fpnet_core.matches import MatchResult
from fpnet_core.matching import mutual_pairs
from fpnet_core.types import RegionGraph, RegionLabel

Array = NDArray[np.float64]

DISTANCE_M = 1.0
"""Difference of two distances at which their affinity has decayed to exp(-1/2). Chosen."""

DESCRIPTOR = 3.0
"""Descriptor distance at which the affinity of a pair has decayed to exp(-1/2). Chosen."""

MAX_PAIRS = 1600
"""Numerical: most pairs of regions; only the most similar are kept: 20 MB of affinities."""


class GraphMatchingMatcher:
    """
    Matcher that maximizes pairwise affinity with one of pygmtools' solvers.

    ``solver`` is its name in pygmtools: ``rrwm`` for reweighted random walks, ``sm`` for the
    leading eigenvector of the affinity matrix.
    """

    def __init__(self, solver: str) -> None:
        import pygmtools

        self._solver: Callable[..., Any] = getattr(pygmtools, solver)

    def match(self, plan: RegionGraph, sub: RegionGraph, explored_area_m2: float) -> MatchResult:
        """Return the solver's assignment; it assigns as many submap regions as possible."""
        del explored_area_m2
        soft = np.zeros((len(plan), len(sub)))
        for label in RegionLabel:
            rows, columns = (
                np.array([r.id for r in graph.regions if r.label is label], dtype=np.int64)
                for graph in (plan, sub)
            )
            if len(rows) and len(columns):
                soft[np.ix_(rows, columns)] = self._solve(plan, sub, rows, columns)
        total = max(
            float(soft.sum(axis=0).max(initial=0.0)), float(soft.sum(axis=1).max(initial=0.0))
        )
        soft = soft / max(total, np.finfo(np.float64).tiny)
        pairs = mutual_pairs(soft, 0.0)
        scores = soft[pairs[:, 0], pairs[:, 1]]
        return MatchResult(pairs, scores.astype(np.float32), soft.astype(np.float32))

    def _solve(
        self,
        plan: RegionGraph,
        sub: RegionGraph,
        rows: NDArray[np.int64],
        columns: NDArray[np.int64],
    ) -> Array:
        affinity, kept = _affinity(plan, sub, rows, columns)
        soft = np.zeros((len(kept), len(columns)))
        soft[:] = self._solver(affinity, len(kept), len(columns), backend='numpy')
        full = np.zeros((len(rows), len(columns)))
        full[kept] = soft.clip(0.0)
        return full


def _affinity(
    plan: RegionGraph, sub: RegionGraph, rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> tuple[Array, NDArray[np.int64]]:
    """
    Return the affinity matrix over pairs, plan index fastest, and the ``rows`` it covers.

    With too many pairs, the plan regions least similar to any submap region are left out.
    """
    shape = slice(POSITION.stop, None)
    likeness = np.exp(
        -0.5
        * (cdist(plan.node_feat[rows, shape], sub.node_feat[columns, shape]) / DESCRIPTOR) ** 2
    )
    limit = max(1, MAX_PAIRS // len(columns))
    kept = np.sort(np.argsort(-likeness.max(axis=1), kind='stable')[:limit])
    plan_xy = np.array([plan.regions[i].centroid for i in rows[kept]])
    sub_xy = np.array([sub.regions[j].centroid for j in columns])
    between = cdist(plan_xy, plan_xy), cdist(sub_xy, sub_xy)
    # Entry (j, i, l, k) is for the pairs (i, j) and (k, l): pygmtools stacks by columns.
    gap = between[0][None, :, None, :] - between[1][:, None, :, None]
    affinity = np.exp(-0.5 * (gap / DISTANCE_M) ** 2)
    own_plan, own_sub = np.eye(len(kept), dtype=bool), np.eye(len(columns), dtype=bool)
    conflict = own_plan[None, :, None, :] ^ own_sub[:, None, :, None]
    affinity = np.where(conflict, 0.0, affinity).reshape(2 * [len(kept) * len(columns)])
    np.fill_diagonal(affinity, likeness[kept].T.ravel())
    return affinity, kept
