# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Selection of a short ranked list of distinct, refined, verified placements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements
from fpnet_core.pose.evidence import MapEvidence, box_corners
from fpnet_core.pose.refine import FINE, NEAR, AlignmentPrior, refine
from fpnet_core.pose.verify import COARSE_SIGMA_M, WALL_SIGMA_M, agreement, coarse_support

MAX_REFINED = 48
"""Candidates that are refined and verified; numerical: a larger number changed no result."""

MAX_ESTIMATES = 16
"""Distinct placements that are scored and reported; as in the scorer's training. Chosen."""

DISTINCT_M = 2.0
"""Placements closer than this are the same one: about half a small room. Chosen."""

_STAGES = ((60, 25), (250, 20))
"""
Numerical: per stage, samples of walls and of free space used to score a candidate, and candidates
kept per refined one.
"""

_ROUGH_POINTS = 1500
"""Numerical: samples of each kind that score roughly aligned candidates; few maps have more."""

_SAME_SCALE = 0.3
"""Log scales this close count as one; numerical: about seven between two uncertain maps."""

_SAME_BASIN_M = 0.3
"""Roughly refined candidates closer than this converge to the same placement. Chosen."""

_COMPARED_M = 5.0
"""Half the edge of the square around the robot on which placements are compared. Chosen."""


def select_promising(plan: MapEvidence, sub: MapEvidence, candidates: Placements) -> Placements:
    """
    Return the best distinct candidates by a cheap score, at most ``MAX_REFINED``.

    A first stage with few samples rejects most of the thousands of candidates.
    """
    ranked = candidates
    for points, kept in _STAGES:
        support = coarse_support(plan, sub, ranked, COARSE_SIGMA_M, points)
        order = np.argsort(-support, kind='stable')
        ranked = ranked.take(order[: kept * MAX_REFINED])
    return ranked.take(ranked.distinct(sub.corners, DISTINCT_M / 4, MAX_REFINED))


def compared_at(sub: MapEvidence, robot_xy: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """
    Return the points (4, 2) of the submap at which placements are compared.

    They lie around the robot where its position ``(2,)`` is known: placements that agree there
    and stretch the far end of the building differently give the same pose.
    Without a robot they are the corners of the map.
    """
    if robot_xy is None:
        return sub.corners
    return box_corners(robot_xy - _COMPARED_M, robot_xy + _COMPARED_M)


def aligned_placements(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Placements,
    alignment_prior: AlignmentPrior,
    robot_xy: NDArray[np.float64] | None = None,
) -> Placements:
    """
    Align candidates of any scales with the walls and score them; return the best distinct ones.

    Agreement is a share, and a map shrunk to half size finds a match for each wall more easily,
    because it covers half as many metres of the plan. The placement scorer weighs this; here
    scales take turns, so that the best placements of each scale reach it.

    Parameters
    ----------
    plan, sub : evidence of both maps
    candidates : some hundreds at most
    alignment_prior : prior on the stretch of the drawing
    robot_xy : (2,) position of the robot in the submap; None without one

    Returns
    -------
    At most ``MAX_ESTIMATES`` placements with scores and covariances, best first, scales taking
    turns; none for no candidates. They are distinct at :func:`compared_at`.
    """
    places = compared_at(sub, robot_xy)
    near = refine(plan, sub.walls, candidates, alignment_prior, NEAR)
    near = _best(_scored(plan, sub, near, _ROUGH_POINTS), places, _SAME_BASIN_M, 2 * MAX_ESTIMATES)
    fine = refine(plan, sub.walls, near, alignment_prior, FINE)
    # On a map with few walls the last step may diverge, so its input stays a candidate.
    return _best(_scored(plan, sub, fine.joined(near)), places, DISTINCT_M, MAX_ESTIMATES)


def _scored(
    plan: MapEvidence, sub: MapEvidence, placed: Placements, max_points: int | None = None
) -> Placements:
    return replace(placed, score=agreement(plan, sub, placed, WALL_SIGMA_M, max_points).score)


def _best(
    placed: Placements, places: NDArray[np.float64], distance_m: float, limit: int
) -> Placements:
    """Return the best distinct of the scored placements, scales taking turns."""
    ranked = placed.take(in_turn(placed.scale, placed.score))
    return ranked.take(ranked.distinct(places, distance_m, limit))


def in_turn(scale: NDArray[np.float64], worth: NDArray[np.float64]) -> NDArray[np.int64]:
    """
    Return the order ``(C,)`` in which scales take turns, each with its best remaining entry.

    ``scale`` and ``worth`` are ``(C,)``; worths are compared within the same scale only.
    """
    group = np.round(np.log(scale) / _SAME_SCALE)
    best_first = np.lexsort((-worth, group))
    place = np.empty(len(scale), dtype=np.int64)
    starts = np.flatnonzero(np.r_[True, np.diff(group[best_first]) != 0])
    sizes = np.diff(np.r_[starts, len(scale)])
    place[best_first] = np.arange(len(scale)) - np.repeat(starts, sizes)
    return np.asarray(np.lexsort((-worth, place)))
