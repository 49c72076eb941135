# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What speaks for and against a reading as a whole, in figures that need no scale."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.pictures.looking import WHAT_IFS, ReadingView
from fpnet_core.drawings.pictures.plausible import FEATURES, features
from fpnet_core.drawings.pictures.room_figures import ROOM_FIGURES
from fpnet_core.drawings.pictures.thickness import wall_cells, walls_going_on
from fpnet_core.raster.morphology import Mask, grown
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.windows import NEIGHBOURS, border_of
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import FREE, UNKNOWN

Array = NDArray[np.float64]
Labels = NDArray[np.int32]

TRUST_FIGURES = ('certainty', 'wall_certainty', 'unsure', 'agreement')
"""As in :class:`fpnet_core.drawings.types.Trust`."""

WHOLE_FIGURES = (
    'plausible', 'rivals', 'best_rival', 'top_rival', 'top_odds', 'lost', 'lost_top',
    *(f'{name}_rooms' for name in WHAT_IFS),
    'open', 'shut_out', 'unread', 'walls_beside', 'specks', *TRUST_FIGURES,
)  # fmt: skip
ROOM_SUMMARY = ('expected', 'doubtful', 'least', 'log_odds', 'expected_area', 'expected_f1')
SHEET_FIGURES = (*WHOLE_FIGURES, *ROOM_SUMMARY)

_AS_LOGS = ('lost', 'lost_top', 'shut_out', 'unread', 'walls_beside')
_AS_ODDS = (
    'plausible', 'rivals', *(f'{name}_rooms' for name in WHAT_IFS),
    'expected', 'least', 'expected_area', 'expected_f1',
)  # fmt: skip
# Chosen, not measured:
_LEAST_SHARE = 0.02  # of rooms or area; less is as good as nothing
_LEAST_ROOM = 0.2  # of the median room's area: smaller pieces are no rooms that were lost
_SURE_LINE = 0.5  # of the usual wall's contrast
_TOUCHING = 0.3  # of the root of its area a lost room shares with the building
_WALLS_AWAY = 2.0  # of the usual wall's thickness is between rooms on both sides of it
DOUBTFUL = 0.5  # a room that is right with less
_LEAST_COUNTED = 0.1  # of the median room's area: smaller ones are not missed


def whole_figures(look: ReadingView) -> Array:
    """Return the figures (F,) of a reading as a whole, in the order of ``WHOLE_FIGURES``."""
    found = {**_of_rivals(look), **_of_what_ifs(look), **_of_walls(look), **_of_network(look)}
    return np.array([found[name] for name in WHOLE_FIGURES])


def sheet_evidence(whole: Array, rooms: Array, right: Array) -> Array:
    """
    Return what speaks for and against a reading, in the order of ``SHEET_FIGURES``.

    ``whole (F,)`` are its own figures, ``rooms (R, D)`` those of its rooms, of which each is
    ``right (R,)`` with so much probability. Shares come as logarithms or log odds, so that they
    add up; what could not be measured is NaN.
    """
    found = dict(zip(WHOLE_FIGURES, whole.tolist(), strict=True))
    found |= _of_rooms(found['shut_out'], rooms, right)
    found |= {name: float(np.log(found[name] + _LEAST_SHARE)) for name in _AS_LOGS}
    found |= {name: _odds(found[name]) for name in _AS_ODDS}
    return np.array([found[name] for name in SHEET_FIGURES])


def _odds(share: float) -> float:
    held = np.clip(share, _LEAST_SHARE, 1.0 - _LEAST_SHARE)
    return float(np.log(held / (1.0 - held)))


def _of_rooms(shut_out: float, rooms: Array, right: Array) -> dict[str, float]:
    """Return what the rooms come to, where ``shut_out`` of their area was left outside."""
    if not right.size:
        return dict.fromkeys(ROOM_SUMMARY, 0.0)
    area = np.exp(rooms[:, ROOM_FIGURES.index('size')])
    counted = right[area > _LEAST_COUNTED]
    hits = counted.mean()
    return {
        'expected': hits,
        'doubtful': float(np.mean(counted < DOUBTFUL)),
        'least': float(np.quantile(right, 0.1)),
        'log_odds': float(np.mean([_odds(each) for each in right.tolist()])),
        'expected_area': float(np.average(right, weights=area)),
        # Found and true rooms: as many as were found, the right ones and those left outside.
        'expected_f1': 2.0 * hits / (1.0 + hits + shut_out),
    }


def _of_network(look: ReadingView) -> dict[str, float]:
    if look.trust is None:
        return dict.fromkeys(TRUST_FIGURES, np.nan)
    return {name: float(getattr(look.trust, name)) for name in TRUST_FIGURES}


