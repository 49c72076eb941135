# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Settle placements on the outlines of what they match: ends of doorways, corners of rooms.

Centres alone tell little of a rotation where a submap has two or three regions; a doorway's line
and a room's corners do.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.matches import WELL_SEEN
from fpnet_core.matching.consensus import GLIMPSED_WEIGHT, Assignments
from fpnet_core.matching.geometry import GraphGeometry

Array = NDArray[np.float64]

_ITERATIONS = 4  # numerical
# Chosen, not measured:
_SPREAD_UNITS = 0.25  # corners further apart than this, in plan units, count less and less
_SIGNS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])  # numerical


def aligned(assignments: Assignments, plan: GraphGeometry, sub: GraphGeometry) -> Array:
    """
    Return ``(C, 4)`` similarities of the placements, refitted to corners of their pairs.

    Iteratively reweighted least squares with Cauchy weights; rows without a match stay.
    """
    seen = np.where(sub.is_door | (sub.observed >= WELL_SEEN), 1.0, GLIMPSED_WEIGHT)
    matched = (assignments.partner >= 0) & (assignments.fit > 0.0)
    weight = np.where(matched, seen, 0.0)
    similarity = np.ascontiguousarray(assignments.similarity)
    plan_corners, sub_corners = corners(plan), corners(sub)
    for _ in range(_ITERATIONS):
        similarity = _refitted(similarity, assignments.partner, weight, plan_corners, sub_corners)
    return similarity


def corners(side: GraphGeometry) -> Array:
    """Return ``(R, 4, 2)``: the corners of each room's rectangle, a doorway's ends twice."""
    half = side.box[:, 2:4] * np.where(side.is_door[:, None], [1.0, 0.0], 1.0)
    c, s = np.cos(side.box[:, 4]), np.sin(side.box[:, 4])
    axes = np.stack([np.stack([c, s], axis=1), np.stack([-s, c], axis=1)], axis=1)
    signs = np.where(side.is_door[:, None, None], _SIGNS[[0, 2, 0, 2]], _SIGNS)
    offsets: Array = np.einsum('rka,rad->rkd', signs * half[:, None], axes)
    return side.box[:, None, :2] + offsets


@numba.njit(cache=True, nogil=True)
def _refitted(
    similarity: Array,
    partner: NDArray[np.int64],
    weight: Array,
    plan_corners: Array,
    sub_corners: Array,
) -> Array:
    """
    Return similarities ``(C, 4)`` after one step of weighted least squares.

    ``partner (C, N)`` and ``weight (C, N)`` say what belongs together and how much it counts;
    each rectangle's four corners are taken in the order that brings them nearest.
    """
    result = similarity.copy()
    for c in range(len(similarity)):
        a, b, x0, y0 = similarity[c]
        # Sums of weight, of both sides' points, of their products: the normal equations.
        w = ux = uy = vx = vy = uu = along = across = 0.0
        for j in range(partner.shape[1]):
            if weight[c, j] <= 0.0:
                continue
            target = plan_corners[partner[c, j]]
            placed = np.empty((4, 2))
            for k in range(4):
                px, py = sub_corners[j, k, 0], sub_corners[j, k, 1]
                placed[k, 0], placed[k, 1] = a * px - b * py + x0, b * px + a * py + y0
            turn = _nearest_turn(placed, target)
            for k in range(4):
                gap = target[(k + turn) % 4]
                dx, dy = gap[0] - placed[k, 0], gap[1] - placed[k, 1]
                pull = weight[c, j] / (1.0 + (dx * dx + dy * dy) / _SPREAD_UNITS**2)
                px, py = sub_corners[j, k, 0], sub_corners[j, k, 1]
                w += pull
                ux, uy = ux + pull * px, uy + pull * py
                vx, vy = vx + pull * gap[0], vy + pull * gap[1]
                uu += pull * (px * px + py * py)
                along += pull * (px * gap[0] + py * gap[1])
                across += pull * (px * gap[1] - py * gap[0])
        if w <= 0.0:
            continue
        spread = uu - (ux * ux + uy * uy) / w
        if spread <= 1e-12 * w:
            continue
        a = (along - (ux * vx + uy * vy) / w) / spread
        b = (across - (ux * vy - uy * vx) / w) / spread
        result[c, 0], result[c, 1] = a, b
        result[c, 2] = (vx - a * ux + b * uy) / w
        result[c, 3] = (vy - b * ux - a * uy) / w
    return result


@numba.njit(cache=True, nogil=True)
def _nearest_turn(placed: Array, target: Array) -> int:
    """Return by how many corners ``target (4, 2)`` is ahead of ``placed (4, 2)``."""
    best, best_turn = np.inf, 0
    for turn in range(4):
        total = 0.0
        for k in range(4):
            other = target[(k + turn) % 4]
            total += (placed[k, 0] - other[0]) ** 2 + (placed[k, 1] - other[1]) ** 2
        if total < best:
            best, best_turn = total, turn
    return best_turn
