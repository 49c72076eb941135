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

Mask = NDArray[np.bool_]

_WIDEST_PX = 24  # strokes and gaps up to this width are told apart
_CLASS_SHARE = 0.12  # of the ink are thin lines, and are walls, where both are there
_GAP_SHARE = 0.15  # of the ink: so large are the gaps in walls of two lines
_KEPT = 0.7  # of the gap of two lines: what is thinner once that is filled is another line


@dataclass(frozen=True)
class Recipe:
    """
    How walls are made from contrast.

    What is darker than ``level`` is ink; gaps of up to ``fill_px`` between lines are filled,
    then strokes narrower than ``thin_px`` are left out. ``how`` says it in words.
    """

    how: str
    level: float
    fill_px: float = 0.0
    thin_px: float = 0.0

    def scaled(self, factor: float) -> Recipe:
        """Return the recipe for a picture that is ``factor`` times as large."""
        return replace(self, fill_px=self.fill_px * factor, thin_px=self.thin_px * factor)

    def walls(self, levels: Levels) -> Mask:
        """Return the walls (H, W) among the contrast ``levels (H, W)``."""
        ink = (levels > self.level).astype(np.uint8)
        fill, thin = round(self.fill_px), round(self.thin_px)
        if fill > 1:
            ink = np.asarray(cv2.morphologyEx(ink, cv2.MORPH_CLOSE, _disc(fill)), dtype=np.uint8)
        if thin > 1:
            core = cv2.morphologyEx(ink, cv2.MORPH_OPEN, _disc(thin))
            ink = cv2.dilate(core, _disc(3)) & ink
        return np.asarray(ink > 0)


def recipes(levels: Levels) -> list[Recipe]:
    """Return the ways in which the walls of contrast ``levels (H, W)`` may be drawn."""
    found = []
    for tone in inks(levels):
        plain = Recipe(tone.name, tone.level)
        found.append(plain)
        ink = (levels > tone.level).astype(np.uint8)
        thin = _thinnest_wall(ink)
        if thin is not None:
            found.append(replace(plain, how=f'wide strokes of {tone.name}', thin_px=thin))
        gap = _double_wall_gap(ink)
        if gap is not None:
            name = f'pairs of {tone.name}'
            found.append(replace(plain, how=name, fill_px=gap + 1, thin_px=_KEPT * gap))
    return found


def _disc(side: int) -> NDArray[np.uint8]:
    shape = cv2.MORPH_ELLIPSE if side > 3 else cv2.MORPH_RECT
    return np.asarray(cv2.getStructuringElement(shape, (side, side)), dtype=np.uint8)


def _thinnest_wall(ink: NDArray[np.uint8]) -> float | None:
    """Return the width that parts thin lines from walls; None where there is one width only."""
    left = np.array(_areas(ink, cv2.MORPH_OPEN))
    mass = np.clip(-np.diff(left), 0.0, None)  # ink in strokes of 1, 2, ... pixels
    mass = np.append(mass, left[-1])
    best, most = None, 0.0
    widths = np.log(np.arange(1, len(mass) + 1))
    for split in range(1, len(mass)):
        low, high = mass[:split].sum(), mass[split:].sum()
        if min(low, high) < _CLASS_SHARE * left[0]:
            continue
        gap = np.average(widths[split:], weights=mass[split:]) - np.average(
            widths[:split], weights=mass[:split]
        )
        between = float(low * high * gap**2)
        if between > most:
            best, most = float(split + 1), between
    return best


def _double_wall_gap(ink: NDArray[np.uint8]) -> float | None:
    """Return the commonest gap between two lines; None where gaps fill little."""
    gained = np.diff(_areas(ink, cv2.MORPH_CLOSE))
    widest = int(gained[1:].argmax()) + 1
    if gained[max(widest - 1, 0) : widest + 2].sum() < _GAP_SHARE * ink.sum():
        return None
    return float(widest + 1)


def _areas(ink: NDArray[np.uint8], operation: int) -> list[float]:
    """Return the area of ink opened or closed by squares of 1, 2, ... pixels."""
    areas = [float(ink.sum())]
    for side in range(2, _WIDEST_PX + 1):
        square = np.ones((side, side), np.uint8)
        areas.append(float(cv2.morphologyEx(ink, operation, square).sum()))
    return areas
