# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Texts printed in rooms: areas and sizes for the scale, names and numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import math
import re

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.lengths import areas, lengths, ratios, room_sizes, without_area
from fpnet_core.drawings.types import Array, Label
from fpnet_core.drawings.votes import Vote, VoteKind
from fpnet_core.raster.pixels import map_points
from fpnet_core.raster.windows import EVERY_SIDE

Labels = NDArray[np.int32]

# Chosen, not measured:
_SPREAD = 0.015  # sigma of log scale: rooms are exact to 1 or 2 pixels
_SQUARE = 0.06  # largest difference of log scale between the two sides of a room
_MOST_SUMMED = 6  # up to this many areas in one space are taken as those of its parts
_FEWEST_PX = 40  # smallest room that votes
_LONGEST_NAME = 40  # longest name of a room [characters]
_LEAST_NUMBER = 3  # shortest room number behind a name [characters]

_NUMBER = re.compile(r'(?=\S*\d)[A-Z]{0,3}[-. ]?\d[\w./-]{0,9}')
_NAME = re.compile(r'[^\W\d_]{2,}')


@dataclass(frozen=True)
class PrintedRoom:
    """
    Texts printed in a room; ``label`` is the label of the room.

    ``name`` and ``number`` are empty and ``area_m2`` is None if not printed.
    """

    label: int
    name: str = ''
    number: str = ''
    area_m2: float | None = None


def mapped(labels: Sequence[Label], H: Array) -> tuple[Label, ...]:
    """Return labels with their boxes mapped by ``H (3, 3)``, e.g. from pixels to cells."""
    if not labels:
        return ()
    box = np.array([label.box for label in labels])
    corners = np.stack([box[:, [0, 1]], box[:, [2, 1]], box[:, [2, 3]], box[:, [0, 3]]], axis=1)
    moved = map_points(H, corners.reshape(-1, 2)).reshape(-1, 4, 2)
    boxes = np.concatenate([moved.min(axis=1), moved.max(axis=1)], axis=1).tolist()
    return tuple(
        replace(label, box=(x0, y0, x1, y1))
        for label, (x0, y0, x1, y1) in zip(labels, boxes, strict=True)
    )


def room_votes(labels: Sequence[Label], rooms: Labels, edge_px: float = 0.0) -> list[Vote]:
    """
    Return the scale votes of areas and sizes printed in rooms.

    Parameters
    ----------
    labels : boxes in pixels of ``rooms``; votes are metres per such pixel
    rooms : (H, W) int, 0 outside of rooms, row 0 at the top
    edge_px : distance by which rooms extend beyond their pixels on every side
    """
    at = rooms_at(labels, rooms)
    count_px = np.bincount(rooms.ravel())
    area_px = count_px + edge_px * _edges(rooms, len(count_px))
    votes: list[Vote] = []
    for room in np.unique(at[at > 0]).tolist():
        if count_px[room] < _FEWEST_PX:
            continue
        inside = np.flatnonzero(at == room).tolist()
        printed = [(number, list(areas(labels[number].text))) for number in inside]
        printed = [(number, values) for number, values in printed if values]
        votes += _area_votes(printed, float(area_px[room]))
        sized = [(number, list(room_sizes(labels[number].text))) for number in inside]
        if any(sizes for _, sizes in sized):
            mask = rooms == room
            for number, sizes in sized:
                votes += _size_votes(number, sizes, labels[number], mask, 2.0 * edge_px)
    return votes


def rooms_at(labels: Sequence[Label], rooms: Labels) -> NDArray[np.int64]:
    """
    Return the label (N,) in ``rooms (H, W)`` of the room under most of each text, 0 for none.

    A majority suffices, as letters parsed as walls leave holes in a room.
    """
    found = np.zeros(len(labels), np.int64)
    height, width = rooms.shape
    for number, label in enumerate(labels):
        left, top, right, bottom = label.box
        rows = slice(max(0, math.floor(top)), min(height, math.ceil(bottom) + 1))
        cols = slice(max(0, math.floor(left)), min(width, math.ceil(right) + 1))
        counts = np.bincount(rooms[rows, cols].ravel(), minlength=1)
        if counts[1:].any() and 2 * counts[1:].max() > counts[1:].sum():
            found[number] = 1 + int(np.argmax(counts[1:]))
    return found


def _edges(rooms: Labels, count: int) -> Array:
    """Return the number of boundary pixel sides of each room (``count``,)."""
    sides = np.zeros(count)
    for here, there in EVERY_SIDE:
        is_edge = rooms[here] != rooms[there]
        sides += np.bincount(rooms[here][is_edge], minlength=count)
    return sides


