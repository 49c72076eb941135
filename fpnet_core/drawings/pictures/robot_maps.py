# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots' maps that come as a picture alone: their few greys mean occupied, unknown and free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.pictures.binarization import (
    Levels,
    brightness,
    colourfulness,
    commonest_levels,
)
from fpnet_core.errors import MapFormatError
from fpnet_core.io.images import interpret
from fpnet_core.raster.windows import border_of

# Chosen, not measured:
_COLOURED = 24  # levels between channels that a scanner's noise does not make
_COLOUR_SHARE = 2e-3  # of a picture has colour
_LEVELS_SHARE = 0.92  # of a map has one of its commonest levels
_UNKNOWN = (100, 240)  # levels that may mean unknown
_BORDER_SHARE = 0.3  # of a map's border is unknown
_FREE_SHARE = 0.02  # of a map is brighter than that
_NEAR = 8  # levels that are the same after compression


def map_cells(pixels: Levels, cell_m: float) -> NDArray[np.int8] | None:
    """
    Return the cells (H, W) of ``pixels (H, W, 3)``, row 0 at the top; None of what is no map.

    A drawing's paper is its brightest level; unknown space lies around what is brighter.
    """
    if (colourfulness(pixels) > _COLOURED).mean() > _COLOUR_SHARE:
        return None
    grey = brightness(pixels)
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
