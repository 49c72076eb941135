# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Classification of spaces between lines as rooms or outside, each as a whole.

A blank hall looks like paper. So the class probabilities inside a space are combined with those
of the lines around it: doors lead from rooms into a hall, windows face a courtyard, and nothing
beyond a frame is a room.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Chances
from fpnet_core.io.pixel_classes import DOOR, WINDOW
from fpnet_core.raster.morphology import Mask, closed
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.windows import border_of

Array = NDArray[np.float64]
Labels = NDArray[np.int32]

LIKELY = 0.5
"""Given: probability threshold of a binary decision."""

SURELY = 0.8
"""Probability from which a class is sure. Chosen."""

_LEAST = 0.01  # numerical: smallest probability, so that log odds are finite
# Chosen, not measured:
_LEAKS = 0.12  # share of both sure classes in a leaking space
_GAP_PX = 5  # narrower gaps in lines are closed
_DOOR_WALLS = 2.0  # narrowest door over the thickness of walls
# Log odds [nats] that a door to a room adds and as much window subtracts, which is less: the
# parser sees windows beside doors that lead into a hall, too.
_DOOR, _WINDOW = 1.5, 0.2


def rooms_among_spaces(inside: Chances, is_shut: Mask, chances: Chances) -> Mask:
    """
    Return which pixels are in rooms.

    Parameters
    ----------
    inside : (H, W), probability that a pixel is inside the building
    is_shut : (H, W), mask of the lines that bound spaces
    chances : (K, H, W), class probabilities of each pixel of these lines

    Returns
    -------
    mask : (H, W)
        An enclosed space is in it or not as a whole, unless it is surely inside at some pixels
        and surely outside at others: then it leaks, and its pixels are classified one by one.
    """
    spaces, stats = pieces_of(~closed(is_shut, _GAP_PX), connectivity=4)
    count = len(stats)
    flat = spaces.ravel()
    size = np.maximum(np.bincount(flat, minlength=count), 1)
    mean, surely_in, surely_out = (
        np.bincount(flat, of_each.ravel(), count) / size
        for of_each in (inside, inside > SURELY, inside < 1.0 - SURELY)
    )
    leaks = np.minimum(surely_in, surely_out) > _LEAKS
    leaks[0] = True
    is_ground = leaks.copy()
    is_ground[border_of(spaces)] = True
    mean = np.clip(mean, _LEAST, 1.0 - _LEAST)
    odds = np.log(mean / (1.0 - mean))
    is_room = _refined_by_doors(odds > 0.0, is_ground, odds, *_lines_between(spaces, chances))
    return np.where(leaks[spaces], inside > LIKELY, is_room[spaces])


def _refined_by_doors(
    is_room: Mask, is_ground: Mask, odds: Array, a: Labels, b: Labels, doors: Array
) -> Mask:
    """
    Return which spaces (N,) are rooms, given doors and windows from other rooms to them.

    ``odds (N,)`` are log odds from the pixels of a space, ``doors`` those of the doors between
    spaces ``a`` and ``b``.
    """
    is_room, is_settled = is_room.copy(), is_ground.copy()
    while True:
        gain = odds + np.bincount(a, doors * is_room[b], len(odds))
        wrong = np.where(is_room, -gain, gain) * ~is_settled
        worst = int(wrong.argmax())
        if wrong[worst] <= 0.0:
            return is_room
        is_room[worst] = not is_room[worst]
        is_settled[worst] = True


def _lines_between(spaces: Labels, chances: Chances) -> tuple[Labels, Labels, Array]:
    """
    Return all crossings of a line by a row or a column, in both directions.

    These are the two spaces (N,) at its ends, and the log odds [nats] of a door there.
    """
    kinds = chances[[DOOR, WINDOW]]
    down = _across(spaces.T, kinds.transpose(0, 2, 1))
    first, second, length, door, window = np.concatenate([_across(spaces, kinds), down]).T
    narrowest = _DOOR_WALLS * max(float(np.median(length)) if length.size else 1.0, 1.0)
    doors = (_DOOR * door - _WINDOW * window) / narrowest
    a = np.concatenate([first, second]).astype(np.int32)
    return a, np.roll(a, len(first)), np.concatenate([doors, doors])


def _across(spaces: Labels, kinds: Chances) -> Array:
    """Return the crossings (N, 5) of lines by rows: both spaces, length, door, window."""
    flat = np.pad(spaces, ((0, 0), (1, 1)), constant_values=-1).ravel()
    edges = np.diff((flat == 0).astype(np.int8))
    begin, end = np.flatnonzero(edges == 1) + 1, np.flatnonzero(edges == -1) + 1
    kept = (flat[begin - 1] > 0) & (flat[end] > 0) & (flat[begin - 1] != flat[end])
    begin, end = begin[kept], end[kept]
    padded = np.pad(kinds, ((0, 0), (0, 0), (1, 1))).reshape(len(kinds), -1)
    summed = np.pad(np.cumsum(padded, axis=1, dtype=np.float64), ((0, 0), (1, 0)))
    means = (summed[:, end] - summed[:, begin]) / (end - begin)
    return np.column_stack([flat[begin - 1], flat[end], end - begin, means.T])
