# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The scale that a drawing itself states: by its dimensions, its scale bar, or as 1:100.

Nothing is believed for a single number. Dimensions vote: each text with each line that it may
measure; a scale must win more votes of different lengths than chance would give it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import math
import re

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.lengths import WRITTEN_UNITS_M, lengths, number_and_unit
from fpnet_core.drawings.types import (
    Array,
    Drawing,
    DrawingScale,
    Label,
    ScaleSource,
    Strokes,
)

_RATIO = re.compile(r'(?<![\d:/.])1\s*[:/]\s*(\d{1,4})(?![\d:/.,])')
# Physical: scales that drawings are made at.
_RATIOS = frozenset({10, 20, 25, 33, 50, 75, 100, 125, 150, 200, 250, 300, 400, 500, 750, 1000})

_MAX_LABELS = 600  # numerical: that are looked at
# Chosen, not measured:
_PARALLEL = math.radians(1.5)
_REACH = 2.4  # of a text's height, from its middle to the line that it measures
_ON_LINE = 0.15  # of a text's height, within which pieces of a line are one line
_TOUCH = 0.5  # of a text's height, by which a tick or extension line may miss the line
_CROSSING_SIN = 0.25  # of the angle at which a line crosses another at least
_STATIONS = 4  # ticks on either side that may be the ends of what is measured
_MIDDLE = 0.06  # of the length, how far a text may be off the middle of its line
_WINDOW = 0.006  # logarithm, within which votes agree: lines are drawn to the pixel's tenth
_RANGE = math.log(2_000.0)  # numerical: of resolutions that a vote may be for
_CHANCE = 1e-3  # expected number of scales that would win as many votes by chance
_TYPICAL_M = 3.5  # length that a dimension gives
_MIN_VALUES = 3  # different lengths that agree
_DIFFERENT = 0.03  # lengths that differ less are the same
_EXACT = 0.01  # half the interval of a scale that dimensions or a bar give
_PAPER = 0.02  # of one that is stated as 1:100
_AGREE = 0.03  # logarithm, within which a bar and dimensions agree
_DOORS_M = (0.55, 1.5)  # median width of doors that a scale must give
_MIN_DOORS = 3
_SIZE_M = (3.0, 3_000.0)  # of the whole drawing
_TURNED = 1.15  # height to width of a text that is written upwards


@dataclass(frozen=True)
class _Text:
    """A text that may be a length [m] under a unit; ``middle``, ``height`` [pixels]; axis 0 x."""

    value_m: float
    unit: str
    middle: tuple[float, float]
    height: float
    axis: int


def annotated_scale(drawing: Drawing) -> DrawingScale | None:
    """
    Return the scale that a vector drawing states, None where nothing consistent is there.

    Dimension texts with the lines that they measure, scale bars with their ticks, and a stated
    1:100 if the format has a paper size and doors bear it out. They must not contradict.
    """
    if drawing.strokes is None or not drawing.labels or not len(drawing.strokes.ends):
        return None
    labels = drawing.labels[:_MAX_LABELS]
    lines = _Lines.of(drawing.strokes)
    dimensions = dimension_scale(drawing, labels, lines)
    bar = bar_scale(drawing, labels, lines)
    paper = paper_scale(drawing, labels)
    if dimensions is not None and bar is not None:
        apart = abs(math.log(dimensions.resolution_m / bar.resolution_m))
        return dimensions if apart < _AGREE else None
    return dimensions or bar or paper


def _plausible(drawing: Drawing, resolution_m: float) -> bool:
    """Tell whether a drawing has the size of a building, and its doors that of doors."""
    size_m = max(drawing.pixels.shape[:2]) * resolution_m
    if not _SIZE_M[0] < size_m < _SIZE_M[1]:
        return False
    if len(drawing.door_px) < _MIN_DOORS:
        return True
    door_m = float(np.median(drawing.door_px)) * resolution_m
    return _DOORS_M[0] < door_m < _DOORS_M[1]


@dataclass(frozen=True, eq=False)
class _Lines:
    """Straight pieces: ``low``, ``high`` (N, 2) corners of their boxes, ``angle`` (N,) [rad]."""

    ends: Array
    low: Array
    high: Array
    angle: Array

    @staticmethod
    def of(strokes: Strokes) -> _Lines:
        ends = strokes.ends[~strokes.is_curve]
        dx, dy = (ends[:, 1] - ends[:, 0]).T
        angle = np.mod(np.arctan2(dy, dx), np.pi)
        return _Lines(ends, ends.min(axis=1), ends.max(axis=1), angle)

    def __getitem__(self, chosen: NDArray[np.bool_]) -> _Lines:
        return _Lines(self.ends[chosen], self.low[chosen], self.high[chosen], self.angle[chosen])


