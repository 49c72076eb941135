# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scale votes of scale bars: evenly spaced numbers from 0, each at a tick."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from fpnet_core.drawings.dimensions import DRAWN, PARALLEL, DrawnLines
from fpnet_core.drawings.lengths import WRITTEN_UNITS_M, number_and_unit
from fpnet_core.drawings.types import Array, Label
from fpnet_core.drawings.votes import Vote, VoteKind


def bar_votes(labels: Sequence[Label], lines: DrawnLines, error_px: float) -> list[Vote]:
    """Return a vote per scale bar; ``error_px`` is the error of its ticks [pixels]."""
    votes = []
    for number, zero in enumerate(labels):
        if number_and_unit(zero.text)[0] != 0.0:
            continue
        fit = _bar_fit(zero, labels, lines)
        if fit is not None:
            resolution_m, length_px = fit
            scale = math.log(resolution_m)
            spread = math.hypot(DRAWN, error_px / length_px)
            # Equal values count as one witness: several bars are no independent evidence.
            votes.append(Vote(scale, VoteKind.BAR, 1.0, number, '', spread))
    return votes


def _bar_fit(
    zero: Label, labels: Sequence[Label], lines: DrawnLines
) -> tuple[float, float] | None:
    """Return metres per pixel of the bar that starts at ``zero``, and its length [pixels]."""
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
    return None if slope is None else (unit_m / slope, slope * max(values))


def _unit_beside(zero: Label, labels: Sequence[Label]) -> float | None:
    """Return the unit [m] named by a label beside a scale bar; None if there is none."""
    for label in labels:
        beside = abs((label.box[1] + label.box[3]) - (zero.box[1] + zero.box[3]))
        word = label.text.strip().lower().strip('[]()')
        if word in WRITTEN_UNITS_M and beside < 1.5 * (zero.box[3] - zero.box[1]):
            return WRITTEN_UNITS_M[word]
    return None


def _ticks(top: float, bottom: float, height: float, lines: DrawnLines) -> Array:
    """Return the x coordinates of vertical strokes beside a row of numbers: ticks, field edges."""
    upright = np.abs(np.cos(lines.angle)) < PARALLEL
    upright &= (lines.low[:, 1] < bottom + 2.5 * height) & (lines.high[:, 1] > top - 2.5 * height)
    upright &= (lines.high[:, 1] - lines.low[:, 1]) < 4.0 * height
    ticks: Array = np.unique(np.round(lines.ends[upright].mean(axis=1)[:, 0], 1))
    return ticks


def _tick_slope(places: Array, values: Array, ticks: Array, height: float) -> float | None:
    """
    Return pixels per unit of a bar with numbers at its ticks; None if they do not fit.

    A number with a unit behind it is off its tick by half of the unit's width, so each number may
    belong to any tick near it; the chosen ticks must be evenly spaced.
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
