# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pieces of wall between doorways, which stand as free as furniture does."""

from __future__ import annotations

import cv2
import numpy as np

from fpnet_core.raster.morphology import Mask, disc, shrunk_by

# A piece of wall is at least so long, and nowhere thicker [m]. Chosen.
_MIN_LENGTH_M, _MAX_THICKNESS_M = 0.65, 0.4


def find_stubs(free: Mask, cell_m: float) -> Mask:
    """
    Return the cells (H, W) that are not ``free`` and belong to pieces as thin as a wall.

    What a robot sees of furniture is filled by what it hides, and thicker.
    """
    blocked = (~free).astype(np.uint8)
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(blocked, connectivity=8)
    length = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) * cell_m
    is_stub = length >= _MIN_LENGTH_M
    side = round(_MAX_THICKNESS_M / cell_m) + 1
    is_stub[pieces[shrunk_by(~free, disc(side))]] = False
    is_stub[0] = False
    return np.asarray(is_stub[pieces])