def _of_rivals(look: ReadingView) -> dict[str, float]:
    labels = look.segmentation.labels
    alike = np.array([room_agreement(rival, labels).f1 for rival in look.rivals])
    beside = _beside_building(look)
    lost = np.array([_lost_rooms(look, rival, beside) for rival in look.rivals])
    if not alike.size:
        return {
            'plausible': look.plausible, 'rivals': np.nan, 'best_rival': np.nan,
            'top_rival': np.nan, 'top_odds': np.nan, 'lost': np.nan, 'lost_top': np.nan,
        }  # fmt: skip
    return {
        'plausible': look.plausible,
        'rivals': float(np.average(alike, weights=look.shares)),
        'best_rival': float(alike.max()),
        'top_rival': float(alike[0]),
        'top_odds': float(np.log((look.plausible + 0.01) / (look.weights[0] + 0.01))),
        'lost': float(np.average(lost, weights=look.shares)),
        'lost_top': float(lost[0]),
    }


def _lost_rooms(look: ReadingView, rival: Labels, beside: Mask) -> float:
    """Return how many rooms of a rival lie ``beside`` the building, per room of the reading."""
    cells = look.segmentation.grid.cells
    count = int(rival.max(initial=0))
    size = np.bincount(rival.ravel(), minlength=count + 1)[1:]
    gone = np.bincount(rival[cells == UNKNOWN], minlength=count + 1)[1:]
    near = np.bincount(rival[beside], minlength=count + 1)[1:]
    is_room = size > _LEAST_ROOM * np.median(size) if size.size else np.zeros(0, np.bool_)
    lost = np.count_nonzero(is_room & (gone > 0.5 * size) & (near > _TOUCHING * np.sqrt(size)))
    return lost / max(len(look.segmentation.rooms), 1)


def _beside_building(look: ReadingView) -> Mask:
    """Return what (H, W) of the outside lies within a wall's thickness of the building."""
    known = look.segmentation.grid.cells != UNKNOWN
    near = grown(known, round(_WALLS_AWAY * wall_cells(look.walls)) + 1)
    return np.asarray(near & ~known)


def _of_what_ifs(look: ReadingView) -> dict[str, float]:
    labels = look.segmentation.labels
    return {
        f'{name}_rooms': room_agreement(other, labels).f1 for name, other in look.what_if.items()
    }


def _of_walls(look: ReadingView) -> dict[str, float]:
    cells, walls = look.segmentation.grid.cells, look.walls
    free = cells == FREE
    ends = _beside(free, cells == UNKNOWN)
    sure = look.levels > _SURE_LINE * look.tone
    unread = sure & ~grown(walls, 2)
    return {
        'open': ends / max(ends + _beside(free, walls), 1),
        'shut_out': _shut_out(look),
        'unread': float(np.count_nonzero(unread & free) / max(int(np.count_nonzero(free)), 1)),
        'walls_beside': _walls_beside(look, sure),
        'specks': float(features(look.segmentation)[FEATURES.index('specks')]),
    }


def _walls_beside(look: ReadingView, sure: Mask) -> float:
    """Return how much that looks like a wall goes on outside, per area of the reading's walls."""
    walls = look.walls
    outside = (look.segmentation.grid.cells == UNKNOWN) & ~grown(walls, 2)
    beside = walls_going_on(walls, sure) & outside
    return int(np.count_nonzero(beside)) / max(int(np.count_nonzero(walls)), 1)


def _beside(one: Mask, other: Mask) -> int:
    """Count the pairs of neighbouring cells of which one is here and one there."""
    return sum(
        int(
            np.count_nonzero(one[here] & other[there]) + np.count_nonzero(one[there] & other[here])
        )
        for here, there in NEIGHBOURS
    )


def _shut_out(look: ReadingView) -> float:
    """Return the area that lines close and the reading has outside, per area of its rooms."""
    rooms = int(np.count_nonzero(look.segmentation.labels))
    return sum(size for _, size in _closed_outside(look)) / max(rooms, 1)


def lost_spaces(look: ReadingView) -> list[tuple[int, int, int, int]]:
    """Return boxes (row, column, height, width) of closed spaces that the reading has outside."""
    return [box for box, _ in sorted(_closed_outside(look), key=lambda each: -each[1])]


def _closed_outside(look: ReadingView) -> list[tuple[tuple[int, int, int, int], int]]:
    """
    Return boxes and sizes in cells of spaces beside the building that lines close outside it.

    They are as large as rooms and share a wall with the building. A sheet's frame goes around it.
    """
    labels = look.segmentation.labels
    size = np.bincount(labels.ravel())[1:]
    if not (size > 0).any():
        return []
    least = _LEAST_ROOM * float(np.median(size[size > 0]))
    lines = look.levels > _SURE_LINE * look.tone
    outside = ~lines & (look.segmentation.grid.cells == UNKNOWN)
    pieces, stats = pieces_of(outside, connectivity=4)
    touching = np.bincount(pieces[_beside_building(look)], minlength=len(stats))
    area = stats[:, cv2.CC_STAT_AREA]
    is_lost = (area > least) & (touching > _TOUCHING * np.sqrt(area))
    is_lost[0] = False
    is_lost[np.unique(border_of(pieces))] = False
    middle = np.argwhere(labels > 0).mean(axis=0)
    return [
        ((int(top), int(left), int(height), int(width)), int(cells))
        for left, top, width, height, cells in stats[is_lost]
        if not (top < middle[0] < top + height and left < middle[1] < left + width)
    ]
