# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How thick walls are."""

from __future__ import annotations

import numpy as np

from fpnet_core.raster.morphology import Mask, shrunk


def wall_cells(walls: Mask) -> float:
    """Return the mean thickness of walls (H, W) in cells: twice their area over their outline."""
    outline = walls & ~shrunk(walls, 1)
    return 2.0 * float(np.count_nonzero(walls) + 1) / float(np.count_nonzero(outline) + 1)
