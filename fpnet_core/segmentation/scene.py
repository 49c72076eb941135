# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The raster that both segmentations start from: free space, walls, lintels, clearance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_means
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask, grown

# Free-standing obstacles smaller than this are furniture;
# fitted to the tune half (docs/segmentation.md).
_FURNITURE_AREA_M2 = 2.0
# Free-standing obstacles longer than this are walls;
# fitted to the tune half (docs/segmentation.md).
_FURNITURE_EXTENT_M = 2.5
WORK_RESOLUTION_M = 0.1  # numerical: cell edge at which regions are grown
_UNSEEN_CREDIT_M = 0.5  # clearance at the very edge of unseen space; chosen
_SMOOTHING_M = 0.1  # numerical: standard deviation of the blur of the clearance

# Numerical: mean of a block of ones, with room for rounding.
_ALL = 1.0 - 1e-4


@dataclass(frozen=True, eq=False)
class Scene:
    """
    Cleaned masks at the grid's own resolution.

    ``free (H, W)`` is space that belongs to some room or door; ``lintel (H, W)`` cells are
    free and close a doorway. ``cell_m`` is the cell edge in true metres, nominal edge times
    metres per unit. ``solid (H, W)`` is what limits the free space. Of a partial map,
    ``wall (H, W)`` marks cells at or near a wall and ``unseen (H, W)`` those that are neither
    free nor near a wall; of a drawing both are None. ``furniture (H, W)`` are free cells that
    something stands on, ``high (H, W)`` those below a return at the height of lintels.
    ``has_scans`` tells a robot's own submap, ``sees_lintels`` that its sensor has met any lintel.
    """

    free: Mask
    lintel: Mask
    solid: Mask
    cell_m: float
    wall: Mask | None = None
    unseen: Mask | None = None
    furniture: Mask | None = None
    high: Mask | None = None
    has_scans: bool = False
    sees_lintels: bool = False

    @cached_property
    def clearance(self) -> NDArray[np.float32]:
        """
        Distance (H, W) to what limits the free space [true metres].

        Unseen space limits it less than a wall does: a room seen through its door keeps a
        clearance that grows behind the jambs, so that the door is found before the room is.
        """
        clearance = clearance_m(self.solid, self.cell_m)
        if self.unseen is None:
            return clearance
        beyond = clearance_m(self.unseen, self.cell_m) + np.float32(_UNSEEN_CREDIT_M)
        return np.asarray(np.minimum(clearance, beyond))

    def closed_along(self, line: Mask) -> Scene:
        """Return the scene with the cells of lines closed as if they were under a lintel."""
        return replace(self, lintel=self.lintel | line, solid=self.solid | line)


@dataclass(frozen=True, eq=False)
class WorkRaster:
    """
    The scene at working resolution: blocks of ``stride`` by ``stride`` cells.

    ``mask (h, w)`` marks blocks that are free throughout (and not under a lintel), so a wall
    of one cell stays closed; ``clearance (h, w)`` float32 is the distance to the nearest wall
    [true metres], measured before the reduction so that openings keep their width;
    ``frontier (h, w)`` marks free blocks that touch unseen space.
    """

    mask: Mask
    clearance: NDArray[np.float32]
    frontier: Mask
    stride: int
    cell_m: float


def fill_furniture(free: Mask, cell_m: float) -> Mask:
    """
    Return ``free (H, W)`` with small free-standing obstacles turned into free space.

    Components of not-free cells are furniture where both area and bounding-box diagonal stay
    below these limits; what touches the image's border is never furniture.
    """
    blocked = (~free).astype(np.uint8)
    count, components, stats, _ = cv2.connectedComponentsWithStats(blocked, connectivity=8)
    rows, cols = free.shape
    left, top = stats[:, cv2.CC_STAT_LEFT], stats[:, cv2.CC_STAT_TOP]
    width, height = stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]
    inside = (left > 0) & (top > 0) & (left + width < cols) & (top + height < rows)
    small = stats[:, cv2.CC_STAT_AREA] * cell_m**2 < _FURNITURE_AREA_M2
    short = np.hypot(width, height) * cell_m < _FURNITURE_EXTENT_M
    furniture = inside & small & short
    furniture[0] = False
    if count == 1 or not furniture.any():
        return free
    return np.asarray(free | furniture[components])


def clearance_m(blocked: Mask, cell_m: float) -> NDArray[np.float32]:
    """Return the distance (H, W) float32 from each cell to the nearest blocked cell's face."""
    faces = cells_to_nearest(blocked)
    faces -= np.float32(0.5)
    np.maximum(faces, np.float32(0.0), out=faces)
    faces *= np.float32(cell_m)
    return faces


def reduce_scene(scene: Scene) -> WorkRaster:
    """Reduce a scene to the working resolution."""
    stride = max(1, round(WORK_RESOLUTION_M / scene.cell_m))
    passable = block_means((scene.free & ~scene.lintel).astype(np.float32), stride)
    work = block_means(scene.clearance, stride)
    sigma = _SMOOTHING_M / (scene.cell_m * stride)
    if sigma > 0.0:
        work = np.asarray(
            cv2.GaussianBlur(work, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE), np.float32
        )
    mask = np.asarray(passable > _ALL)
    frontier = np.zeros_like(mask)
    if scene.unseen is not None:
        unseen = block_means(scene.unseen.astype(np.float32), stride) > 0.0
        frontier = mask & grown(unseen, 1)
    return WorkRaster(mask, work, frontier, stride, scene.cell_m * stride)
