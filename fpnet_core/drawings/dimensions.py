# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scale votes of dimensions: each text with every span that it is centred on."""

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
"""Largest angle between a line and its axis [rad]. Chosen."""

DRAWN = 0.003
"""Relative error between drawn lengths and dimension texts. Chosen."""

# Chosen, not measured:
_REACH = 2.4  # in text heights: from the centre of a text to its dimension line
_ON_LINE = 0.15  # in text heights: segments within this distance are one line
_TOUCH = 0.5  # in text heights: gap between a tick or extension line and the dimension line
_CROSSING_SIN = 0.25  # sine of the smallest angle between crossing lines
_STATIONS = 4  # ticks on either side that may end the measured span
_MIDDLE = 0.06  # of the span: largest offset of a text from its centre
_TURNED = 1.15  # height to width of vertical text


@dataclass(frozen=True)
class _Text:
    """A text as a possible length; ``middle`` and ``height`` in pixels, ``axis`` 0 for x."""

    value_m: float
    unit: str
    middle: tuple[float, float]
    height: float
    axis: int


@dataclass(frozen=True, eq=False)
class DrawnLines:
    """Line segments: ``low``, ``high`` (N, 2) corners of their boxes, ``angle`` (N,) [rad]."""

    ends: Array
    low: Array
    high: Array
    angle: Array

    @staticmethod
    def of(strokes: Strokes) -> DrawnLines:
        """Return the straight segments of a drawing's strokes."""
        ends = strokes.ends[~strokes.is_curve]
        dx, dy = (ends[:, 1] - ends[:, 0]).T
        angle = np.mod(np.arctan2(dy, dx), np.pi)
        return DrawnLines(ends, ends.min(axis=1), ends.max(axis=1), angle)

    def __getitem__(self, chosen: NDArray[np.bool_]) -> DrawnLines:
        return DrawnLines(
            self.ends[chosen], self.low[chosen], self.high[chosen], self.angle[chosen]
        )


def dimension_votes(labels: Sequence[Label], lines: DrawnLines, error_px: float) -> list[Vote]:
    """Return the votes of texts beside lines; ``error_px`` is the error of line ends [pixels]."""
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
    """Yield the lengths that a text may state; a bare number once per plausible unit."""
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
    """Return the spans [pixels] that a text may dimension: between ticks on lines beside it."""
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
    """Return the positions along a line where segments end on it or cross it."""
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
    """Return the distances between stations on either side that are centred on ``centre``."""
    at = int(np.searchsorted(stations, centre))
    spans = []
    for left in stations[max(at - _STATIONS, 0) : at].tolist():
        for right in stations[at : at + _STATIONS].tolist():
            span = right - left
            if span > 0.0 and abs((left + right) / 2.0 - centre) < _MIDDLE * span:
                spans.append(span)
    return spans
