# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Verified placements of very different scales.

Agreement is a share, and a map that is shrunk to half finds a place for each of its walls more
easily: it covers half as many metres of the plan. What that is worth is for the judge to say; here
scales take turns, so that each brings its best placements before it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements
from fpnet_core.pose.estimate import DISTINCT_M, MAX_ESTIMATES, SAME_BASIN_M, compared_at
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose.refine import FINE, Effort, Freedom, refine
from fpnet_core.pose.verify import WALL_SIGMA_M, agreement

_SAME_SCALE = 0.3
"""Scales this near, in their logarithm, are one; numerical: some seven between two unsure maps."""

_NEAR = Effort((0.4, 0.3), 200)
"""
Of candidates that are right within half a metre: the few walls of a small map give way to a wider
kernel and end up anywhere. Chosen.
"""

_LOOK_POINTS = 1500
"""Numerical: samples of each kind of which the roughly aligned are scored; few maps have more."""


def estimates_across_scales(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Placements,
    freedom: Freedom,
    robot_xy: NDArray[np.float64] | None = None,
) -> Placements:
    """
    Refine and score candidates of any scales; the best distinct ones, best first.

    Parameters
    ----------
    plan, sub : evidence of both sides
    candidates : some dozens
    freedom : how far the drawing may be stretched
    robot_xy : (2,) where the robot is in the submap, None without one

    Returns
    -------
    At most ``MAX_ESTIMATES`` placements with scores and covariances, scales taking turns; none
    for no candidates.
    """
    places = compared_at(sub, robot_xy)
    near = refine(plan, sub.walls, candidates, freedom, _NEAR)
    near = _best(_scored(plan, sub, near, _LOOK_POINTS), places, SAME_BASIN_M, 2 * MAX_ESTIMATES)
    fine = refine(plan, sub.walls, near, freedom, FINE)
    # Where the map has little to hold on to, the last step may lead away.
    return _best(_scored(plan, sub, fine.joined(near)), places, DISTINCT_M, MAX_ESTIMATES)


def _scored(
    plan: MapEvidence, sub: MapEvidence, placed: Placements, max_points: int | None = None
) -> Placements:
    return replace(placed, score=agreement(plan, sub, placed, WALL_SIGMA_M, max_points).score)


def _best(
    placed: Placements, places: NDArray[np.float64], distance_m: float, limit: int
) -> Placements:
    """Return the best distinct ones of scored placements, scales taking turns."""
    ranked = placed.take(in_turn(placed.scale, placed.score))
    return ranked.take(ranked.distinct(places, distance_m, limit))


def in_turn(scale: NDArray[np.float64], worth: NDArray[np.float64]) -> NDArray[np.int64]:
    """
    Return the order ``(C,)`` in which scales take turns, each with the best that it still has.

    ``scale`` and ``worth`` are ``(C,)``; a worth is compared with those of its own scale only.
    """
    group = np.round(np.log(scale) / _SAME_SCALE)
    best_first = np.lexsort((-worth, group))
    place = np.empty(len(scale), dtype=np.int64)
    starts = np.flatnonzero(np.r_[True, np.diff(group[best_first]) != 0])
    sizes = np.diff(np.r_[starts, len(scale)])
    place[best_first] = np.arange(len(scale)) - np.repeat(starts, sizes)
    return np.asarray(np.lexsort((-worth, place)))
