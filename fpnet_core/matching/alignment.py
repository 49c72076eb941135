# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Refinement of placements on the outlines of matched regions: ends of doorways, room corners.

The centres of two or three regions hardly determine a rotation; a doorway's line and a room's
corners do. The residual distance between outlines distinguishes rooms of nearly equal size.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.matches import WELL_SEEN
from fpnet_core.matching.geometry import GraphGeometry

Array = NDArray[np.float64]

GLIMPSED_WEIGHT = 0.05
"""
Weight of a room relative to a door in refinement: the centre of the observed part is not the
room's, and its corners may be limits of visibility. Chosen.
"""

_ITERATIONS = 4  # numerical
# Chosen, not measured:
_SPREAD_UNITS = 0.25  # scale of the robust weights of outline distances, in plan units
_SIGNS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])  # numerical


def aligned(
    similarity: Array,
    partner: NDArray[np.int64],
    fit: Array,
    plan: GraphGeometry,
    sub: GraphGeometry,
) -> tuple[Array, Array]:
    """
    Refit placements to the corners of their pairs, and measure the residual outline distances.

    Iteratively reweighted least squares with Cauchy weights; rows without a match stay unchanged.

    Parameters
    ----------
    similarity : (C, 4) placements, as in :mod:`fpnet_core.matching.kernels`
    partner, fit : (C, N) plan regions or -1, and how well they fit

    Returns
    -------
    Similarities ``(C, 4)``, and each region's outline distance to its partner ``(C, N)``, 0
    without one: the mean of ``log(1 + (gap / spread)^2)`` over the ends of a doorway, over the
    sides of a well observed room, or over the corners of any other room, whose gap is their
    distance outside its partner.
    """
    seen = np.where(sub.is_door | (sub.observed >= WELL_SEEN), 1.0, GLIMPSED_WEIGHT)
    weight = np.where((partner >= 0) & (fit > 0.0), seen, 0.0)
    similarity = np.ascontiguousarray(similarity)
    plan_corners, sub_corners = corners(plan), corners(sub)
    for _ in range(_ITERATIONS):
        similarity = _refitted(similarity, partner, weight, plan_corners, sub_corners)
    apart = np.zeros(partner.shape)
    by_sides = ~sub.is_door & (sub.observed >= WELL_SEEN)
    sides = (sub.is_door, by_sides, plan_corners, sub_corners, plan.box)
    _outlines_apart(similarity, partner, *sides, apart)
    return similarity, apart


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

    ``partner (C, N)`` are correspondences and ``weight (C, N)`` their weights; each rectangle's
    four corners are taken in the order that brings them nearest.
    """
    result, placed = similarity.copy(), np.empty((4, 2))
    for c in range(len(similarity)):
        a, b, x0, y0 = similarity[c, 0], similarity[c, 1], similarity[c, 2], similarity[c, 3]
        # Normal equations: sums of weights, of both sides' points and of their products.
        w = ux = uy = vx = vy = uu = along = across = 0.0
        for j in range(partner.shape[1]):
            if weight[c, j] <= 0.0:
                continue
            target = plan_corners[partner[c, j]]
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
    """Return the index offset of ``target (4, 2)`` that brings it nearest to ``placed (4, 2)``."""
    best, best_turn = np.inf, 0
    for turn in range(4):
        total = 0.0
        for k in range(4):
            other = target[(k + turn) % 4]
            total += (placed[k, 0] - other[0]) ** 2 + (placed[k, 1] - other[1]) ** 2
        if total < best:
            best, best_turn = total, turn
    return best_turn


@numba.njit(cache=True, nogil=True)
def _outlines_apart(
    similarity: Array,
    partner: NDArray[np.int64],
    is_door: NDArray[np.bool_],
    by_sides: NDArray[np.bool_],
    plan_corners: Array,
    sub_corners: Array,
    plan_box: Array,
    apart: Array,
) -> None:
    """Fill ``apart (C, N)`` with the distance of each region's outline to its partner's."""
    placed, gap = np.empty((4, 2)), np.empty((4, 2))
    for c in range(len(similarity)):
        a, b, x0, y0 = similarity[c, 0], similarity[c, 1], similarity[c, 2], similarity[c, 3]
        for j in range(partner.shape[1]):
            i = partner[c, j]
            if i < 0:
                continue
            for k in range(4):
                px, py = sub_corners[j, k, 0], sub_corners[j, k, 1]
                placed[k, 0], placed[k, 1] = a * px - b * py + x0, b * px + a * py + y0
            total = 0.0
            if is_door[j] or by_sides[j]:
                turn = _nearest_turn(placed, plan_corners[i])
                for k in range(4):
                    gap[k, 0] = plan_corners[i, (k + turn) % 4, 0] - placed[k, 0]
                    gap[k, 1] = plan_corners[i, (k + turn) % 4, 1] - placed[k, 1]
            for k in range(4):
                if is_door[j]:
                    off = gap[k, 0] ** 2 + gap[k, 1] ** 2
                elif by_sides[j]:  # perpendicular offset of the side to the next corner
                    m = (k + 1) % 4
                    x, y = placed[m, 0] - placed[k, 0], placed[m, 1] - placed[k, 1]
                    length = np.sqrt(x**2 + y**2) + 1e-9
                    mid_x, mid_y = 0.5 * (gap[k, 0] + gap[m, 0]), 0.5 * (gap[k, 1] + gap[m, 1])
                    off = ((x * mid_y - y * mid_x) / length) ** 2
                else:  # distance outside the rectangle
                    cos, sin = np.cos(plan_box[i, 4]), np.sin(plan_box[i, 4])
                    dx, dy = placed[k, 0] - plan_box[i, 0], placed[k, 1] - plan_box[i, 1]
                    u = max(0.0, abs(cos * dx + sin * dy) - plan_box[i, 2])
                    v = max(0.0, abs(cos * dy - sin * dx) - plan_box[i, 3])
                    off = u * u + v * v
                total += np.log1p(off / _SPREAD_UNITS**2)
            apart[c, j] = 0.25 * total
