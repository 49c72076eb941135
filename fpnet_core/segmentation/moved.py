# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Grids and their rooms rescaled or mirrored, without a new segmentation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2
from fpnet_core.types import GridMap, Segmentation


def rescaled(grid: GridMap, factor: float) -> GridMap:
    """Return the same cells with every length multiplied by ``factor``."""
    origin = grid.T_frame_grid
    moved = SE2(origin.linear, origin.translation * factor)
    return replace(grid, resolution=grid.resolution * factor, T_frame_grid=moved)


def rescaled_rooms(segmentation: Segmentation, factor: float) -> Segmentation:
    """Return the same rooms and doors with every length multiplied by ``factor``."""
    regions = (
        replace(
            region,
            polygon=region.polygon * factor,
            centroid=region.centroid * factor,
            area_m2=region.area_m2 * factor**2,
        )
        for region in segmentation.regions
    )
    portals = (replace(portal, ends=portal.ends * factor) for portal in segmentation.portals)
    grid = rescaled(segmentation.grid, factor)
    return replace(segmentation, grid=grid, regions=tuple(regions), portals=tuple(portals))


def mirrored_rooms(segmentation: Segmentation) -> Segmentation:
    """Return the same rooms and doors on the mirrored grid, without a new segmentation."""
    grid = segmentation.grid
    to_grid, width_m = grid.T_frame_grid.inv(), grid.shape[1] * grid.resolution

    def mirrored(xy: NDArray[np.float64]) -> NDArray[np.float64]:
        own = to_grid.apply(xy) * np.array([-1.0, 1.0]) + np.array([width_m, 0.0])
        return grid.T_frame_grid.apply(own)

    regions = (
        # Mirroring turns outlines clockwise; reverse them.
        replace(r, polygon=mirrored(r.polygon)[::-1], centroid=mirrored(r.centroid))
        for r in segmentation.regions
    )
    portals = (replace(portal, ends=mirrored(portal.ends)) for portal in segmentation.portals)
    return replace(
        segmentation,
        grid=grid.mirrored(),
        labels=segmentation.labels[:, ::-1],
        regions=tuple(regions),
        portals=tuple(portals),
    )
