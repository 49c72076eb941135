# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Votes of dimensions: each text with each distance that it stands in the middle of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.lengths import lengths
from fpnet_core.drawings.types import Array, Label, Strokes
from fpnet_core.drawings.votes import Vote, VoteKind

PARALLEL = math.radians(1.5)
"""Angle by which a line may be off the axis that it is taken for [rad]. Chosen."""

DRAWN = 0.003
"""Share of a length to which a drawing's lines and its numbers agree. Chosen."""

# Chosen, not measured:
_REACH = 2.4  # of a text's height, from its middle to the line that it measures
_ON_LINE = 0.15  # of a text's height, within which pieces of a line are one line
_TOUCH = 0.5  # of a text's height, by which a tick or extension line may miss the line
_CROSSING_SIN = 0.25  # of the angle at which a line crosses another at least
_STATIONS = 4  # ticks on either side that may be the ends of what is measured
_MIDDLE = 0.06  # of the length, how far a text may be off the middle of its line
_TURNED = 1.15  # height to width of a text that is written upwards


@dataclass(frozen=True)
class _Text:
    """A text that may be a length [m] under a unit; ``middle``, ``height`` [pixels]; axis 0 x."""

    value_m: float
    unit: str
    middle: tuple[float, float]
    height: float
    axis: int


@dataclass(frozen=True, eq=False)
class DrawnLines:
    """Straight pieces: ``low``, ``high`` (N, 2) corners of their boxes, ``angle`` (N,) [rad]."""

    ends: Array
    low: Array
    high: Array
    angle: Array

    @staticmethod
    def of(strokes: Strokes) -> DrawnLines:
        """Return the straight pieces of a drawing's lines."""
        ends = strokes.ends[~strokes.is_curve]
        dx, dy = (ends[:, 1] - ends[:, 0]).T
        angle = np.mod(np.arctan2(dy, dx), np.pi)
        return DrawnLines(ends, ends.min(axis=1), ends.max(axis=1), angle)

    def __getitem__(self, chosen: NDArray[np.bool_]) -> DrawnLines:
        return DrawnLines(
            self.ends[chosen], self.low[chosen], self.high[chosen], self.angle[chosen]
        )


def dimension_votes(labels: Sequence[Label], lines: DrawnLines, error_px: float) -> list[Vote]:
    """Return the votes of texts beside lines whose ends are off by ``error_px`` [pixels]."""
    votes = []
    for number, label in enumerate(labels):
        texts = list(_texts(label))
        spans = _spans(texts[0], lines) if texts else []
        for text in texts:
            for span in spans:
                scale = math.log(text.value_m / span)
                kind, spread = VoteKind.DIMENSION, math.hypot(DRAWN, error_px / span)
                votes.append(Vote(scale, kind, text.value_m, number, text.unit, spread))
    return votes


def _texts(label: Label) -> Iterator[_Text]:
    """Yield what length a text may be; a bare number under each unit that is written so."""
    left, top, right, bottom = label.box
    width, height = right - left, bottom - top
    axis = 1 if height > _TURNED * width else 0
    place = ((left + right) / 2.0, (top + bottom) / 2.0)
    size = min(width, height) if axis == 1 else height
    if size <= 0.0:
        return
    text = label.text.strip()
    for value_m, unit in lengths(text):
        if value_m > 0.0:
            yield _Text(value_m, unit, place, size, axis)


def _spans(text: _Text, lines: DrawnLines) -> list[float]:
    """Return the lengths [pixels] that a text may measure: between ticks on lines beside it."""
    along, across = text.axis, 1 - text.axis
    centre, level = text.middle[along], text.middle[across]
    reach = _REACH * text.height
    is_near = (lines.low[:, across] < level + reach) & (lines.high[:, across] > level - reach)
    lines = lines[is_near]
    candidates = np.flatnonzero(np.abs(np.sin(lines.angle - along * np.pi / 2.0)) < PARALLEL)
    levels = lines.ends[candidates, :, across].mean(axis=1)
    spans: list[float] = []
    for height in _clusters(levels, _ON_LINE * text.height):
        on_line = candidates[np.abs(levels - height) < _ON_LINE * text.height]
        stations = _stations(on_line, height, text, lines)
        spans.extend(_pairs(stations, centre))
    return sorted({round(span, 2) for span in spans})


def _clusters(levels: Array, width: float) -> list[float]:
    """Return levels that differ by more than ``width``."""
    found: list[float] = []
    for level in np.sort(levels).tolist():
        if not found or level - found[-1] > width:
            found.append(level)
    return found


def _stations(on_line: Array, level: float, text: _Text, lines: DrawnLines) -> Array:
    """Return where along a line something ends on it or crosses it, near the text."""
    along, across = text.axis, 1 - text.axis
    own = lines.ends[on_line][:, :, along].ravel()
    low, high = float(own.min()), float(own.max())
    touch = _TOUCH * text.height
    crossing = (lines.low[:, across] < level + touch) & (lines.high[:, across] > level - touch)
    crossing &= (lines.low[:, along] < high + touch) & (lines.high[:, along] > low - touch)
    crossing &= np.abs(np.sin(lines.angle - along * np.pi / 2.0)) > _CROSSING_SIN
    ends = lines.ends[crossing]
    depth = ends[:, 1, across] - ends[:, 0, across]
    share = np.clip((level - ends[:, 0, across]) / depth, -1.0, 2.0)
    cuts = ends[:, 0, along] + share * (ends[:, 1, along] - ends[:, 0, along])
    stations: Array = np.unique(np.round(np.concatenate([own, cuts]), 1))
    return stations


def _pairs(stations: Array, centre: float) -> list[float]:
    """Return distances between stations on either side that have ``centre`` in the middle."""
    at = int(np.searchsorted(stations, centre))
    spans = []
    for left in stations[max(at - _STATIONS, 0) : at].tolist():
        for right in stations[at : at + _STATIONS].tolist():
            span = right - left
            if span > 0.0 and abs((left + right) / 2.0 - centre) < _MIDDLE * span:
                spans.append(span)
    return spans
