# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Which ink is wall: by its tone, and by the width of its strokes.

Draughtsmen draw walls as filled strokes that are wider than every other line, as two lines with
nothing, a tint or a hatch between them, or as lines like all others. Each way is a recipe; which
one a drawing follows is seen by the rooms that come out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.tones import Levels, inks
from fpnet_core.segmentation.distance import cells_to_nearest

Mask = NDArray[np.bool_]
Array = NDArray[np.float64]

_SIDES = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 18, 21, 24)  # squares that ink is opened by
_WIDEST_PX = 24  # strokes and gaps up to this width are told apart
_CLASS_SHARE = 0.12  # of the ink are thin lines, and are walls, where both are there
_GAP_SHARE = 0.1  # of the ink: so large are the gaps in walls of two lines
_MAX_GAPS = 2  # outer walls and partitions
_LETTER_SHARE = 0.03  # of the building's longer side: shorter pieces are letters and dashes
_SOLID, _COLUMN_PX = 0.75, 5  # unless they fill so much of their box, and that is so wide
_CRACK_SHARES = (0.007, 0.014)  # of the longer side: the thickest wall of two lines
_KEPT = 0.7  # of the gap of two lines: what is thinner once that is filled is another line


@dataclass(frozen=True)
class Recipe:
    """
    How walls are made from contrast.

    What is darker than ``level`` is ink; gaps of up to ``fill_px`` between lines are filled, and
    closed spaces nowhere as wide as ``crack_px``; then strokes narrower than ``thin_px`` are left
    out. ``how`` says it in words.
    """

    how: str
    level: float
    fill_px: float = 0.0
    thin_px: float = 0.0
    crack_px: float = 0.0

    def scaled(self, factor: float) -> Recipe:
        """Return the recipe for a picture that is ``factor`` times as large."""
        return replace(
            self,
            fill_px=self.fill_px * factor,
            thin_px=self.thin_px * factor,
            crack_px=self.crack_px * factor,
        )

    def walls(self, levels: Levels) -> Mask:
        """Return the walls (H, W) among the contrast ``levels (H, W)``."""
        ink = without_letters((levels > self.level).astype(np.uint8))
        fill, thin = round(self.fill_px), round(self.thin_px)
        if fill > 1:
            ink = np.asarray(cv2.morphologyEx(ink, cv2.MORPH_CLOSE, _disc(fill)), dtype=np.uint8)
        if self.crack_px > 0.0:
            ink = _without_cracks(ink, self.crack_px)
        if thin > 1:
            core = cv2.morphologyEx(ink, cv2.MORPH_OPEN, _disc(thin))
            ink = np.asarray(cv2.dilate(core, _disc(3)), dtype=np.uint8) & ink
        return np.asarray(ink > 0)


def recipes(levels: Levels) -> list[Recipe]:
    """Return the ways in which the walls of contrast ``levels (H, W)`` may be drawn."""
    found = []
    for tone in inks(levels):
        plain = Recipe(tone.name, tone.level)
        found.append(plain)
        ink = without_letters((levels > tone.level).astype(np.uint8))
        for thin in _thinnest_walls(ink):
            name = f'strokes of {tone.name} from {thin:.0f} pixels on'
            found.append(replace(plain, how=name, thin_px=thin))
        line = _line_width(ink)
        for share in _CRACK_SHARES:
            crack = share * max(levels.shape)
            name = f'outlines of {tone.name}, walls up to {crack:.0f} pixels'
            found.append(replace(plain, how=name, crack_px=crack, thin_px=line + 2.0))
        for fill, thin in _double_walls(ink):
            name = f'pairs of {tone.name}, {fill:.0f} pixels apart'
            found.append(replace(plain, how=name, fill_px=fill + 1.0, thin_px=_KEPT * thin))
    return found


def _without_cracks(ink: NDArray[np.uint8], width: float) -> NDArray[np.uint8]:
    """Return the ink (H, W) with closed spaces filled that are nowhere as wide as ``width``."""
    count, labels = cv2.connectedComponents(1 - ink, connectivity=4)
    is_wide = np.zeros(count, dtype=np.bool_)
    is_wide[labels[cells_to_nearest(ink > 0) > 0.5 * width]] = True
    return np.asarray(~is_wide[labels], dtype=np.uint8)


