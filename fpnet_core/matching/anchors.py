# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Placement hypotheses from a single pair of regions: a doorway's line, or a corner of a room.

Two centres determine a similarity, but the observed centre of a partially seen room is biased. If
a submap has little more than one room, its corners and doorways are more informative.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.matching.alignment import corners
from fpnet_core.matching.geometry import GraphGeometry

Array = NDArray[np.float64]

_SAME_SCALE = 0.03  # numerical: log scales that differ by less are tried once


def anchored(
    plan: GraphGeometry, sub: GraphGeometry, likely: NDArray[np.int64], log_window: float
) -> Array:
    """
    Return similarities ``(C, 4)`` that map one region of the submap to one of the plan.

    A doorway is mapped to every doorway of the plan, in both directions. A room is turned by
    quarters and mapped with one of its corners to each corner of its ``likely (N, K)`` partners,
    -1 for none. The scale follows from both graphs' units or from an equal width, long or short
    side; its logarithm is at most ``log_window``.
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


def _by_doors(plan_box: Array, box: Array, log_window: float) -> Array:
    """Return the similarities that map a doorway's line ``(5,)`` to those of ``(D, 5)``."""
    log_scale = np.log(plan_box[:, 2] / box[2])[:, None] * (0.0, 1.0)  # doorway, by width
    yaw = (plan_box[:, 4] - box[4])[:, None] + (0.0, np.pi)  # doorway, direction
    found = _placed(log_scale[:, None], yaw[:, :, None], box[:2], plan_box[:, None, None, :2])
    is_tried = np.broadcast_to(_is_tried(log_scale, log_window)[:, None], found.shape[:-1])
    return found[is_tried]


def _by_corners(
    likely: NDArray[np.int64],
    j: int,
    plan_corners: Array,
    plan_box: Array,
    sub_corners: Array,
    sub_box: Array,
    log_window: float,
) -> Array:
    """Return the similarities that map corners of room ``j`` to corners of its partners."""
    turn = np.arange(4)
    plan, corner = plan_box[likely], np.arange(4)
    yaw = (plan[:, 4] - sub_box[j, 4])[:, None] + turn * np.pi / 2.0  # partner, turn
    # Scales from the units or from either side; a quarter turn swaps the submap's sides.
    own = sub_box[j, 2 + (turn[:, None] + np.arange(2)) % 2]
    log_scale = np.concatenate(
        [np.zeros((len(likely), 4, 1)), np.log(plan[:, None, 2:4] / own)], axis=2
    )  # partner, turn, by side
    # Corners are counter-clockwise; a quarter turn of the room advances them by one.
    source = sub_corners[j, (corner - turn[:, None]) % 4][:, None]  # turn, -, corner
    target = plan_corners[likely][:, None, None]
    found = _placed(log_scale[..., None], yaw[:, :, None, None], source, target)
    return found[_is_tried(log_scale, log_window)].reshape(-1, 4)


def _is_tried(log_scale: Array, log_window: float) -> NDArray[np.bool_]:
    """Return which scales (..., S) are tried; the first, 0, is that of the units."""
    is_other = np.abs(log_scale) >= _SAME_SCALE
    is_other[..., 0] = True
    return np.asarray(is_other & (np.abs(log_scale) <= log_window))


def _placed(log_scale: Array, yaw: Array, source: Array, target: Array) -> Array:
    """Return similarities (..., 4) of this scale and yaw that map ``source`` to ``target``."""
    scale = np.exp(log_scale)
    a, b = scale * np.cos(yaw), scale * np.sin(yaw)
    x = target[..., 0] - a * source[..., 0] + b * source[..., 1]
    y = target[..., 1] - b * source[..., 0] - a * source[..., 1]
    return np.stack(np.broadcast_arrays(a, b, x, y), axis=-1)
