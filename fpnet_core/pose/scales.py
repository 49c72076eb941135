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

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import PoseConfig
from fpnet_core.geometry import Placements
from fpnet_core.pose.estimate import SAME_BASIN_M, compared_at
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose.refine import FINE, Effort, Freedom, refine
from fpnet_core.pose.verify import agreement

_CHANCE_SCORE = 0.4
"""Agreement that any place of roughly the right size reaches."""

_NEAR = Effort((0.4, 0.3), 200)
"""Of candidates that are right within half a metre: the few walls of a small map give way to a
wider kernel and end up anywhere."""


def estimates_across_scales(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Placements,
    config: PoseConfig,
    freedom: Freedom,
    robot_xy: NDArray[np.float64] | None = None,
) -> Placements:
    """
    Refine and score candidates of any scales; the best distinct ones, best first.

    Parameters
    ----------
    plan, sub : evidence of both sides
    candidates : some dozens
    config : kernel widths and limits
    freedom : how far the drawing may be stretched
    robot_xy : (2,) where the robot is in the submap, None without one

    Returns
    -------
    At most ``max_estimates`` placements with scores and covariances, by worth and not by score;
    none for no candidates.
    """
    places = compared_at(sub, robot_xy)
    near = refine(plan, sub.walls, candidates, freedom, _NEAR)
    near = _best(plan, sub, near, config, places, SAME_BASIN_M, 2 * config.max_estimates)
    fine = refine(plan, sub.walls, near, freedom, FINE)
    # Where the map has little to hold on to, the last step may lead away.
    either = fine.joined(near)
    return _best(plan, sub, either, config, places, config.distinct_m, config.max_estimates)


def _best(
    plan: MapEvidence,
    sub: MapEvidence,
    placed: Placements,
    config: PoseConfig,
    places: NDArray[np.float64],
    distance_m: float,
    limit: int,
) -> Placements:
    """Return the best distinct placements with their scores, best first."""
    scores = agreement(plan, sub, placed, config.wall_sigma_m).score
    worth = np.sqrt(placed.scale) * (scores - _CHANCE_SCORE)
    ranked = replace(placed, score=scores).take(np.argsort(-worth, kind='stable'))
    return ranked.take(ranked.distinct(places, distance_m, limit))
