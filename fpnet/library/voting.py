# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compiled voting: equal words of map and plans vote for plans and placements on them."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry.voxels import HASH_FACTOR

# Numerical: size of the hash tables of a plan's votes. Different placements may collide in one
# table, but seldom in both, as their bins are offset by half a step:
_TABLE_BITS = 12
_TABLE = 1 << _TABLE_BITS
_HASH_SHIFT = np.uint64(64 - _TABLE_BITS)
_OFFSET = 4096  # numerical: makes bin indices positive; plans span fewer bins
_DIRECTIONS = 4096  # numerical: entries of the sine table, less than 0.1 degrees apart
# Chosen: bins of placements, in position [m] and headings per turn:
_STEP_M = 1.5
_TURNS = 24
# Chosen: largest distance of partners, later and in the first round [m], and angle [rad]:
_REACH_M, _FIRST_REACH_M = 0.6, 1.0
_ALIKE_RAD = 0.45
_ROUNDS = 3  # numerical: iterations, each aligns the keypoints with their partners

# Numerical: a full turn and a quarter more, so that it also holds cosines.
_SINES = np.sin(np.arange(_DIRECTIONS * 5 // 4) * 2.0 * np.pi / _DIRECTIONS).astype(np.float32)

LENGTH_UNIT_M = 0.01
"""Numerical: positions are stored in whole centimetres."""

_TURN = 65536  # numerical: units of a full turn
TURN_UNIT = 2.0 * np.pi / _TURN
"""Numerical: angles are stored in sixteen bits."""


@numba.njit(cache=True, nogil=True)
def count_votes(
    starts: NDArray[np.int64],
    plan: NDArray[np.uint32],
    middle: NDArray[np.int16],
    bearing: NDArray[np.uint16],
    word: NDArray[np.int64],
    weight: NDArray[np.float32],
    asked_middle: NDArray[np.float32],
    asked_bearing: NDArray[np.float32],
    plans: int,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """
    Return for each plan the most votes for one placement ``(N,)``, and that one ``(N, 3)``.

    Placements are yaw, x and y of the robot map in the plan's own metres.

    Parameters
    ----------
    starts : (W + 1,) index of the first pair of each word
    plan, middle, bearing : (E,), (E, 2), (E,) of all plans' pairs, ordered by word
    word, weight, asked_middle, asked_bearing : (Q,), (Q,), (Q, 2), (Q,) of the robot map's pairs
    plans : N
    """
    ends, yaws, places, votes = _by_plan(
        starts, plan, middle, bearing, word, weight, asked_middle, asked_bearing, plans
    )
    most, best = np.zeros(plans, np.float32), np.zeros((plans, 3), np.float32)
    table, cells = np.zeros((2, _TABLE), np.float32), np.empty((len(votes), 2), np.int64)
    first = 0
    for number in range(plans):
        chosen = -1
        for hit in range(first, ends[number]):
            for half in range(2):
                # Bins of the second table are offset by half a step.
                shift = np.float32(0.5 * half)
                turn = (yaws[hit] * _TURNS + half * (_TURN // 2)) // _TURN % _TURNS
                col = np.int64(np.floor(places[hit, 0] / np.float32(_STEP_M) + shift)) + _OFFSET
                row = np.int64(np.floor(places[hit, 1] / np.float32(_STEP_M) + shift)) + _OFFSET
                place = (turn * (2 * _OFFSET) + col) * (2 * _OFFSET) + row
                cell = np.int64((np.uint64(place) * HASH_FACTOR) >> _HASH_SHIFT)
                cells[hit, half] = cell
                table[half, cell] += votes[hit]
                if table[half, cell] > most[number]:
                    most[number], chosen = table[half, cell], hit
        for hit in range(first, ends[number]):
            table[0, cells[hit, 0]] = table[1, cells[hit, 1]] = 0.0
        if chosen >= 0:
            best[number, 0] = yaws[chosen] * TURN_UNIT
            best[number, 1:] = places[chosen]
        first = ends[number]
    return most, best


@numba.njit(cache=True, nogil=True)
def _by_plan(
    starts: NDArray[np.int64],
    plan: NDArray[np.uint32],
    middle: NDArray[np.int16],
    bearing: NDArray[np.uint16],
    word: NDArray[np.int64],
    weight: NDArray[np.float32],
    asked_middle: NDArray[np.float32],
    asked_bearing: NDArray[np.float32],
    plans: int,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """
    Return all pairs of equal words, grouped by plan so that its table stays in the cache.

    The arrays: end of each plan's group; yaw in units, x, y [m] and weight of each vote.
    """
    ends = np.zeros(plans + 1, np.int64)
    for q in range(len(word)):
        for e in range(starts[word[q]], starts[word[q] + 1]):
            ends[plan[e] + 1] += 1
    ends = np.cumsum(ends)
    total = ends[plans]
    yaws, places = np.empty(total, np.int64), np.empty((total, 2), np.float32)
    votes = np.empty(total, np.float32)
    for q in range(len(word)):
        x, y = asked_middle[q, 0], asked_middle[q, 1]
        asked = np.int64(asked_bearing[q] / TURN_UNIT)
        for e in range(starts[word[q]], starts[word[q] + 1]):
            yaw = (np.int64(bearing[e]) - asked) % _TURN
            direction = yaw * _DIRECTIONS // _TURN
            sin, cos = _SINES[direction], _SINES[direction + _DIRECTIONS // 4]
            hit = ends[plan[e]]
            ends[plan[e]] = hit + 1
            yaws[hit], votes[hit] = yaw, weight[q]
            places[hit, 0] = middle[e, 0] * np.float32(LENGTH_UNIT_M) - (cos * x - sin * y)
            places[hit, 1] = middle[e, 1] * np.float32(LENGTH_UNIT_M) - (sin * x + cos * y)
    return ends, yaws, places, votes


@numba.njit(cache=True, nogil=True)
def count_partners(
    xy: NDArray[np.float32],
    angle: NDArray[np.float32],
    kind: NDArray[np.uint8],
    plan_xy: NDArray[np.int16],
    plan_angle: NDArray[np.uint16],
    plan_kind: NDArray[np.uint8],
    pose: NDArray[np.float32],
    period: NDArray[np.float32],
) -> float:
    """
    Return the number of keypoints with a partner in a plan, weighted 0 to 1 by distance.

    Parameters
    ----------
    xy, angle, kind : (K, 2), (K,), (K,) of the robot map
    plan_xy, plan_angle, plan_kind : (L, 2), (L,), (L,) of the plan, in the units above
    pose : (3,) initial yaw, x, y; overwritten by the aligned pose
    period : (3,) period of angles by kind
    """
    yaw, tx, ty = float(pose[0]), float(pose[1]), float(pose[2])
    found = 0.0
    for round_ in range(_ROUNDS):
        reach = _FIRST_REACH_M if round_ == 0 else _REACH_M
        cos, sin = np.cos(yaw), np.sin(yaw)
        found, count, dx, dy, turn = 0.0, 0, 0.0, 0.0, 0.0
        for i in range(len(xy)):
            x = cos * xy[i, 0] - sin * xy[i, 1] + tx
            y = sin * xy[i, 0] + cos * xy[i, 1] + ty
            whole = float(period[kind[i]])
            nearest, along_x, along_y, turned = reach * reach, 0.0, 0.0, 0.0
            is_found = False
            for j in range(len(plan_xy)):
                if plan_kind[j] != kind[i]:
                    continue
                gap_x = plan_xy[j, 0] * LENGTH_UNIT_M - x
                gap_y = plan_xy[j, 1] * LENGTH_UNIT_M - y
                squared = gap_x * gap_x + gap_y * gap_y
                if squared >= nearest:
                    continue
                off = (plan_angle[j] * TURN_UNIT - angle[i] - yaw + whole / 2.0) % whole
                off -= whole / 2.0
                if abs(off) < _ALIKE_RAD:
                    is_found, nearest = True, squared
                    along_x, along_y, turned = gap_x, gap_y, off
            if is_found:
                found += 1.0 - nearest / (reach * reach)
                count, dx, dy, turn = count + 1, dx + along_x, dy + along_y, turn + turned
        if count < 2:
            break
        yaw, tx, ty = yaw + turn / count / 2.0, tx + dx / count, ty + dy / count
    pose[0], pose[1], pose[2] = yaw, tx, ty
    return found
