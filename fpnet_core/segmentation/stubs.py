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


def is_stub(
    obstacles: NDArray[np.int32], figures: NDArray[np.int32], cell_m: float
) -> NDArray[np.bool_]:
    """
    Tell of obstacles (N,) whether they are as thin as a wall.

    What a robot sees of furniture is filled by what it hides, and thicker. ``obstacles (H, W)``
    and ``figures (N, 5)`` are as of :func:`~fpnet_core.raster.pieces.pieces_of`.
    """
    width, height = figures[:, cv2.CC_STAT_WIDTH], figures[:, cv2.CC_STAT_HEIGHT]
    found = np.hypot(width, height) * cell_m >= _MIN_LENGTH_M
    side = round(_MAX_THICKNESS_M / cell_m) + 1
    found[obstacles[shrunk_by(obstacles > 0, disc(side))]] = False
    return np.asarray(found)
