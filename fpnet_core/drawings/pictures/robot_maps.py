# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Occupancy maps given as a bare image: its grey levels are occupied, unknown and free."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from fpnet_core.errors import MapFormatError
from fpnet_core.io.images import interpret
from fpnet_core.raster.windows import border_of

Levels = NDArray[np.uint8]

# Chosen, not measured:
_LEVELS, _LEVEL_REACH = 4, 3  # grey levels of a clean image, and their half-width
_COLOURED = 24  # difference of channels above a scanner's noise
_COLOUR_SHARE = 2e-3  # of an image has colour, unless it is a map
_LEVELS_SHARE = 0.92  # of a map's pixels have one of its commonest levels
_UNKNOWN = (100, 240)  # levels that may mean unknown
_BORDER_SHARE = 0.3  # of a map's border is unknown
_FREE_SHARE = 0.02  # of a map is brighter than unknown
_NEAR = 8  # levels that count as equal after compression


def map_cells(pixels: Levels, cell_m: float) -> NDArray[np.int8] | None:
    """
    Return the cells (H, W) of ``pixels (H, W, 3)``, row 0 at the top; None if it is no map.

    A drawing's paper is its brightest level; a map's unknown space surrounds brighter space.
    """
    if (np.ptp(pixels, axis=2) > _COLOURED).mean() > _COLOUR_SHARE:
        return None
    grey = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), np.uint8)
    shares = commonest_levels(grey)
    if sum(share for _, share in shares) < _LEVELS_SHARE:
        return None
    rim = border_of(grey).astype(np.int16)
    for level, _ in shares:
        if (
            _UNKNOWN[0] <= level < _UNKNOWN[1]
            and (np.abs(rim - level) <= _NEAR).mean() > _BORDER_SHARE
            and (grey > level + _NEAR).mean() > _FREE_SHARE
        ):
            try:
                return interpret(grey, cell_m)
            except MapFormatError:
                return None
    return None


def commonest_levels(grey: Levels) -> list[tuple[int, float]]:
    """
    Return the commonest grey levels with the shares of pixels near each.

    A level is a peak of the smoothed histogram: the shades that a JPEG or a scanner makes of one
    level are no further levels.
    """
    count = np.bincount(grey.ravel(), minlength=256).astype(np.float64) / grey.size
    window = np.ones(2 * _LEVEL_REACH + 1)
    found = []
    for _ in range(_LEVELS):
        near = np.convolve(count, window, mode='same')
        level = int(near.argmax())
        found.append((level, float(near[level])))
        smooth = gaussian_filter1d(count, _LEVEL_REACH)  # stretched contrast leaves gaps
        low = level - max(_LEVEL_REACH, _downhill(smooth[level::-1]))
        high = level + max(_LEVEL_REACH, _downhill(smooth[level:]))
        count[max(0, low) : high + 1] = 0.0
    return found


def _downhill(height: NDArray[np.float64]) -> int:
    """Return the number of steps over which ``height (N,)`` does not rise from its start."""
    rises = np.flatnonzero(np.diff(height) > 0.0)
    return int(rises[0]) if len(rises) else len(height) - 1
