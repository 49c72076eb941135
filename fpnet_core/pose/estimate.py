# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From candidates to a short ranked list of distinct, refined, verified placements."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import PoseConfig
from fpnet_core.geometry import Affine2D
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose.hypotheses import Candidates
from fpnet_core.pose.refine import refine
from fpnet_core.pose.verify import agreement, coarse_support
from fpnet_core.types import PoseEstimate


def select_promising(
    plan: MapEvidence, sub: MapEvidence, candidates: Candidates, config: PoseConfig
) -> Candidates:
    """Return the best distinct candidates by the cheap score, at most ``max_refined``."""
    support = coarse_support(
        plan, sub, candidates.linear, candidates.translation, config.coarse_sigma_m
    )
    order = np.argsort(-support, kind='stable')
    ranked = candidates.take(order[: 20 * config.max_refined])
    keep = distinct(ranked, sub, config.distinct_m / 4, config.max_refined)
    return ranked.take(keep)


def verified_estimates(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Candidates,
    config: PoseConfig,
    anneal_from_m: float = np.inf,
) -> tuple[PoseEstimate, ...]:
    """
    Refine and score the candidates; the best distinct ones, best first.

    Parameters
    ----------
    plan, sub : evidence of both sides
    candidates : few, promising
    config : kernel widths and limits
    anneal_from_m : widest refinement kernel; narrow for hypotheses that are being tracked

    Returns
    -------
    At most ``max_estimates`` estimates; empty for no candidates. A refined placement whose
    scale left the allowed range is dropped.
    """
    refined = refine(
        plan, sub, candidates.linear, candidates.translation, config.strain_sigma, anneal_from_m
    )
    scores = agreement(plan, sub, refined.linear, refined.translation, config.wall_sigma_m).score
    order = np.argsort(-scores, kind='stable')
    ranked = Candidates(refined.linear[order], refined.translation[order])
    keep = distinct(ranked, sub, config.distinct_m, config.max_estimates)
    return tuple(
        PoseEstimate(
            Affine2D(ranked.linear[k], ranked.translation[k]),
            float(scores[order[k]]),
            refined.cov[order[k]],
        )
        for k in keep
    )


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
    kept: list[int] = []
    for index in range(len(ranked)):
        moved = np.linalg.norm(placed[kept] - placed[index], axis=-1).mean(axis=-1)
        if np.all(moved > distance_m):
            kept.append(index)
            if len(kept) == limit:
                break
    return np.array(kept, dtype=np.int64)
