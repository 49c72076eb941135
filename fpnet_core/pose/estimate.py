# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From candidates to a short ranked list of distinct, refined, verified placements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements
from fpnet_core.pose.evidence import MapEvidence, box_corners
from fpnet_core.pose.refine import FINE, ROUGH, Freedom, refine
from fpnet_core.pose.verify import COARSE_SIGMA_M, WALL_SIGMA_M, agreement, coarse_support

MAX_REFINED = 48
"""Candidates that are refined and verified; numerical: more changed no answer."""

MAX_ESTIMATES = 16
"""Distinct placements that are judged and reported; the judge was trained with so many. Chosen."""

DISTINCT_M = 2.0
"""Placements nearer than this are the same one: about half a small room. Chosen."""

_GLANCE_POINTS, _GLANCE_KEEPS = 60, 25
_LOOK_POINTS, _LOOK_KEEPS = 250, 20
"""
Numerical: wall and free samples of a look at a candidate, and how many per refined one it keeps.
"""

SAME_BASIN_M = 0.3
"""Roughly refined candidates nearer than this end at the same place. Chosen."""

_SURROUNDINGS_M = 5.0
"""Placements are told apart by where they put what is so far from the robot. Chosen."""


def select_promising(plan: MapEvidence, sub: MapEvidence, candidates: Placements) -> Placements:
    """
    Return the best distinct candidates by the cheap score, at most ``MAX_REFINED``.

    A glance at few samples drops most of the thousands before the others are looked at well.
    """
    ranked = candidates
    for points, kept in ((_GLANCE_POINTS, _GLANCE_KEEPS), (_LOOK_POINTS, _LOOK_KEEPS)):
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


def verified_estimates(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Placements,
    freedom: Freedom,
    robot_xy: NDArray[np.float64] | None = None,
) -> Placements:
    """
    Refine and score the candidates; the best distinct ones, best first.

    All are refined roughly; the ``MAX_ESTIMATES`` best places, and their rivals nearby, finely.
    Placements are distinct where they disagree on :func:`compared_at`.

    Parameters
    ----------
    plan, sub : evidence of both sides
    candidates : few, promising
    freedom : how far the drawing may be stretched
    robot_xy : (2,) where the robot is in the submap, None without one

    Returns
    -------
    At most ``MAX_ESTIMATES`` placements with scores and covariances; none for no candidates.
    """
    rough = refine(plan, sub.walls, candidates, freedom, ROUGH)
    places = compared_at(sub, robot_xy)
    near = _worth_more(plan, sub, rough, places)
    fine = refine(plan, sub.walls, near, freedom, FINE)
    scores = agreement(plan, sub, fine, WALL_SIGMA_M).score
    ranked = replace(fine, score=scores).take(np.argsort(-scores, kind='stable'))
    return ranked.take(ranked.distinct(places, DISTINCT_M, MAX_ESTIMATES))


def _worth_more(
    plan: MapEvidence,
    sub: MapEvidence,
    rough: Placements,
    places: NDArray[np.float64],
) -> Placements:
    """Return the roughly refined candidates that are worth more work, one of each place."""
    support = coarse_support(plan, sub, rough, WALL_SIGMA_M, _LOOK_POINTS)
    ranked = rough.take(np.argsort(-support, kind='stable'))
    return ranked.take(ranked.distinct(places, SAME_BASIN_M, 2 * MAX_ESTIMATES))