def _disc(side: int) -> NDArray[np.uint8]:
    shape = cv2.MORPH_ELLIPSE if side > 3 else cv2.MORPH_RECT
    return np.asarray(cv2.getStructuringElement(shape, (side, side)), dtype=np.uint8)


def _line_width(letterless: NDArray[np.uint8]) -> float:
    """Return the commonest width of strokes."""
    left = _areas(letterless, cv2.MORPH_OPEN)
    return float(np.argmax(-np.diff(left)) + 1)


def _thinnest_walls(letterless: NDArray[np.uint8]) -> list[float]:
    """Return widths that may part thin lines from walls; none where all lines are as wide."""
    left = _areas(letterless, cv2.MORPH_OPEN)
    mass = np.append(np.clip(-np.diff(left), 0.0, None), left[-1])  # by width, from 1 on
    below, above = np.cumsum(mass) - mass, np.cumsum(mass[::-1])[::-1]
    total = max(left[0], 1.0)
    can_part = (below > _CLASS_SHARE * total) & (above > _CLASS_SHARE * total)
    widths = np.log(np.arange(1, len(mass) + 1))
    found = []
    valleys = [
        k
        for k in np.flatnonzero(can_part)
        if mass[k] <= min(mass[k - 1], mass[k + 1 :].max(initial=0.0))
    ]
    if valleys:
        found.append(float(valleys[0] + 1))
    if can_part.any():
        spread = [
            _between(widths, mass, split) if ok else 0.0 for split, ok in enumerate(can_part)
        ]
        found.append(float(np.argmax(spread) + 1))
    return sorted(set(found))


def _between(widths: NDArray[np.float64], mass: NDArray[np.float64], split: int) -> float:
    """Return the variance between strokes narrower and wider than a split (Otsu, 1979)."""
    low, high = mass[:split].sum(), mass[split:].sum()
    gap = widths[split:] @ mass[split:] / high - widths[:split] @ mass[:split] / low
    return float(low * high * gap**2)


def _double_walls(letterless: NDArray[np.uint8]) -> list[tuple[float, float]]:
    """Return widths of gaps between lines, and of the least wall then; none where all are one."""
    areas = _areas(letterless, cv2.MORPH_CLOSE)
    gained = np.concatenate([[0.0], np.diff(areas), [0.0]]) / max(areas[0], 1.0)
    smooth = gained + 0.5 * (np.roll(gained, 1) + np.roll(gained, -1))
    peaks = [
        k
        for k in range(2, len(gained) - 1)
        if smooth[k] > _GAP_SHARE and smooth[k] >= smooth[k - 1] and smooth[k] > smooth[k + 1]
    ]
    peaks = sorted(sorted(peaks, key=lambda k: -smooth[k])[:_MAX_GAPS])
    return [(float(k), float(peaks[0])) for k in peaks]


def without_letters(ink: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the ink (H, W) without pieces as short as letters and dashes; columns stay."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(ink, connectivity=8)
    sides = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    is_long = sides.max(axis=1) > _LETTER_SHARE * max(ink.shape)
    is_solid = stats[:, cv2.CC_STAT_AREA] > _SOLID * sides.prod(axis=1)
    keep = is_long | (is_solid & (sides.min(axis=1) >= _COLUMN_PX))
    keep[0] = False
    return np.asarray(keep[labels], dtype=np.uint8)


def _areas(ink: NDArray[np.uint8], operation: int) -> Array:
    """Return the area of ink opened or closed by squares of 1, 2, ... ``_WIDEST_PX`` pixels."""
    sides = np.array(_SIDES)
    areas = [float(ink.sum())]
    for side in _SIDES[1:]:
        square = np.ones((side, side), np.uint8)
        areas.append(float(cv2.morphologyEx(ink, operation, square).sum()))
    return np.interp(np.arange(1, _WIDEST_PX + 1), sides, areas)
