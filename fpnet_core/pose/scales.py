# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Verified placements of very different scales, compared fairly.

Agreement is a share, and a map that is shrunk to half finds a place for each of its walls more
easily: it covers half as many metres of the plan. Where scales differ, a score above what any
place reaches by chance therefore counts more the more metres of the plan it explains; with the
root of the scale, since walls of one building are not independent.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import PoseConfig
from fpnet_core.geometry import Affine2D
from fpnet_core.pose.estimate import SAME_BASIN_M, distinct
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose.hypotheses import Candidates
from fpnet_core.pose.refine import FINE, Effort, Freedom, Refined, refine
from fpnet_core.pose.verify import agreement
from fpnet_core.types import PoseEstimate

Array = NDArray[np.float64]

_CHANCE_SCORE = 0.4
"""Agreement that any place of roughly the right size reaches."""

_NEAR = Effort((0.4, 0.3), 200)
"""Of candidates that are right within half a metre: the few walls of a small map give way to a
wider kernel and end up anywhere."""

_LOOKED_AT = 3
"""So many times the reported placements are refined finely."""


def estimates_across_scales(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Candidates,
    config: PoseConfig,
    freedom: Freedom,
) -> tuple[PoseEstimate, ...]:
    """
    Refine and score candidates of any scales; the best distinct ones, best first.

    Parameters
    ----------
    plan, sub : evidence of both sides
    candidates : some dozens
    config : kernel widths and limits
    freedom : how far the drawing may be stretched

    Returns
    -------
    At most ``max_estimates`` estimates, by worth and not by score; empty for no candidates.
    """
    near = refine(plan, sub.walls, candidates.linear, candidates.translation, freedom, _NEAR)
    best, _ = _ranked(plan, sub, near, config, SAME_BASIN_M, _LOOKED_AT * config.max_estimates)
    near = Refined(near.linear[best], near.translation[best], near.cov[best])
    fine = refine(plan, sub.walls, near.linear, near.translation, freedom, FINE)
    # Where the map has little to hold on to, the last step may lead away.
    either = Refined(
        np.concatenate([fine.linear, near.linear]),
        np.concatenate([fine.translation, near.translation]),
        np.concatenate([fine.cov, near.cov]),
    )
    best, scores = _ranked(plan, sub, either, config, config.distinct_m, config.max_estimates)
    return tuple(
        PoseEstimate(
            Affine2D(either.linear[k], either.translation[k]), float(scores[k]), either.cov[k]
        )
        for k in best
    )


def scale_of(linear: Array) -> Array:
    """Return the mean scale (...) of linear parts (..., 2, 2)."""
    return np.asarray(np.sqrt(np.abs(np.linalg.det(linear))), dtype=np.float64)


def _ranked(
    plan: MapEvidence,
    sub: MapEvidence,
    placed: Refined,
    config: PoseConfig,
    distance_m: float,
    limit: int,
) -> tuple[NDArray[np.int64], Array]:
    """Return indices of the best distinct placements, best first, and the scores of all (C,)."""
    linear, translation = placed.linear, placed.translation
    scores = agreement(plan, sub, linear, translation, config.wall_sigma_m).score
    worth = np.sqrt(scale_of(linear)) * (scores - _CHANCE_SCORE)
    order = np.argsort(-worth, kind='stable')
    ranked = Candidates(linear[order], translation[order])
    return order[distinct(ranked, sub.corners, distance_m, limit)], scores