def _area_votes(printed: list[tuple[int, list[float]]], area_px: float) -> Iterator[Vote]:
    """Yield a vote per area in a room, and one for the sum if there are several."""
    kind = VoteKind.AREA
    for number, values in printed:
        for area_m2 in values:
            spread = math.hypot(_SPREAD, _rounding(area_m2))
            scale = 0.5 * math.log(area_m2 / area_px)
            yield Vote(scale, kind, math.sqrt(area_m2), number, '', spread)
    if 1 < len(printed) <= _MOST_SUMMED:
        # The sum is attributed to one text, the one with the largest area.
        total_m2 = sum(values[0] for _, values in printed)
        scale = 0.5 * math.log(total_m2 / area_px)
        number, values = max(printed, key=lambda each: each[1][0])
        yield Vote(scale, kind, math.sqrt(values[0]), number, '', _SPREAD)


def _rounding(area_m2: float) -> float:
    """Return the standard deviation of half the log of an area due to its rounding."""
    step = 1.0 if area_m2 == round(area_m2) else 0.1
    return 0.5 * step / area_m2 / math.sqrt(12.0)


def _size_votes(
    number: int,
    sizes: list[tuple[float, float, str]],
    label: Label,
    mask: NDArray[np.bool_],
    more_px: float,
) -> Iterator[Vote]:
    """Yield the votes of a printed size for extents of a room with its proportions."""
    for first_m, second_m, unit in sizes:
        kept: list[float] = []
        for width, height in _sides(label, mask):
            for across, along in ((width, height), (height, width)):
                one = math.log(first_m / (across + more_px))
                two = math.log(second_m / (along + more_px))
                scale = 0.5 * (one + two)
                is_new = all(abs(scale - other) > _SPREAD for other in kept)
                if abs(one - two) < _SQUARE and is_new:
                    kept.append(scale)
                    value = math.sqrt(first_m * second_m)
                    yield Vote(scale, VoteKind.SIZE, value, number, unit, _SPREAD)


def _sides(label: Label, mask: NDArray[np.bool_]) -> Iterator[tuple[float, float]]:
    """Yield width and height [pixels] of a room: at the text, overall, and median."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, top, right, bottom = label.box
    widths = mask[_range(top, bottom, mask.shape[0])].sum(axis=1)
    heights = mask[:, _range(left, right, mask.shape[1])].sum(axis=0)
    if widths.any() and heights.any():
        yield float(np.median(widths)), float(np.median(heights))
    yield float(np.ptp(rows) + 1), float(np.ptp(cols) + 1)
    # The median ignores niches and doorways, which enlarge the overall extent.
    yield float(np.median(mask.sum(axis=1)[rows])), float(np.median(mask.sum(axis=0)[cols]))


def _range(low: float, high: float, size: int) -> slice:
    first = min(max(0, math.floor(low)), size - 1)
    return slice(first, max(first + 1, min(size, math.ceil(high) + 1)))


def printed_of_rooms(labels: Sequence[Label], rooms: Labels) -> tuple[PrintedRoom, ...]:
    """
    Return the texts printed in each room that has any, in the order of the rooms' labels.

    Parameters
    ----------
    labels : boxes in pixels of ``rooms``
    rooms : (H, W) int, 0 outside of rooms, row 0 at the top
    """
    at = rooms_at(labels, rooms)
    found = []
    for room in np.unique(at[at > 0]).tolist():
        inside = [labels[number] for number in np.flatnonzero(at == room).tolist()]
        inside.sort(key=lambda label: (label.box[1], label.box[0]))
        printed = _printed(room, [label.text.strip() for label in inside])
        if printed != PrintedRoom(room):
            found.append(printed)
    return tuple(found)


def _printed(room: int, texts: list[str]) -> PrintedRoom:
    known = [area_m2 for text in texts for area_m2 in list(areas(text))[:1]]
    names, numbers = [], []
    for text in map(without_area, texts):
        if any(room_sizes(text)) or any(ratios(text)) or _is_length(text):
            continue
        name, number = _name_and_number(text)
        names += [name] if name else []
        numbers += [number] if number else []
    area_m2 = known[0] if len(known) == 1 else None
    name = ' '.join(names)[:_LONGEST_NAME]
    return PrintedRoom(room, name, numbers[0] if numbers else '', area_m2)


def _name_and_number(text: str) -> tuple[str, str]:
    """Return the room name and room number in a text; empty where missing."""
    if _NUMBER.fullmatch(text):
        return '', text
    words = text.split()
    if not _NAME.search(text) or len(text) > _LONGEST_NAME:
        return '', ''
    if len(words) > 1 and _NUMBER.fullmatch(words[0]):
        return ' '.join(words[1:]), words[0]
    is_numbered = len(words) > 1 and _NUMBER.fullmatch(words[-1])
    if is_numbered and len(words[-1]) >= _LEAST_NUMBER:  # 'Bedroom 2' is a name
        return ' '.join(words[:-1]), words[-1]
    return text, ''


def _is_length(text: str) -> bool:
    """Return whether a text is a length with unit; a bare number may be a room number."""
    return any(unit == '' for _, unit in lengths(text))