def dimension_scale(
    drawing: Drawing, labels: tuple[Label, ...], lines: _Lines
) -> DrawingScale | None:
    """Return the scale that dimensions agree on."""
    votes = [vote for label in labels for vote in _votes(label, lines)]
    winners = []
    for unit in ('m', 'cm', 'mm'):
        winner = _winner([vote for vote in votes if vote[2] in (unit, '')])
        if winner is not None and _plausible(drawing, winner.resolution_m):
            winners.append(winner)
    if not winners:
        return None
    # 625 is 6.25 m rather than 0.6 m, and 6250 is so as well: lengths of rooms tell cm from mm.
    best = max(winners, key=lambda w: (w.count, -abs(math.log(w.typical_m / _TYPICAL_M))))
    why = f'{best.count} dimensions agree'
    return _scale(best.resolution_m, _EXACT, ScaleSource.DIMENSIONS, why)


def _votes(label: Label, lines: _Lines) -> list[tuple[float, float, str, int]]:
    """Return (log resolution, metres, unit, which label) for each line that a text may measure."""
    votes = []
    texts = list(_texts(label))
    spans = _spans(texts[0], lines) if texts else []
    for text in texts:
        for span in spans:
            resolution = math.log(text.value_m / span)
            votes.append((resolution, text.value_m, text.unit, id(label)))
    return votes


@dataclass(frozen=True)
class _Winner:
    """A scale: how many texts agree on it, and the median of what they say [m]."""

    count: int
    resolution_m: float
    typical_m: float


def _winner(votes: list[tuple[float, float, str, int]]) -> _Winner | None:
    """Return the scale with most votes of different lengths, None if chance has as many."""
    if len(votes) < _MIN_VALUES:
        return None
    votes = sorted(votes)
    logs = np.array([vote[0] for vote in votes])
    best: tuple[int, int, int, int] = (0, 0, 0, 0)
    stops = np.searchsorted(logs, logs + 2.0 * _WINDOW, side='right')
    for start, stop in enumerate(stops.tolist()):
        members = votes[start:stop]
        values = _different([vote[1] for vote in members])
        labels = len({vote[3] for vote in members})
        best = max(best, (values, labels, start, stop))
    values, labels, start, stop = best
    rate = len(votes) * 2.0 * _WINDOW / _RANGE
    if values < _MIN_VALUES or _expected(rate, values) > _CHANCE:
        return None
    typical_m = float(np.median([vote[1] for vote in votes[start:stop]]))
    return _Winner(labels, math.exp(float(np.median(logs[start:stop]))), typical_m)


def _different(values: list[float]) -> int:
    """Return how many different lengths there are."""
    ordered = np.sort(np.log(values))
    count, last = 0, -math.inf
    for value in ordered.tolist():
        if value - last > _DIFFERENT:
            count, last = count + 1, value
    return count


def _expected(rate: float, count: int) -> float:
    """Return how many scales would win ``count`` votes if votes were spread by chance."""
    bins = _RANGE / (2.0 * _WINDOW)
    tail = math.exp(-rate) * rate**count / math.factorial(count) * (1.0 + rate)
    return bins * tail


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


def _spans(text: _Text, lines: _Lines) -> list[float]:
    """Return the lengths [pixels] that a text may measure: between ticks on lines beside it."""
    along, across = text.axis, 1 - text.axis
    centre, level = text.middle[along], text.middle[across]
    reach = _REACH * text.height
    is_near = (lines.low[:, across] < level + reach) & (lines.high[:, across] > level - reach)
    lines = lines[is_near]
    candidates = np.flatnonzero(np.abs(np.sin(lines.angle - along * np.pi / 2.0)) < _PARALLEL)
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


def _stations(on_line: Array, level: float, text: _Text, lines: _Lines) -> Array:
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


