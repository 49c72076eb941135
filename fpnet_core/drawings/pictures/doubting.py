# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether to believe a reading; if not, why, where on the drawing, and what to do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.pictures.doubt_model import DoubtModel, packaged_doubt_model
from fpnet_core.drawings.pictures.looking import ReadingView
from fpnet_core.drawings.pictures.plausible import findings
from fpnet_core.drawings.pictures.room_figures import ROOM_FIGURES, room_figures
from fpnet_core.drawings.pictures.sheet_figures import DOUBTFUL, lost_spaces, whole_figures
from fpnet_core.drawings.types import Box, Doubtful
from fpnet_core.raster.pixels import map_points

Array = NDArray[np.float64]

# Chosen, not measured:
_MOST_MARKED = 12  # places; more are no help
_FAR = 0.5  # of the probability from which on a reading is doubted
_SIDE = 1.0 / 3.0  # of the building's length is its left, its right, its top, its bottom

_PLACES = {'': 'in the middle', 'upper': 'at the top', 'lower': 'at the bottom'}

_IMAGE = 'draw that wall in an image editor'
_PLAIN = 'give a drawing without furniture, stairs and arrows'
_CAUSES = (
    ('lost', 'left outside the building: the outer wall has a gap or was not seen', _IMAGE),
    ('open', 'open to the outside: a wall has a wide gap or was not seen', _IMAGE),
    ('parted', 'cut by lines that are thinner or fainter than walls', _PLAIN),
    ('joined', 'crossed by lines that were not taken for walls', 'see whether they are walls'),
    ('unsure', 'cut otherwise if the building is larger or smaller', 'say the scale, --length'),
    ('rival', 'read otherwise by another way of reading the drawing', 'see which is right'),
    ('odd', 'of a shape that rooms seldom have', 'see whether a wall is missing'),
)  # fmt: skip


@dataclass(frozen=True)
class Doubts:
    """
    What is thought of a reading.

    ``wrong`` is its probability; ``reasons`` are sentences, none for a reading that is believed,
    and ``places`` where they lie on the drawing.
    """

    wrong: float
    reasons: tuple[str, ...] = ()
    places: tuple[Doubtful, ...] = ()


def doubts_of(look: ReadingView, model: DoubtModel | None = None) -> Doubts:
    """Return whether to believe a reading, by the packaged model or another one."""
    model = model or packaged_doubt_model()
    rooms, whole = room_figures(look), whole_figures(look)
    if not len(rooms):
        reason = look.segmentation.reason or 'nothing is enclosed'
        return Doubts(1.0, (f'No room was found: {reason}.',))
    wrong = model.wrong(whole, rooms)
    absurd = findings(look.segmentation)
    if wrong <= model.doubted_from:
        return Doubts(wrong, tuple(absurd))
    places = tuple(_places(look, rooms, model.right_rooms(rooms)))
    reasons = (*absurd, *_said(places, look))
    nothing = f'The rooms do not look like those of a building (wrong with {wrong:.2f}).'
    return Doubts(wrong, reasons or (nothing,), places[:_MOST_MARKED])


def is_believed(doubts: Doubts) -> bool:
    """Tell whether a reading is far from being doubted by the packaged model."""
    return doubts.wrong < _FAR * packaged_doubt_model().doubted_from


def _places(look: ReadingView, rooms: Array, right: Array) -> Iterator[Doubtful]:
    """Yield what is doubtful on the drawing, the surest first."""
    grid = look.segmentation.grid
    for row, col, height, width in lost_spaces(look):
        corners = np.array([[row, col], [row + height, col + width]], float) - 0.5
        yield Doubtful('lost', _box(look, grid.rc_to_xy(corners)))
    for number in np.argsort(right):
        if right[number] < DOUBTFUL:
            polygon = look.segmentation.rooms[number].polygon
            yield Doubtful(_cause(rooms[number]), _box(look, polygon))


def _cause(figures: Array) -> str:
    """Return what is most unusual of a room that is doubted."""
    seen = dict(zip(ROOM_FIGURES, figures.tolist(), strict=True))
    strength = {
        'open': 6.0 * seen['open'] + 6.0 * seen['bitten'],
        'parted': 2.0 * (1.0 - min(seen['thick'], seen['dark'])),
        'joined': seen['strokes'],
        'unsure': 1.2 * (1.0 - min(seen['smaller'], seen['larger'])),
        'rival': 1.0 - seen['rivals'] if np.isfinite(seen['rivals']) else 0.0,
        'odd': 0.3,
    }
    return max(strength, key=lambda name: strength[name])


def _box(look: ReadingView, xy: Array) -> Box:
    """Return the box in the drawing's pixels around places (N, 2) of the plan."""
    low, high = xy.min(axis=0), xy.max(axis=0)
    corners = np.array([low, [low[0], high[1]], high, [high[0], low[1]]])
    pixels = map_points(np.asarray(np.linalg.inv(look.H_plan_pixel), np.float64), corners)
    first, last = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0))
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])


def _said(places: Sequence[Doubtful], look: ReadingView) -> Iterator[str]:
    """Yield a sentence for each cause: how many, where, why and what to do."""
    rooms = np.concatenate([room.polygon for room in look.segmentation.rooms])
    whole = _box(look, rooms)
    for name, why, remedy in _CAUSES:
        boxes = [place.box for place in places if place.what == name]
        if boxes:
            what = ('space', 'spaces') if name == 'lost' else ('room', 'rooms')
            many = f'{len(boxes)} {what[1]} are' if len(boxes) > 1 else f'A {what[0]} is'
            where = ' and '.join(_where(boxes, whole))
            yield f'{many} {why} ({where}): {remedy}.'


def _where(boxes: Sequence[Box], whole: Box) -> list[str]:
    """Return in which parts of the building boxes lie, at most two, the commonest first."""
    named: dict[str, int] = {}
    left, top, right, bottom = whole
    for box in boxes:
        x = ((box[0] + box[2]) / 2.0 - left) / max(right - left, 1)
        y = ((box[1] + box[3]) / 2.0 - top) / max(bottom - top, 1)
        words = [
            *(['upper'] if y < _SIDE else ['lower'] if y > 1.0 - _SIDE else []),
            *(['left'] if x < _SIDE else ['right'] if x > 1.0 - _SIDE else []),
        ]
        name = _PLACES.get(' '.join(words), f'at the {" ".join(words)}')
        named[name] = named.get(name, 0) + 1
    return sorted(named, key=lambda name: -named[name])[:2]
