# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pieces of wall between doorways, which stand as free as furniture does."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import disc, shrunk_by

# A piece of wall is at least so long, and nowhere thicker [m]. Chosen.
_MIN_LENGTH_M, _MAX_THICKNESS_M = 0.65, 0.4


def are_stubs(
    obstacles: NDArray[np.int32],
    figures: NDArray[np.int32],
    among: NDArray[np.bool_],
    cell_m: float,
) -> NDArray[np.bool_]:
    """
    Tell which obstacles ``among (N,)`` some are as thin as a wall; those touch no border.

    What a robot sees of furniture is filled by what it hides, and thicker. ``obstacles (H, W)``
    and ``figures (N, 5)`` are as of :func:`~fpnet_core.raster.pieces.pieces_of`.
    """
    size = figures[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    found = among & (np.hypot(*size.T) * cell_m >= _MIN_LENGTH_M)
    kernel = disc(round(_MAX_THICKNESS_M / cell_m) + 1)
    for number in np.flatnonzero(found):
        left, top, width, height = figures[number, : cv2.CC_STAT_AREA]
        piece = obstacles[top : top + height, left : left + width] == number
        found[number] = not shrunk_by(np.pad(piece, len(kernel)), kernel).any()
    return np.asarray(found)