def bar_scale(drawing: Drawing, labels: tuple[Label, ...], lines: _Lines) -> DrawingScale | None:
    """Return the scale of a scale bar: numbers from 0 at even distances, each at a tick."""
    zeros = [label for label in labels if number_and_unit(label.text)[0] == 0.0]
    found = [fit for zero in zeros for fit in [_bar_fit(zero, labels, lines)] if fit is not None]
    found = [fit for fit in found if _plausible(drawing, fit)]
    if not found or max(found) > min(found) * (1.0 + _AGREE):
        return None
    return _scale(float(np.median(found)), _EXACT, ScaleSource.SCALE_BAR, 'its scale bar')


def _bar_fit(zero: Label, labels: tuple[Label, ...], lines: _Lines) -> float | None:
    """Return metres per pixel of the bar that starts at ``zero``."""
    left, top, right, bottom = zero.box
    height = bottom - top
    start = (left + right) / 2.0
    places, values, units = [start], [0.0], [number_and_unit(zero.text)[1]]
    for label in labels:
        value, unit = number_and_unit(label.text)
        beside = abs((label.box[1] + label.box[3]) - (top + bottom)) < 0.6 * height
        if value and beside and label.box[0] > right:
            places.append((label.box[0] + label.box[2]) / 2.0)
            values.append(value)
            units.append(unit)
    unit_m = next((unit for unit in units if unit), None) or _unit_beside(zero, labels)
    if len(values) < 2 or unit_m is None:
        return None
    ticks = _ticks(top, bottom, height, lines)
    slope = _tick_slope(np.array(places), np.array(values), ticks, height)
    return None if slope is None else unit_m / slope


def _unit_beside(zero: Label, labels: tuple[Label, ...]) -> float | None:
    """Return the unit [m] that a label in the row of a scale bar names."""
    for label in labels:
        beside = abs((label.box[1] + label.box[3]) - (zero.box[1] + zero.box[3]))
        word = label.text.strip().lower().strip('[]()')
        if word in WRITTEN_UNITS_M and beside < 1.5 * (zero.box[3] - zero.box[1]):
            return WRITTEN_UNITS_M[word]
    return None


def _ticks(top: float, bottom: float, height: float, lines: _Lines) -> Array:
    """Return where upright strokes stand beside a row of numbers; edges of the bar's fields."""
    upright = np.abs(np.cos(lines.angle)) < _PARALLEL
    upright &= (lines.low[:, 1] < bottom + 2.5 * height) & (lines.high[:, 1] > top - 2.5 * height)
    upright &= (lines.high[:, 1] - lines.low[:, 1]) < 4.0 * height
    ticks: Array = np.unique(np.round(lines.ends[upright].mean(axis=1)[:, 0], 1))
    return ticks


def _tick_slope(places: Array, values: Array, ticks: Array, height: float) -> float | None:
    """
    Return pixels per unit of a bar whose numbers stand at ticks.

    A number with a unit behind it stands off its tick by half of the unit's width, so each number
    may be any tick near it; the ticks of all must be even.
    """
    if len(ticks) < 2:
        return None
    near = [ticks[np.abs(ticks - place) < 1.6 * height] for place in places]
    if any(len(ends) == 0 for ends in near):
        return None
    order = int(np.argmax(values))
    for start in near[0][np.argsort(np.abs(near[0] - places[0]))]:
        for stop in near[order][np.argsort(np.abs(near[order] - places[order]))]:
            slope = (stop - start) / values[order]
            off = [
                np.abs(ends - start - slope * v).min()
                for ends, v in zip(near, values, strict=True)
            ]
            if slope > 0.0 and max(off) < max(0.01 * (stop - start), 1.0):
                return float(slope)
    return None


def paper_scale(drawing: Drawing, labels: tuple[Label, ...]) -> DrawingScale | None:
    """Return a stated 1:100 on paper of known size, if the doors have doors' widths then."""
    if drawing.paper_m is None or len(drawing.door_px) < _MIN_DOORS:
        return None
    stated = {int(m.group(1)) for label in labels for m in _RATIO.finditer(label.text)}
    stated &= _RATIOS
    if len(stated) != 1:
        return None
    ratio = stated.pop()
    resolution_m = drawing.paper_m * ratio
    if not _plausible(drawing, resolution_m):
        return None
    return _scale(resolution_m, _PAPER, ScaleSource.PAPER, f'1:{ratio}, and its doors agree')


def _scale(resolution_m: float, error: float, source: ScaleSource, why: str) -> DrawingScale:
    low_m, high_m = resolution_m * (1.0 - error), resolution_m * (1.0 + error)
    return DrawingScale(resolution_m, low_m, high_m, source, why)
