# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Compiled inner loops of consensus: propose similarities, and fit regions under them.

A similarity is a row ``(a, b, x, y)``: the point p of the submap goes to
``(a p_x - b p_y + x, b p_x + a p_y + y)`` of the plan, both in their graphs' units.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

DOOR_RADIUS = 1.1
"""Doors further apart than this, in plan units, do not support a similarity. Chosen."""

ROOM_MARGIN = 0.9
"""
How far outside a plan room's rectangle the middle of a submap's room may fall [plan units].
Chosen.
"""

DOOR_TURN_SIN = 0.35
"""Sine of the angle between two doors' lines that still agree (20 degrees). Chosen."""

_TILE = 3.0  # numerical: plan units; side of tiles in which partners are looked for
_SIZE_SLACK = 1.2  # a room may look larger than its partner by this factor at no cost; chosen


@numba.njit(cache=True, nogil=True)
def nearest_regions(point: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """
    Return which ``count < N`` of ``point (N, 2)`` lie nearest to each, nearest first.

    Indices ``(N, count)``; of equally far ones the first comes first.
    """
    nearest = np.empty((len(point), count), dtype=np.int64)
    distance = np.empty(count)
    for j in range(len(point)):
        distance[:] = np.inf
        for m in range(len(point)):
            x, y = point[j, 0] - point[m, 0], point[j, 1] - point[m, 1]
            own = np.sqrt(x * x + y * y)
            if m == j or (count and own >= distance[count - 1]):
                continue
            place = count - 1
            while place > 0 and own < distance[place - 1]:
                distance[place], nearest[j, place] = distance[place - 1], nearest[j, place - 1]
                place -= 1
            distance[place], nearest[j, place] = own, m
    return nearest


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
    Return ``(C, 5)``: the similarity that takes two submap regions to two plan regions, and worth.

    Parameters
    ----------
    log_p : (M, N) log-likelihood of single pairs
    best : (N, K) plan regions to try per submap region, -1 for none
    near : (N, L) regions to pair each submap region with, -1 for none
    log_window : how far from one the scale is tried, as a logarithm

    A door's line must keep its direction; the worth is the sum of both log-likelihoods.
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
            for i in best[j]:
                for k in best[m]:
                    if i < 0 or k < 0 or i == k:
                        continue
                    x = plan_point[k, 0] - plan_point[i, 0]
                    y = plan_point[k, 1] - plan_point[i, 1]
                    scale = 0.5 * np.log(x * x + y * y + 1e-12) - sub_log
                    if abs(scale) > log_window:
                        continue
                    yaw = np.arctan2(y, x) - sub_yaw
                    if sub_door[j] and not _aligned(plan_angle[i], sub_angle[j], yaw):
                        continue
                    if sub_door[m] and not _aligned(plan_angle[k], sub_angle[m], yaw):
                        continue
                    a, b = np.exp(scale) * np.cos(yaw), np.exp(scale) * np.sin(yaw)
                    found[count, 0], found[count, 1] = a, b
                    found[count, 2] = plan_point[i, 0] - a * sub_point[j, 0] + b * sub_point[j, 1]
                    found[count, 3] = plan_point[i, 1] - b * sub_point[j, 0] - a * sub_point[j, 1]
                    found[count, 4] = log_p[i, j] + log_p[k, m]
                    count += 1
    return found[:count]


@numba.njit(cache=True, nogil=True)
def _aligned(plan_angle: float, sub_angle: float, yaw: float) -> bool:
    return bool(abs(np.sin(plan_angle - sub_angle - yaw)) < DOOR_TURN_SIN)


@numba.njit(cache=True, nogil=True)
def _door_fit(dx: float, dy: float, turn: float) -> float:
    """Return how well a door fits a plan door ``(dx, dy)`` away at an angle ``turn``, 0 to 1."""
    near = 1.0 - (dx * dx + dy * dy) / DOOR_RADIUS**2
    if near <= 0.0:
        return 0.0
    return float(near * np.cos(turn) ** 2)


@numba.njit(cache=True, nogil=True)
def _room_fit(
    along: float, across: float, half_long: float, half_short: float, long: float, short: float
) -> float:
    """
    Return how well a room fits a plan room, 0 to 1.

    Its middle, ``along`` and ``across`` the plan room's axis from that one's centre, must lie
    within the plan room's rectangle (half sides ``long`` and ``short``), however little of it
    was seen; its own half sides must not be larger, and score more the nearer they are.
    """
    u, v = max(0.0, abs(along) - long), max(0.0, abs(across) - short)
    near = 1.0 - (u * u + v * v) / ROOM_MARGIN**2
    if near <= 0.0:
        return 0.0
    wider, deeper = half_long / long + 1e-9, half_short / short + 1e-9
    larger = min(1.0, _SIZE_SLACK / wider) * min(1.0, _SIZE_SLACK / deeper)
    smaller = min(1.0, _SIZE_SLACK * wider) * min(1.0, _SIZE_SLACK * deeper)
    return float(near * larger * (0.5 + 0.5 * smaller))


@numba.njit(cache=True, nogil=True)
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

    Fills ``partner (C, N)`` with plan indices or -1 and ``fit (C, N)`` with the fit, 0 to 1;
    among plan regions of the same label the one with the greatest fit times
    ``weight (M, N)`` wins.
    """
    cos, sin = np.cos(plan_box[:, 4]), np.sin(plan_box[:, 4])
    low, across, starts, near = _within_reach(plan_point, plan_box, plan_door)
    down = len(starts) // (2 * across)
    for c in range(similarity.shape[0]):
        a, b, x0, y0 = similarity[c, 0], similarity[c, 1], similarity[c, 2], similarity[c, 3]
        scale, yaw = np.sqrt(a * a + b * b), np.arctan2(b, a)
        for j in range(sub_point.shape[0]):
            x = a * sub_point[j, 0] - b * sub_point[j, 1] + x0
            y = b * sub_point[j, 0] + a * sub_point[j, 1] + y0
            half_long, half_short = scale * sub_box[j, 2], scale * sub_box[j, 3]
            best, best_fit, best_index = 0.0, 0.0, -1
            u, v = np.floor((x - low[0]) / _TILE), np.floor((y - low[1]) / _TILE)
            if not (0 <= u < across and 0 <= v < down):
                partner[c, j], fit[c, j] = -1, 0.0
                continue
            tile = 2 * (int(v) * across + int(u)) + sub_door[j]
            # Scalars only from here on: a slice in the innermost loop costs more than its maths.
            for place in range(starts[tile], starts[tile + 1]):
                i = near[place]
                if sub_door[j]:
                    dx, dy = x - plan_point[i, 0], y - plan_point[i, 1]
                    value = _door_fit(dx, dy, plan_box[i, 4] - sub_box[j, 4] - yaw)
                else:
                    dx, dy = x - plan_box[i, 0], y - plan_box[i, 1]
                    value = _room_fit(
                        cos[i] * dx + sin[i] * dy,
                        cos[i] * dy - sin[i] * dx,
                        half_long,
                        half_short,
                        plan_box[i, 2],
                        plan_box[i, 3],
                    )
                if value * weight[i, j] > best:
                    best, best_fit, best_index = value * weight[i, j], value, int(i)
            partner[c, j], fit[c, j] = best_index, best_fit


@numba.njit(cache=True, nogil=True)
def _within_reach(
    point: NDArray[np.float64], box: NDArray[np.float64], is_door: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], int, NDArray[np.int64], NDArray[np.int64]]:
    """
    Return which regions something in each square tile may fit.

    The tiles' lower corner (2,), how many lie side by side, and regions: those of a tile are
    ``near[starts[k]:starts[k + 1]]``, in their order; rooms of tile t at ``k = 2 t``, doors next.
    """
    reach = _reaches(point, box, is_door)
    low = np.array([reach[:, 0].min(), reach[:, 1].min()])
    across = int((reach[:, 2].max() - low[0]) / _TILE) + 1
    down = int((reach[:, 3].max() - low[1]) / _TILE) + 1
    tiles = np.empty(reach.shape, dtype=np.int64)
    for k in range(4):
        tiles[:, k] = (reach[:, k] - low[k % 2]) / _TILE
    starts = np.zeros(2 * across * down + 1, dtype=np.int64)
    for i in range(len(box)):
        for v in range(tiles[i, 1], tiles[i, 3] + 1):
            for u in range(tiles[i, 0], tiles[i, 2] + 1):
                starts[2 * (v * across + u) + is_door[i] + 1] += 1
    starts = np.cumsum(starts)
    near, filled = np.empty(starts[-1], dtype=np.int64), starts.copy()
    for i in range(len(box)):
        for v in range(tiles[i, 1], tiles[i, 3] + 1):
            for u in range(tiles[i, 0], tiles[i, 2] + 1):
                k = 2 * (v * across + u) + is_door[i]
                near[filled[k]] = i
                filled[k] += 1
    return low, across, starts, near


@numba.njit(cache=True, nogil=True)
def _reaches(
    point: NDArray[np.float64], box: NDArray[np.float64], is_door: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return lowest x and y and highest x and y ``(R, 4)`` at which something fits each region."""
    reach = np.empty((len(box), 4))
    for i in range(len(box)):
        cos, sin = abs(np.cos(box[i, 4])), abs(np.sin(box[i, 4]))
        x, y = box[i, 0], box[i, 1]
        wide = cos * box[i, 2] + sin * box[i, 3] + ROOM_MARGIN
        high = sin * box[i, 2] + cos * box[i, 3] + ROOM_MARGIN
        if is_door[i]:
            x, y, wide, high = point[i, 0], point[i, 1], DOOR_RADIUS, DOOR_RADIUS
        reach[i, 0], reach[i, 1], reach[i, 2], reach[i, 3] = x - wide, y - high, x + wide, y + high
    return reach


@numba.njit(cache=True, nogil=True)
def keep_one_per_plan_region(
    partner: NDArray[np.int64], fit: NDArray[np.float64], plan_count: int
) -> None:
    """Make each row of ``partner (C, N)`` one-to-one in place: the best fit keeps its partner."""
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
