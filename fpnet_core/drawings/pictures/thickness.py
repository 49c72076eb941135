# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How thick walls are, and which lines are too thin for walls."""

from __future__ import annotations

import numpy as np

from fpnet_core.raster.morphology import Mask, grown, opened_by, shrunk, square

THIN = 0.6
"""Of the usual wall's thickness: what is thinner is no wall, what goes on as thick is. Chosen."""


def wall_cells(walls: Mask) -> float:
    """Return the mean thickness of walls (H, W) in cells: twice their area over their outline."""
    outline = walls & ~shrunk(walls, 1)
    return 2.0 * float(np.count_nonzero(walls) + 1) / float(np.count_nonzero(outline) + 1)


def thin_walls(walls: Mask, side: int) -> Mask:
    """Return which walls (H, W) are thinner than ``side`` cells."""
    if side < 2:
        return np.zeros_like(walls)
    return np.asarray(walls & ~grown(opened_by(walls, square(side)), 1))
