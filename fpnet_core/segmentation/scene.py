# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The raster input of both segmentations: free space, walls, lintels, clearance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_any, block_means
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask, grown

WORK_RESOLUTION_M = 0.1  # numerical: cell edge at which regions are grown
_UNSEEN_CREDIT_M = 0.5  # clearance at the very edge of unseen space; chosen
_SMOOTHING_M = 0.1  # numerical: standard deviation of the blur of the clearance

_BLUR_ENDS = 4.0  # numerical: OpenCV truncates the blur at this many standard deviations


@dataclass(frozen=True, eq=False)
class Scene:
    """
    Cleaned masks at the grid's own resolution.

    ``free (H, W)`` is space of some room or door; ``lintel (H, W)`` cells are free and close a
    doorway. ``cell_m`` is the cell edge in true metres, nominal edge times metres per unit.
    ``solid (H, W)`` limits the free space. In a partial map, ``wall (H, W)`` marks cells at or
    near a wall and ``unseen (H, W)`` cells that are neither free nor near a wall; in a drawing
    both are None. ``furniture (H, W)`` are free cells below furniture, ``high (H, W)`` free cells
    below a return at lintel height. ``has_scans`` marks a robot's own submap; ``sees_lintels`` is
    True if its sensor has detected any lintel.
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
        Distance (H, W) to the limits of the free space [true metres], 0 far from free space.

        Unseen space limits it less than a wall does: the clearance of a room seen through its door
        grows behind the jambs, so the door is found before the room is fully seen.
        """
        blurred = int(np.ceil(_BLUR_ENDS * self.blur)) * self.stride
        where = grown(self.free & ~self.lintel, blurred + self.stride - 1)
        clearance = clearance_m(self.solid, self.cell_m, where)
        if self.unseen is not None:
            roomy = clearance > _UNSEEN_CREDIT_M  # nowhere else can unseen space be nearer
            most_m = float(clearance.max()) - _UNSEEN_CREDIT_M  # farther space limits nothing
            beyond = clearance_m(self.unseen, self.cell_m, roomy, _UNSEEN_CREDIT_M, most_m)
            np.minimum(clearance, beyond, out=clearance)
        return clearance

    @property
    def stride(self) -> int:
        """Return the side of a block of the working resolution, in cells."""
        return max(1, round(WORK_RESOLUTION_M / self.cell_m))

    @property
    def blur(self) -> float:
        """Return the standard deviation of the blur of the clearance, in blocks."""
        return _SMOOTHING_M / (self.cell_m * self.stride)

    def closed_along(self, line: Mask) -> Scene:
        """Return the scene with the cells of lines closed as if they were under a lintel."""
        return replace(self, lintel=self.lintel | line, solid=self.solid | line)

    def coarser(self, step: int) -> Scene:
        """Return a drawing's scene in blocks of ``step`` cells; a block needs all cells free."""
        free = ~block_any(~self.free, step, is_beyond=True)
        furniture = None if self.furniture is None else block_any(self.furniture, step) & free
        return Scene(
            free,
            block_any(self.lintel, step),
            block_any(self.solid, step, is_beyond=True),
            self.cell_m * step,
            furniture=furniture,
        )


@dataclass(frozen=True, eq=False)
class WorkRaster:
    """
    The scene at working resolution: blocks of ``stride`` by ``stride`` cells.

    ``mask (h, w)`` marks blocks that are entirely free (and not under a lintel), so a wall of one
    cell stays closed. ``clearance (h, w)`` float32 is the distance to the nearest wall [true
    metres], measured before the reduction so that openings keep their width. ``frontier (h, w)``
    marks free blocks that touch unseen space.
    """

    mask: Mask
    clearance: NDArray[np.float32]
    frontier: Mask
    stride: int
    cell_m: float


def clearance_m(
    blocked: Mask,
    cell_m: float,
    where: Mask | None = None,
    credit_m: float = 0.0,
    most_m: float = np.inf,
) -> NDArray[np.float32]:
    """
    Return the distance (H, W) float32 from each cell to the nearest blocked cell's face.

    Cells where ``where`` is False are undefined; ``credit_m`` is added. Distances beyond
    ``most_m`` are only known to exceed it.
    """
    cells = cells_to_nearest(blocked, where=where, most=most_m / cell_m + 1.0)
    cells -= 0.5
    np.maximum(cells, 0.0, out=cells)
    cells *= np.float32(cell_m)
    cells += np.float32(credit_m)
    return cells


def reduce_scene(scene: Scene) -> WorkRaster:
    """Reduce a scene to the working resolution."""
    stride = scene.stride
    work = np.asarray(
        cv2.GaussianBlur(
            block_means(scene.clearance, stride),
            (0, 0),
            scene.blur,
            borderType=cv2.BORDER_REPLICATE,
        ),
        np.float32,
    )
    mask = ~block_any(~scene.free | scene.lintel, stride, is_beyond=True)
    frontier = np.zeros_like(mask)
    if scene.unseen is not None:
        frontier = mask & grown(block_any(scene.unseen, stride), 1)
    return WorkRaster(mask, work, frontier, stride, scene.cell_m * stride)
