# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Submap of a finished occupancy grid."""

from __future__ import annotations

import numpy as np

from fpnet_core.types import GridMap, Submap


def submap_from_grid(grid: GridMap) -> Submap:
    """Wrap a robot's occupancy grid as a submap without lintels and without a path."""
    framed = GridMap(grid.cells, grid.resolution, grid.T_frame_grid, 'submap')
    return Submap(framed, np.zeros(grid.shape, dtype=np.bool_), np.zeros((0, 2)))
