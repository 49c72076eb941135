# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Compiled inner loops of consensus: propose similarities, and fit regions under them.

A similarity is a row ``(a, b, x, y)``. It maps the point p of the submap to ``(a p_x - b p_y + x,
b p_x + a p_y + y)`` in the plan, both in their graphs' units.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import each_unwritable

DOOR_RADIUS = 1.1
"""Doors farther apart than this, in plan units, do not support a similarity. Chosen."""

ROOM_MARGIN = 0.9
"""
Largest distance of a submap room's centre outside a plan room's rectangle [plan units]. Chosen.
"""

DOOR_TURN_SIN = 0.35
"""Sine of the largest angle between the lines of two matching doors (20 degrees). Chosen."""

_TILE = 3.0  # numerical: plan units; side of tiles in which partners are looked up
_SIZE_SLACK = 1.2  # a room may look larger than its partner by this factor at no cost; chosen


def nearest_regions(point: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """
    Return the indices of the ``count < N`` nearest others of ``point (N, 2)``, nearest first.

    Indices ``(N, count)``; ties are resolved by lower index.
    """
    x, y = (point[:, None] - point).transpose(2, 0, 1)
    distance = np.sqrt(x * x + y * y)
    np.fill_diagonal(distance, np.inf)
    return np.ascontiguousarray(np.argsort(distance, axis=1, kind='stable')[:, :count])


@numba.njit(cache=True, nogil=True)
def propose_similarities(
    log_p: NDArray[np.float64],
    best: NDArray[np.int64],
    near: NDArray[np.int64],
    plan_point: NDArray[np.float64],
    sub_point: NDArray[np.float64],
    plan_angle: NDArray[np.float64],
    sub_angle: NDArray[np.float64],
    sub_door: NDArray[np.bool_],
    log_window: float,
) -> NDArray[np.float64]:
    """
    Return ``(C, 5)``: similarities that map two submap regions to two plan regions, with scores.

    Parameters
    ----------
    log_p : (M, N) log-likelihood of single pairs
    best : (N, K) plan regions to try per submap region, -1 for none
    near : (N, L) regions to pair each submap region with, -1 for none
    log_window : largest absolute log scale

    A door's line must keep its direction; the score is the sum of both log-likelihoods.
    """
    found = np.empty((near.size * best.shape[1] ** 2, 5))
    count = 0
    for j in range(near.shape[0]):
        for column in range(near.shape[1]):
            m = near[j, column]
            if m < 0:
                continue
            sub_x, sub_y = sub_point[m, 0] - sub_point[j, 0], sub_point[m, 1] - sub_point[j, 1]
            sub_log = 0.5 * np.log(sub_x * sub_x + sub_y * sub_y + 1e-12)
            sub_yaw = np.arctan2(sub_y, sub_x)
            for pair in range(best.shape[1] ** 2):
                i, k = best[j, pair // best.shape[1]], best[m, pair % best.shape[1]]
                if i < 0 or k < 0 or i == k:
                    continue
                x = plan_point[k, 0] - plan_point[i, 0]
                y = plan_point[k, 1] - plan_point[i, 1]
                scale = 0.5 * np.log(x * x + y * y + 1e-12) - sub_log
                if abs(scale) > log_window:
                    continue
                yaw = np.arctan2(y, x) - sub_yaw
                turn = abs(np.sin(plan_angle[i] - sub_angle[j] - yaw)) if sub_door[j] else 0.0
                other = abs(np.sin(plan_angle[k] - sub_angle[m] - yaw)) if sub_door[m] else 0.0
                if turn >= DOOR_TURN_SIN or other >= DOOR_TURN_SIN:
                    continue
                a, b = np.exp(scale) * np.cos(yaw), np.exp(scale) * np.sin(yaw)
                found[count, 0], found[count, 1] = a, b
                found[count, 2] = plan_point[i, 0] - a * sub_point[j, 0] + b * sub_point[j, 1]
                found[count, 3] = plan_point[i, 1] - b * sub_point[j, 0] - a * sub_point[j, 1]
                found[count, 4] = log_p[i, j] + log_p[k, m]
                count += 1
    return found[:count]


def fit_regions(
    similarity: NDArray[np.float64],
    weight: NDArray[np.float64],
    plan_point: NDArray[np.float64],
    plan_box: NDArray[np.float64],
    plan_door: NDArray[np.bool_],
    sub_point: NDArray[np.float64],
    sub_box: NDArray[np.float64],
    sub_door: NDArray[np.bool_],
    partner: NDArray[np.int64],
    fit: NDArray[np.float64],
) -> None:
    """
    Find the plan region that each submap region falls on under each similarity.

    Fills ``partner (C, N)`` with plan indices or -1 and ``fit (C, N)`` with the fit, 0 to 1. Among
    plan regions of the same label the one with the largest fit times ``weight (M, N)`` is taken.
    """
    tiles = _within_reach(plan_point, plan_box, plan_door)
    plan, sub = (plan_point, plan_box), (sub_point, sub_box, sub_door)
    axis = np.stack([np.cos(plan_box[:, 4]), np.sin(plan_box[:, 4])], axis=1)
    read = each_unwritable(similarity, weight, axis, *plan, *sub)
    _fit_regions(*[*read, *tiles, partner, fit])


@numba.njit(cache=True, nogil=True)
def _fit_regions(  # type: ignore[no-untyped-def]
    similarity, weight, axis, plan_point, plan_box, sub_point, sub_box, sub_door, low, across,
    starts, near, partner, fit,
):  # fmt: skip
    """
    Carry out :func:`fit_regions`, given the plan's tiles from :func:`_within_reach`.

    A door fits by its distance and direction. A room fits if its centre lies within the plan
    room's rectangle, even if little of it was seen; its half sides must not be larger, and the fit
    increases as they approach the plan room's.
    """
    down = len(starts) // (2 * across)
    for c in range(similarity.shape[0]):
        a, b, x0, y0 = similarity[c, 0], similarity[c, 1], similarity[c, 2], similarity[c, 3]
        scale, yaw = np.sqrt(a * a + b * b), np.arctan2(b, a)
        for j in range(sub_point.shape[0]):
            x = a * sub_point[j, 0] - b * sub_point[j, 1] + x0
            y = b * sub_point[j, 0] + a * sub_point[j, 1] + y0
            partner[c, j], fit[c, j], best = -1, 0.0, 0.0
            u, v = np.floor((x - low[0]) / _TILE), np.floor((y - low[1]) / _TILE)
            if not (0 <= u < across and 0 <= v < down):
                continue
            tile = 2 * (int(v) * across + int(u)) + sub_door[j]
            # Scalars only from here on: a slice in the innermost loop costs more than the
            # arithmetic.
            for place in range(starts[tile], starts[tile + 1]):
                i = near[place]
                if sub_door[j]:
                    dx, dy = x - plan_point[i, 0], y - plan_point[i, 1]
                    value = 1.0 - (dx * dx + dy * dy) / DOOR_RADIUS**2
                    if value > 0.0:
                        value *= np.cos(plan_box[i, 4] - sub_box[j, 4] - yaw) ** 2
                else:
                    dx, dy, cos, sin = (
                        x - plan_box[i, 0],
                        y - plan_box[i, 1],
                        axis[i, 0],
                        axis[i, 1],
                    )
                    long, short = plan_box[i, 2], plan_box[i, 3]
                    u = max(0.0, abs(cos * dx + sin * dy) - long)
                    v = max(0.0, abs(cos * dy - sin * dx) - short)
                    value = 1.0 - (u * u + v * v) / ROOM_MARGIN**2
                    if value > 0.0:
                        wider = scale * sub_box[j, 2] / long + 1e-9
                        deeper = scale * sub_box[j, 3] / short + 1e-9
                        larger = min(1.0, _SIZE_SLACK / wider) * min(1.0, _SIZE_SLACK / deeper)
                        smaller = min(1.0, _SIZE_SLACK * wider) * min(1.0, _SIZE_SLACK * deeper)
                        value *= larger * (0.5 + 0.5 * smaller)
                if value > 0.0 and value * weight[i, j] > best:
                    best, fit[c, j], partner[c, j] = value * weight[i, j], value, i


def _within_reach(
    point: NDArray[np.float64], box: NDArray[np.float64], is_door: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], int, NDArray[np.int64], NDArray[np.int64]]:
    """
    Return the regions that a point in each square tile may fit.

    Returns the lower corner (2,), tiles per row, ``starts`` and ``near``. Tile t holds, in order,
    ``near[starts[k]:starts[k + 1]]``: rooms at ``k = 2 t``, doors at ``k = 2 t + 1``.
    """
    cos, sin = np.abs(np.cos(box[:, 4])), np.abs(np.sin(box[:, 4]))
    long, short = box[:, 2], box[:, 3]
    half = np.stack([cos * long + sin * short, sin * long + cos * short], axis=1) + ROOM_MARGIN
    middle = np.where(is_door[:, None], point, box[:, :2])
    half = np.where(is_door[:, None], DOOR_RADIUS, half)
    low = (middle - half).min(axis=0)
    first, last = (((middle + by * half - low) / _TILE).astype(np.int64) for by in (-1.0, 1.0))
    across, down = (last.max(axis=0) + 1).tolist()
    wide, high = (last - first + 1).T
    count = wide * high
    region = np.repeat(np.arange(len(box)), count)
    v, u = np.divmod(np.arange(len(region)) - (np.cumsum(count) - count)[region], wide[region])
    tile = (first[region, 1] + v) * across + first[region, 0] + u
    key = 2 * tile + is_door[region]
    starts = np.concatenate([[0], np.cumsum(np.bincount(key, minlength=2 * across * down))])
    return low, across, starts, region[np.argsort(key, kind='stable')]


@numba.njit(cache=True, nogil=True)
def keep_one_per_plan_region(
    partner: NDArray[np.int64], fit: NDArray[np.float64], plan_count: int
) -> None:
    """Make rows of ``partner (C, N)`` one-to-one, in place: the best fit keeps its partner."""
    owner = np.empty(plan_count, dtype=np.int64)
    for c in range(partner.shape[0]):
        owner[:] = -1
        for j in range(partner.shape[1]):
            i = partner[c, j]
            if i < 0:
                continue
            if owner[i] < 0 or fit[c, j] > fit[c, owner[i]]:
                if owner[i] >= 0:
                    partner[c, owner[i]] = -1
                    fit[c, owner[i]] = 0.0
                owner[i] = j
            else:
                partner[c, j] = -1
                fit[c, j] = 0.0
