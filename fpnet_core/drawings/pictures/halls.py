# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Halls, told by the doors that lead into them.

In the middle of a large hall the network sees no wall, and takes it for outside. What walls shut
in may be a hall, a courtyard or the paper within a sheet's frame: doors lead from rooms into a
hall, windows look upon a courtyard, and beyond a frame there is no room.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fpnet_core.drawings.pictures.thickness import wall_cells, walls_going_on
from fpnet_core.drawings.types import Chances
from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.morphology import Mask, closed, grown
from fpnet_core.raster.pieces import filled, pieces_of
from fpnet_core.raster.windows import border_of

LIKELY = 0.5
"""Numerical: a class of a pixel is more probable than not."""

_LEAST = 1e-9  # numerical
# Chosen, not measured:
_GAP_WALLS = 2.0  # times as thick as walls: narrower gaps in them are no ways
_LEAST_WALLS = 3.0  # times as long as walls are thick: smaller spaces are gaps between lines
_DOOR_WALLS = 2.0  # times as long as a wall is thick is the narrowest door
# Of the area of windows towards its rooms a hall has so much of doors: the network sees windows
# beside doors that lead into a hall, too.
_DOORS_SHARE = 0.12


def halls_of(looks: Sequence[Chances], ink: Mask) -> tuple[Mask, Mask]:
    """
    Return the halls (H, W) that the first of ``looks`` has outside, and the walls (H, W) of these.

    Walls are what the first look (K, H, W) at the sheet shows, and ``ink (H, W)`` that goes on
    from them as thick; of what these leave open, those that any of the looks shows. A gap as
    narrow as a doorway is no way out.
    """
    first = looks[0]
    near = _lines(first) | walls_going_on(first[WALL] > LIKELY, ink)
    wide = near | np.any([_lines(each) for each in looks], axis=0)
    halls, walls, known = (np.zeros(near.shape, np.bool_) for _ in range(3))
    for lines in (near, wide):
        reach = max(1, round(_GAP_WALLS * wall_cells(lines) / 2.0))
        found = np.zeros(near.shape, np.bool_)
        for space in _shut_in(~grown(lines, reach) & ~known, first[OUTSIDE] > LIKELY, reach):
            known |= space
            if _is_entered(first, space, reach):
                found |= space
        halls |= found & ~lines
        walls |= grown(found, reach + 1) & closed(lines, 2 * reach + 1)
    return halls, walls & ~halls


def _lines(chances: Chances) -> Mask:
    """Return where walls, windows or doors (H, W) are."""
    return np.asarray(1.0 - chances[OUTSIDE] - chances[FLOOR] > LIKELY)


def _shut_in(ways: Mask, outside: Mask, reach: int) -> list[Mask]:
    """Return the pieces (H, W) of ``ways`` away from the rim that are ``outside``, grown back."""
    spaces, found = pieces_of(ways, connectivity=4)
    lost = np.bincount(spaces.ravel(), outside.ravel(), len(found))
    is_lost = lost > (_LEAST_WALLS * reach) ** 2
    is_lost[0] = False
    is_lost[border_of(spaces)] = False
    return [grown(spaces == label, reach) for label in np.flatnonzero(is_lost)]


def given_halls(chances: Chances, halls: Mask, walls: Mask) -> Chances:
    """Return the probabilities (K, H, W) given where halls and their walls (H, W) are."""
    given = chances.copy()
    given[FLOOR][halls] += given[OUTSIDE][halls]
    given[OUTSIDE][halls | walls] = 0.0
    given /= np.maximum(given.sum(axis=0), _LEAST)
    return given


def _is_entered(chances: Chances, space: Mask, reach: int) -> bool:
    """
    Tell whether doors lead into a ``space (H, W)`` from rooms that it does not surround.

    Between it and them are walls, at most ``2 * reach`` thick.
    """
    rooms = (chances[FLOOR] > LIKELY) & ~filled(space)
    between = grown(space, reach + 1) & grown(rooms, reach + 1)
    doors, windows = (float(chances[k][between].sum()) for k in (DOOR, WINDOW))
    least = _DOOR_WALLS * wall_cells(chances[WALL] > LIKELY) ** 2
    return doors > max(least, _DOORS_SHARE * windows)
