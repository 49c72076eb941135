# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Thickness of walls, and detection of lines that are too thin for walls."""

from __future__ import annotations

import numpy as np

from fpnet_core.raster.morphology import Mask, grown, opened_by, shrunk, square

THIN = 0.6
"""Share of the usual wall thickness: thinner lines are not walls. Chosen."""


def wall_cells(walls: Mask) -> float:
    """Return the mean thickness of walls (H, W) in cells: twice their area over their outline."""
    outline = walls & ~shrunk(walls, 1)
    return 2.0 * float(np.count_nonzero(walls) + 1) / float(np.count_nonzero(outline) + 1)


def thin_walls(walls: Mask, side: int) -> Mask:
    """Return the mask of walls (H, W) that are thinner than ``side`` cells."""
    if side < 2:
        return np.zeros_like(walls)
    return np.asarray(walls & ~grown(opened_by(walls, square(side)), 1))
