# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detection of thin horizontal and vertical lines in images: dimensions, scale bars."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Array, Label, Strokes

# Chosen, not measured:
_CONTRAST = 60  # difference of grey level between a line and the paper
_SHORTEST = 0.6  # of a letter's height: shortest line, half a tick
_THICKEST = 0.3  # of a letter's height: thickest line
_LEAST_PX = 7  # numerical: shortest line
_THIN_PX = 3  # numerical: lines up to this thickness are thin beside any letter


def picture_lines(pixels: NDArray[np.uint8], labels: Sequence[Label]) -> Strokes:
    """
    Return the thin lines in ``pixels (H, W, 3)``, sized relative to the text of ``labels``.

    End points lie on the centre line, exact to a pixel. Empty without labels.
    """
    import cv2

    sides = [min(k.box[2] - k.box[0], k.box[3] - k.box[1]) for k in labels]
    if not sides:
        return _strokes(np.empty((0, 2, 2)))
    letter_px = float(np.median(sides))
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    ink = np.abs(grey.astype(np.int16) - round(float(np.median(grey)))) > _CONTRAST
    length = max(_LEAST_PX, round(_SHORTEST * letter_px))
    thick = max(_THIN_PX, round(_THICKEST * letter_px))
    level = _level_lines(ink, length, thick)
    upright = _level_lines(np.ascontiguousarray(ink.T), length, thick)[..., ::-1]
    return _strokes(np.concatenate([level, upright]))


def _level_lines(ink: NDArray[np.bool_], length: int, thick: int) -> Array:
    """Return the ends (N, 2, 2), x and y, of horizontal lines of at least ``length`` pixels."""
    import cv2

    runs = cv2.morphologyEx(ink.astype(np.uint8), cv2.MORPH_OPEN, np.ones((1, length), np.uint8))
    count, _, stats, _ = cv2.connectedComponentsWithStats(runs, connectivity=8)
    left, top, width, height, _ = stats[1:count].astype(np.float64).T
    is_line = (height <= thick) & (width >= length)
    left, top, width, height = (each[is_line] for each in (left, top, width, height))
    y = top + (height - 1.0) / 2.0
    return np.stack([np.stack([left, y], 1), np.stack([left + width - 1.0, y], 1)], axis=1)


def _strokes(ends: Array) -> Strokes:
    count = len(ends)
    return Strokes(
        ends=ends,
        width=np.ones(count),
        colour=np.zeros((count, 3), np.uint8),
        path=np.arange(count),
        is_curve=np.zeros(count, np.bool_),
        layer=np.zeros(count, np.int64),
    )
