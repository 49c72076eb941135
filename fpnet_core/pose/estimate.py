# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From candidates to a short ranked list of distinct, refined, verified placements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements
from fpnet_core.pose.evidence import MapEvidence, box_corners
from fpnet_core.pose.refine import FINE, NEAR, AlignmentPrior, refine
from fpnet_core.pose.verify import COARSE_SIGMA_M, WALL_SIGMA_M, agreement, coarse_support

MAX_REFINED = 48
"""Candidates that are refined and verified; numerical: more changed no answer."""

MAX_ESTIMATES = 16
"""Distinct placements that are judged and reported; the judge was trained with so many. Chosen."""

DISTINCT_M = 2.0
"""Placements nearer than this are the same one: about half a small room. Chosen."""

_STAGES = ((60, 25), (250, 20))
"""
Numerical: wall and free samples by which a candidate is scored, and how many per refined one are
kept by it.
"""

_LOOK_POINTS = 1500
"""Numerical: samples of each kind of which the roughly aligned are scored; few maps have more."""

_SAME_SCALE = 0.3
"""Scales this near, in their logarithm, are one; numerical: some seven between two unsure maps."""

_SAME_BASIN_M = 0.3
"""Roughly refined candidates nearer than this end at the same place. Chosen."""

_SURROUNDINGS_M = 5.0
"""Placements are told apart by where they put what is so far from the robot. Chosen."""


def select_promising(plan: MapEvidence, sub: MapEvidence, candidates: Placements) -> Placements:
    """
    Return the best distinct candidates by the cheap score, at most ``MAX_REFINED``.

    A glance at few samples drops most of the thousands before the others are looked at well.
    """
    ranked = candidates
    for points, kept in _STAGES:
        support = coarse_support(plan, sub, ranked, COARSE_SIGMA_M, points)
        order = np.argsort(-support, kind='stable')
        ranked = ranked.take(order[: kept * MAX_REFINED])
    return ranked.take(ranked.distinct(sub.corners, DISTINCT_M / 4, MAX_REFINED))


def compared_at(sub: MapEvidence, robot_xy: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """
    Return the points (4, 2) of the submap by which placements are told apart.

    They lie around the robot where it is known, ``(2,)``: two placements that agree on it and
    differ in how far they stretch the other end of the building say the same of the robot.
    Without a robot they are the corners of the map.
    """
    if robot_xy is None:
        return sub.corners
    return box_corners(robot_xy - _SURROUNDINGS_M, robot_xy + _SURROUNDINGS_M)


def aligned_placements(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Placements,
    alignment_prior: AlignmentPrior,
    robot_xy: NDArray[np.float64] | None = None,
) -> Placements:
    """
    Align candidates of any scales with the walls and score them; the best distinct ones first.

    Agreement is a share, and a map that is shrunk to half finds a place for each of its walls more
    easily: it covers half as many metres of the plan. What that is worth is for the placement
    scorer to say; here scales take turns, so that each brings its best placements before it.

    Parameters
    ----------
    plan, sub : evidence of both sides
    candidates : some hundreds at most
    freedom : how far the drawing may be stretched
    robot_xy : (2,) where the robot is in the submap, None without one

    Returns
    -------
    At most ``MAX_ESTIMATES`` placements with scores and covariances, best first, scales taking
    turns; none for no candidates. They are distinct at :func:`compared_at`.
    """
    places = compared_at(sub, robot_xy)
    near = refine(plan, sub.walls, candidates, alignment_prior, NEAR)
    near = _best(_scored(plan, sub, near, _LOOK_POINTS), places, _SAME_BASIN_M, 2 * MAX_ESTIMATES)
    fine = refine(plan, sub.walls, near, alignment_prior, FINE)
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
