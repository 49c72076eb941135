# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
All there is to see of a reading: its rooms, the drawing below them, and how else it could be read.

Other readings of the same drawing are rivals. What-ifs are the same walls with one thing changed:
the scale, lines that are thinner or fainter than the others left out. A room that is there in all
of them is a room.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.thickness import THIN, thin_walls, wall_cells
from fpnet_core.drawings.pictures.tones import Levels, contrast
from fpnet_core.drawings.types import Trust
from fpnet_core.raster.morphology import Mask, square
from fpnet_core.raster.pixels import growth_at, pixel_to_xy
from fpnet_core.segmentation.scale import estimate_metres_per_unit, segment_at
from fpnet_core.types import FREE, OCCUPIED, GridMap, Segmentation

Array = NDArray[np.float64]
Labels = NDArray[np.int32]

WHAT_IFS = ('smaller', 'larger', 'thick', 'dark')
"""The same reading taken for a smaller or a larger building, without its thin or faint lines."""

# Chosen, not measured:
_FACTORS = {'smaller': 0.8, 'larger': 1.25}  # of the scale: about its usual interval
_FAINT = 0.6  # of the usual wall's contrast
_LEAST_PLAUSIBLE = 1e-3  # numerical: so that rivals of which none is plausible have a mean


@dataclass(frozen=True, eq=False)
class Rival:
    """Another reading: its rooms, the map (3, 3) from pixels to them, and its plausibility."""

    segmentation: Segmentation
    H_plan_pixel: Array
    plausible: float


@dataclass(frozen=True, eq=False)
class ReadingView:
    """
    What there is to see of a reading, at the cells of its rooms.

    Parameters
    ----------
    segmentation : its rooms, in nominal metres
    H_plan_pixel : (3, 3), from the drawing's pixels to those
    levels : (H, W) uint8, contrast of the drawing, row 0 lowest
    thin, faint : (H, W), walls that are thinner or fainter than the usual one
    rivals : room labels (H, W) of other readings, most plausible first
    weights : (K,), their plausibility
    what_if : room labels (H, W) by :data:`WHAT_IFS`
    plausible : how much the reading looks like a building
    trust : how sure the network was that read it; None where none did
    """

    segmentation: Segmentation
    H_plan_pixel: Array
    levels: Levels
    thin: Mask
    faint: Mask
    rivals: tuple[Labels, ...]
    weights: Array
    what_if: dict[str, Labels]
    plausible: float
    trust: Trust | None = None

    @property
    def walls(self) -> Mask:
        """Return where (H, W) the reading has walls."""
        return np.asarray(self.segmentation.grid.cells == OCCUPIED)

    @property
    def shares(self) -> Array:
        """Weights (K,) of the rivals in means of what they say."""
        return self.weights + _LEAST_PLAUSIBLE

    @property
    def tone(self) -> float:
        """Return the usual contrast of walls."""
        at_walls = self.levels[self.walls]
        return float(np.median(at_walls)) if at_walls.size else 255.0


def view_reading(
    pixels: Levels,
    segmentation: Segmentation,
    H_plan_pixel: Array,
    plausible: float,
    rivals: Sequence[Rival],
    config: SegmentationConfig,
    trust: Trust | None = None,
    known_factor: float | None = None,
) -> ReadingView:
    """
    Return what there is to see of ``pixels (H, W, 3)`` read as ``segmentation``.

    True metres of its nominal ones are estimated where they are not known.
    """
    levels = _levels_at(pixels, segmentation.grid, H_plan_pixel)
    walls = segmentation.grid.cells == OCCUPIED
    ranked = sorted(rivals, key=lambda rival: -rival.plausible)
    plain = ReadingView(
        segmentation=segmentation,
        H_plan_pixel=H_plan_pixel,
        levels=levels,
        thin=thin_walls(walls, round(THIN * wall_cells(walls))),
        faint=np.zeros_like(walls),
        rivals=tuple(_labels_at(rival, segmentation.grid, H_plan_pixel) for rival in ranked),
        weights=np.array([rival.plausible for rival in ranked]),
        what_if={},
        plausible=plausible,
        trust=trust,
    )
    seen = replace(plain, faint=_faint(plain))
    return replace(seen, what_if=_what_ifs(seen, config, known_factor))


def _what_ifs(
    look: ReadingView, config: SegmentationConfig, known_factor: float | None
) -> dict[str, Labels]:
    if not look.segmentation.rooms:
        return dict.fromkeys(WHAT_IFS, look.segmentation.labels)
    factor = known_factor or estimate_metres_per_unit(look.segmentation).factor
    grid = look.segmentation.grid
    found = {
        name: segment_at(grid, config, factor * change).labels for name, change in _FACTORS.items()
    }
    same = look.segmentation.labels if known_factor else None
    for name, walls in (('thick', look.thin), ('dark', look.faint)):
        if walls.any():
            found[name] = segment_at(_without(grid, walls), config, factor).labels
            continue
        if same is None:
            same = segment_at(grid, config, factor).labels
        found[name] = same
    return found


def _without(grid: GridMap, gone: Mask) -> GridMap:
    return replace(grid, cells=np.where(gone, FREE, grid.cells).astype(np.int8))


def _faint(look: ReadingView) -> Mask:
    """Return which walls (H, W) are fainter than the usual one; a wall's edge is part of it."""
    strongest = cv2.dilate(look.levels, square(3))
    return np.asarray(look.walls & (strongest < _FAINT * look.tone))


def _levels_at(pixels: Levels, grid: GridMap, H_plan_pixel: Array) -> Levels:
    """Return the contrast of a drawing at the cells (H, W) of a grid."""
    H_cell_pixel = np.linalg.inv(pixel_to_xy(grid).matrix) @ H_plan_pixel
    middle = np.linalg.solve(H_cell_pixel, [grid.shape[1] / 2.0, grid.shape[0] / 2.0, 1.0])
    factor = min(1.0, growth_at(H_cell_pixel, middle[:2] / middle[2]))
    size = [max(1, round(side * factor)) for side in pixels.shape[1::-1]]
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    back = np.diag([pixels.shape[1] / size[0], pixels.shape[0] / size[1], 1.0])
    shown = cv2.warpPerspective(
        small, H_cell_pixel @ back, grid.shape[::-1], borderMode=cv2.BORDER_REPLICATE
    )[::-1]
    is_wall, is_free = grid.cells == OCCUPIED, grid.cells == FREE
    if is_wall.any() and is_free.any() and shown[is_wall].mean() > shown[is_free].mean():
        shown = 255 - shown
    return contrast(np.ascontiguousarray(shown))


def _labels_at(rival: Rival, grid: GridMap, H_plan_pixel: Array) -> Labels:
    """Return a rival's room labels at the cells (H, W) of a grid, 0 outside."""
    other = rival.segmentation
    to_cell = np.linalg.inv(pixel_to_xy(other.grid).matrix) @ rival.H_plan_pixel
    H = to_cell @ np.linalg.inv(H_plan_pixel) @ pixel_to_xy(grid).matrix
    labels = np.ascontiguousarray(other.labels[::-1]).astype(np.float32)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    found = cv2.warpPerspective(labels, H, grid.shape[::-1], flags=flags)
    return np.ascontiguousarray(found[::-1]).astype(np.int32)
