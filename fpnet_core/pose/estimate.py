# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From candidates to a short ranked list of distinct, refined, verified placements."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import PoseConfig
from fpnet_core.geometry import Affine2D
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose.hypotheses import Candidates
from fpnet_core.pose.refine import FINE, ROUGH, refine
from fpnet_core.pose.verify import agreement, coarse_support
from fpnet_core.types import PoseEstimate

_GLANCE_POINTS, _GLANCE_KEEPS = 60, 25
_LOOK_POINTS, _LOOK_KEEPS = 250, 20
"""Wall and free samples of a look at a candidate, and how many per refined one it keeps."""

_SAME_BASIN_M = 0.3
"""Roughly refined candidates nearer than this end at the same place."""


def select_promising(
    plan: MapEvidence, sub: MapEvidence, candidates: Candidates, config: PoseConfig
) -> Candidates:
    """
    Return the best distinct candidates by the cheap score, at most ``max_refined``.

    A glance at few samples drops most of the thousands before the others are looked at well.
    """
    ranked = candidates
    for points, kept in ((_GLANCE_POINTS, _GLANCE_KEEPS), (_LOOK_POINTS, _LOOK_KEEPS)):
        support = coarse_support(
            plan, sub, ranked.linear, ranked.translation, config.coarse_sigma_m, points
        )
        order = np.argsort(-support, kind='stable')
        ranked = ranked.take(order[: kept * config.max_refined])
    return ranked.take(distinct(ranked, sub, config.distinct_m / 4, config.max_refined))


def verified_estimates(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Candidates,
    config: PoseConfig,
    strain_sigma: float,
) -> tuple[PoseEstimate, ...]:
    """
    Refine and score the candidates; the best distinct ones, best first.

    All are refined roughly; the ``max_estimates`` best places, and their rivals nearby, finely.

    Parameters
    ----------
    plan, sub : evidence of both sides
    candidates : few, promising
    config : kernel widths and limits
    strain_sigma : standard deviation of the drawing's strain beyond the candidates' own

    Returns
    -------
    At most ``max_estimates`` estimates; empty for no candidates.
    """
    near = _roughly_refined(plan, sub, candidates, config, strain_sigma)
    fine = refine(plan, sub, near.linear, near.translation, strain_sigma, FINE)
    scores = agreement(plan, sub, fine.linear, fine.translation, config.wall_sigma_m).score
    order = np.argsort(-scores, kind='stable')
    ranked = Candidates(fine.linear[order], fine.translation[order])
    keep = distinct(ranked, sub, config.distinct_m, config.max_estimates)
    return tuple(
        PoseEstimate(
            Affine2D(ranked.linear[k], ranked.translation[k]),
            float(scores[order[k]]),
            fine.cov[order[k]],
        )
        for k in keep
    )


def _roughly_refined(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Candidates,
    config: PoseConfig,
    strain_sigma: float,
) -> Candidates:
    """Return the candidates moved to where they fit best nearby; only those worth more work."""
    rough = refine(plan, sub, candidates.linear, candidates.translation, strain_sigma, ROUGH)
    support = coarse_support(
        plan, sub, rough.linear, rough.translation, config.wall_sigma_m, _LOOK_POINTS
    )
    order = np.argsort(-support, kind='stable')
    ranked = Candidates(rough.linear[order], rough.translation[order])
    return ranked.take(distinct(ranked, sub, _SAME_BASIN_M, 2 * config.max_estimates))


def distinct(
    ranked: Candidates, sub: MapEvidence, distance_m: float, limit: int
) -> NDArray[np.int64]:
    """
    Indices of candidates that place the submap differently from every better one.

    Two placements differ when the corners of the submap's bounding box land more than
    ``distance_m`` apart on average. ``ranked`` is best first; at most ``limit`` indices are
    returned.
    """
    if len(ranked) == 0:
        return np.zeros(0, dtype=np.int64)
    points = sub.walls if len(sub.walls) else sub.free
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.array([low, high, [low[0], high[1]], [high[0], low[1]]])
    placed = np.einsum('cij,kj->cki', ranked.linear, corners) + ranked.translation[:, None]
    return _first_of_each(np.ascontiguousarray(placed), distance_m, limit)


@numba.njit(cache=True, nogil=True)
def _first_of_each(
    placed: NDArray[np.float64], distance_m: float, limit: int
) -> NDArray[np.int64]:
    """Greedy choice among corner sets (C, 4, 2): each farther than the distance from all kept."""
    kept = np.empty(min(limit, len(placed)), dtype=np.int64)
    count = 0
    for index in range(len(placed)):
        is_new = True
        for k in kept[:count]:
            moved = 0.0
            for corner in range(placed.shape[1]):
                dx = placed[k, corner, 0] - placed[index, corner, 0]
                dy = placed[k, corner, 1] - placed[index, corner, 1]
                moved += np.hypot(dx, dy)
            if moved <= distance_m * placed.shape[1]:
                is_new = False
                break
        if is_new:
            kept[count] = index
            count += 1
            if count == limit:
                break
    return kept[:count]
