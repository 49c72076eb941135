# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Settle placements on the outlines of what they match: ends of doorways, corners of rooms.

Centres alone tell little of a rotation where a submap has two or three regions; a doorway's line
and a room's corners do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.matching.consensus import Placements
from fpnet_core.matching.geometry import GraphGeometry

Array = NDArray[np.float64]

_ITERATIONS = 4
_SPREAD_UNITS = 0.25  # corners further apart than this, in plan units, count less and less
_WELL_SEEN = 0.9  # observed fraction from which a room's corners are its own
_GLIMPSED_WEIGHT = 0.05  # of the corners of other rooms, which may be where sight ended
_SIGNS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


def aligned(placements: Placements, plan: GraphGeometry, sub: GraphGeometry) -> Array:
    """
    Return ``(C, 4)`` similarities of the placements, refitted to corners of their pairs.

    Iteratively reweighted least squares with Cauchy weights; rows without a match stay.
    """
    source, target = corners(sub), corners(plan)[placements.partner]
    seen = np.where(sub.is_door | (sub.observed >= _WELL_SEEN), 1.0, _GLIMPSED_WEIGHT)
    matched = (placements.partner >= 0) & (placements.fit > 0.0)
    weight = np.where(matched, seen, 0.0)
    similarity = placements.similarity
    for _ in range(_ITERATIONS):
        placed = _apply(similarity, source)
        turned = _in_order(placed, target)
        gap = np.linalg.norm(placed - turned, axis=3)
        pulls = weight[..., None] / (1.0 + (gap / _SPREAD_UNITS) ** 2)
        similarity = _least_squares(source, turned, pulls)
    return np.where(matched.any(axis=1, keepdims=True), similarity, placements.similarity)


def corners(side: GraphGeometry) -> Array:
    """Return ``(R, 4, 2)``: the corners of each room's rectangle, a doorway's ends twice."""
    half = side.box[:, 2:4] * np.where(side.is_door[:, None], [1.0, 0.0], 1.0)
    c, s = np.cos(side.box[:, 4]), np.sin(side.box[:, 4])
    axes = np.stack([np.stack([c, s], axis=1), np.stack([-s, c], axis=1)], axis=1)
    signs = np.where(side.is_door[:, None, None], _SIGNS[[0, 2, 0, 2]], _SIGNS)
    offsets: Array = np.einsum('rka,rad->rkd', signs * half[:, None], axes)
    return side.box[:, None, :2] + offsets


def _in_order(placed: Array, target: Array) -> Array:
    """Return each rectangle's corners, turned so that they are nearest to ``placed``."""
    turns = np.stack([np.roll(target, turn, axis=2) for turn in range(4)])
    best = ((turns - placed) ** 2).sum(axis=(3, 4)).argmin(axis=0)
    chosen: Array = np.take_along_axis(turns, best[None, ..., None, None], axis=0)[0]
    return chosen


def _apply(similarity: Array, points: Array) -> Array:
    """Return ``points (N, 4, 2)`` under every similarity ``(C, 4)``: ``(C, N, 4, 2)``."""
    a, b, x, y = similarity.T[:, :, None, None]
    u, v = points[..., 0], points[..., 1]
    return np.stack([a * u - b * v + x, b * u + a * v + y], axis=3)


def _least_squares(source: Array, target: Array, weight: Array) -> Array:
    """Return ``(C, 4)`` from ``source (N, 4, 2)`` to ``target (C, N, 4, 2)``."""
    total = weight.sum(axis=(1, 2), keepdims=True)
    share = weight / np.maximum(total, np.finfo(np.float64).tiny)
    middle = np.einsum('cnk,nkd->cd', share, source)
    there = np.einsum('cnk,cnkd->cd', share, target)
    u, v = source - middle[:, None, None], target - there[:, None, None]
    spread = np.maximum(np.einsum('cnk,cnkd,cnkd->c', share, u, u), 1e-12)
    a = np.einsum('cnk,cnkd,cnkd->c', share, u, v) / spread
    b = np.einsum('cnk,cnk->c', share, u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]) / spread
    x = there[:, 0] - a * middle[:, 0] + b * middle[:, 1]
    y = there[:, 1] - b * middle[:, 0] - a * middle[:, 1]
    return np.stack([a, b, x, y], axis=1)
