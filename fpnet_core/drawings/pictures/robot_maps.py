# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Occupancy maps given as a bare image: its grey levels are occupied, unknown and free."""

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
