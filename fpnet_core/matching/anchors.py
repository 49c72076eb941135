# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Placements that a single pair of regions proposes: a doorway's line, or a corner of a room.

Two middles fix a similarity, but the middle of a room that was seen in part is not its own. Where
a submap shows hardly more than one room, its corners and doorways say more.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.matching.alignment import corners
from fpnet_core.matching.geometry import GraphGeometry

Array = NDArray[np.float64]

_SAME_SCALE = 0.03  # numerical: logarithms of scales that differ by less are tried once


def anchored(
    plan: GraphGeometry, sub: GraphGeometry, likely: NDArray[np.int64], log_window: float
) -> Array:
    """
    Return similarities ``(C, 4)`` that lay one region of the submap on one of the plan.

    A doorway is laid on every doorway of the plan, either way round; a room, turned by quarters,
    with one of its corners on each corner of its ``likely (N, K)`` partners, -1 for none. The
    scale is that of both graphs' units or makes a width, a long or a short side agree; its
    logarithm is at most ``log_window``.
    """
    doors = np.flatnonzero(plan.is_door)
    sides = corners(plan), plan.box, corners(sub), sub.box
    found = np.concatenate(
        [np.zeros((0, 4))]
        + [
            _by_doors(plan.box[doors], sub.box[j], log_window)
            if sub.is_door[j]
            else _by_corners(likely[j][likely[j] >= 0], j, *sides, log_window)
            for j in range(len(sub))
        ]
    )
    return np.ascontiguousarray(found)


@numba.njit(cache=True, nogil=True)
def _by_doors(plan_box: Array, box: Array, log_window: float) -> Array:
    """Return the similarities that lay a doorway's line ``(5,)`` on those of ``(D, 5)``."""
    found = np.empty((4 * len(plan_box), 4))
    count = 0
    for i in range(len(plan_box)):
        for way in range(2):
            for by_width in range(2):
                log_scale = by_width * np.log(plan_box[i, 2] / box[2])
                if abs(log_scale) > log_window or (by_width and abs(log_scale) < _SAME_SCALE):
                    continue
                yaw = plan_box[i, 4] - box[4] + way * np.pi
                _put(found[count], np.exp(log_scale), yaw, box[:2], plan_box[i, :2])
                count += 1
    return found[:count]


@numba.njit(cache=True, nogil=True)
def _by_corners(
    likely: NDArray[np.int64],
    j: int,
    plan_corners: Array,
    plan_box: Array,
    sub_corners: Array,
    sub_box: Array,
    log_window: float,
) -> Array:
    """Return the similarities that lay corners of room ``j`` on corners of its partners."""
    found = np.empty((48 * len(likely), 4))
    count = 0
    for i in likely:
        for turn in range(4):
            yaw = plan_box[i, 4] - sub_box[j, 4] + turn * np.pi / 2.0
            for by_side in range(3):
                log_scale = 0.0
                if by_side:
                    own = 2 + (turn + by_side - 1) % 2
                    log_scale = np.log(plan_box[i, 1 + by_side] / sub_box[j, own])
                if abs(log_scale) > log_window or (by_side and abs(log_scale) < _SAME_SCALE):
                    continue
                for corner in range(4):
                    # Corners go round counter-clockwise, and turning the room moves them on.
                    source = sub_corners[j, (corner - turn) % 4]
                    _put(found[count], np.exp(log_scale), yaw, source, plan_corners[i, corner])
                    count += 1
    return found[:count]


@numba.njit(cache=True, nogil=True)
def _put(row: Array, scale: float, yaw: float, source: Array, target: Array) -> None:
    """Write the similarity of this scale and turn that takes ``source`` to ``target``."""
    a, b = scale * np.cos(yaw), scale * np.sin(yaw)
    row[0], row[1] = a, b
    row[2] = target[0] - a * source[0] + b * source[1]
    row[3] = target[1] - b * source[0] - a * source[1]
