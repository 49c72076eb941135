# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Which spaces between lines are rooms: each is one or not as a whole, and lines agree with it.

A blank hall looks like paper wherever one looks. So what the parser says of a space's ground is
weighed with what it says of the lines around it: doors lead from rooms into a hall, windows look
upon a courtyard, and beyond a frame there is no room.
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
"""Given: what is more probable than not."""

_LEAST = 0.01  # numerical: of a probability, so that its log odds are finite
# Chosen, not measured:
_LEAKS, _SURELY = 0.12, 0.8  # of a space is one, and as much the other, for sure
_GAP_PX = 5  # lines go on across narrower gaps
_DOOR_WALLS = 2.0  # times as wide as walls are thick is the narrowest door
# Nats for each door from a room into a space, and less for as much window between them: the
# parser sees windows beside doors that lead into a hall, too.
_DOOR, _WINDOW = 1.5, 0.2


def rooms_among_spaces(inside: Chances, is_shut: Mask, chances: Chances) -> Mask:
    """
    Return what is inside.

    Parameters
    ----------
    inside : (H, W), how probably each pixel is within the building
    is_shut : (H, W), the lines that bound spaces
    chances : (K, H, W) of what each pixel of these lines is

    Returns
    -------
    mask : (H, W)
        A space that lines shut off is in it or not as a whole, unless it is surely in at some
        places and surely out at others: then it leaks, and its pixels are told one by one.
    """
    spaces, stats = pieces_of(~closed(is_shut, _GAP_PX), connectivity=4)
    count = len(stats)
    flat = spaces.ravel()
    size = np.maximum(np.bincount(flat, minlength=count), 1)
    mean, surely_in, surely_out = (
        np.bincount(flat, of_each.ravel(), count) / size
        for of_each in (inside, inside > _SURELY, inside < 1.0 - _SURELY)
    )
    leaks = np.minimum(surely_in, surely_out) > _LEAKS
    leaks[0] = True
    is_ground = leaks.copy()
    is_ground[border_of(spaces)] = True
    mean = np.clip(mean, _LEAST, 1.0 - _LEAST)
    odds = np.log(mean / (1.0 - mean))
    is_room = _as_lines_say(odds > 0.0, is_ground, odds, *_lines_between(spaces, chances))
    return np.where(leaks[spaces], inside > LIKELY, is_room[spaces])


def _as_lines_say(
    is_room: Mask, is_ground: Mask, odds: Array, a: Labels, b: Labels, doors: Array
) -> Mask:
    """
    Return which spaces (N,) are rooms given the doors and windows that rooms have towards them.

    ``odds (N,)`` are those that a space's ground tells, ``doors`` how many stand between spaces
    ``a`` and ``b``.
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
    Return each stretch of a line that a row or a column crosses, from either side.

    The two spaces (N,) at its ends, and how many nats of a door are there.
    """
    kinds = chances[[DOOR, WINDOW]]
    down = _across(spaces.T, kinds.transpose(0, 2, 1))
    first, second, length, door, window = np.concatenate([_across(spaces, kinds), down]).T
    narrowest = _DOOR_WALLS * max(float(np.median(length)) if length.size else 1.0, 1.0)
    doors = (_DOOR * door - _WINDOW * window) / narrowest
    a = np.concatenate([first, second]).astype(np.int32)
    return a, np.roll(a, len(first)), np.concatenate([doors, doors])


def _across(spaces: Labels, kinds: Chances) -> Array:
    """Return the stretches (N, 5) of lines along rows: both spaces, how long, door, window."""
    flat = np.pad(spaces, ((0, 0), (1, 1)), constant_values=-1).ravel()
    edges = np.diff((flat == 0).astype(np.int8))
    begin, end = np.flatnonzero(edges == 1) + 1, np.flatnonzero(edges == -1) + 1
    kept = (flat[begin - 1] > 0) & (flat[end] > 0) & (flat[begin - 1] != flat[end])
    begin, end = begin[kept], end[kept]
    padded = np.pad(kinds, ((0, 0), (0, 0), (1, 1))).reshape(len(kinds), -1)
    summed = np.pad(np.cumsum(padded, axis=1, dtype=np.float64), ((0, 0), (1, 0)))
    means = (summed[:, end] - summed[:, begin]) / (end - begin)
    return np.column_stack([flat[begin - 1], flat[end], end - begin, means.T])
