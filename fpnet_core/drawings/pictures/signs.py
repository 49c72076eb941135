# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is drawn on a plan in another colour than its walls: arrows and signs of escape routes."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import looked_up, pieces_of

# Chosen, not measured:
_WALL_SHARE = 0.1  # of all walls is in a piece whose colour is that of walls
_UNLIKE = 40.0  # levels between the colours of walls and of signs, both without their brightness


def coloured_signs(walls: Mask, picture: NDArray[np.uint8]) -> Mask:
    """
    Return which ``walls (H, W)`` stand apart from the others and are of another colour.

    A column may be of another tone than walls, as black among grey, but not of another colour.
    ``picture (H, W, 3)`` is the drawing.
    """
    pieces, figures = pieces_of(walls)
    size = np.maximum(figures[:, cv2.CC_STAT_AREA], 1)
    size[0] = 0
    is_large = size > _WALL_SHARE * size.sum()
    if not is_large.any():
        return np.zeros_like(walls)
    at = pieces.ravel()
    mean = np.stack(
        [np.bincount(at, picture[..., k].ravel(), len(size)) for k in range(picture.shape[2])]
    ) / np.maximum(size, 1)
    colour = mean - mean.mean(axis=0)
    usual = np.average(colour, axis=1, weights=size * is_large)
    is_sign = np.abs(colour - usual[:, None]).max(axis=0) > _UNLIKE
    is_sign &= ~is_large & (size > 0)
    return looked_up(pieces, is_sign)
