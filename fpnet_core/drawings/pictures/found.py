# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A reading of a drawing: its cells, the rooms they are cut into, and how like a building."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.doubting import Doubts
from fpnet_core.drawings.pictures.looking import Rival
from fpnet_core.drawings.pictures.plausible import features, findings, probability
from fpnet_core.drawings.stated import UNSAID, SaidScale
from fpnet_core.drawings.types import Array, Box, Dropped, Trust
from fpnet_core.raster.pixels import pixel_to_xy, shrinking
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.segmentation.moved import rescaled_rooms
from fpnet_core.segmentation.scale import estimate_metres_per_unit, segment_at
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Segmentation

NOMINAL_M = 0.05
"""Edge of a cell where nothing is known of the scale; every figure is a ratio then. Chosen."""

_JUDGED_PX = 1200  # numerical: the longer side of a picture in which a plain reading is judged
_ROUNDS = 2  # numerical: of scale and segmentation: enough to judge


@dataclass(frozen=True, eq=False)
class Found:
    """
    A reading.

    ``cells (H, W)`` with row 0 at the top; ``H_cell_pixel (3, 3)`` maps the drawing's pixels to
    them; ``segmentation`` has cells of :data:`NOMINAL_M` and may be coarser. ``said`` is what is
    said of the scale, at which rooms are cut then; ``odds`` are those of the reading before its
    rooms are looked at. ``storeys`` and ``dropped`` are in the drawing's pixels; ``rivals`` are
    other readings of it; ``thought`` is what was thought of it where that was asked for.
    """

    cells: NDArray[np.int8]
    H_cell_pixel: Array
    segmentation: Segmentation
    probability: float
    how: str
    said: SaidScale = UNSAID
    odds: float = 1.0
    storeys: tuple[Box, ...] = ()
    chosen: int = 0
    dropped: tuple[Dropped, ...] = ()
    is_straightened: bool = False
    trust: Trust | None = None
    rivals: tuple[Rival, ...] = ()
    thought: Doubts | None = None

    @property
    def H_plan_pixel(self) -> Array:
        """Map (3, 3) from the drawing's pixels to nominal metres of the segmentation."""
        to_plan = pixel_to_xy(self.segmentation.grid).matrix
        return np.asarray(to_plan @ shrinking(1.0 / stride(self.cells)) @ self.H_cell_pixel)

    @cached_property
    def known_factor(self) -> float | None:
        """True metres of one of the segmentation's; None if unsaid or said by a slip."""
        cell_m = self.said.cell_m(self.H_cell_pixel, self.cells.shape)
        factor = None if cell_m is None else cell_m / self._nominal_m
        return None if factor is None or _is_slip(self.segmentation, factor) else factor

    @cached_property
    def is_absurd(self) -> bool:
        """Tell whether no building is like that, as one without doors."""
        return bool(not self.segmentation.rooms or findings(self.segmentation))

    def cut_at(self, grid: GridMap) -> Segmentation | None:
        """Return its rooms on a grid of its cells, None where they are not cut at its scale."""
        factor, metres = self.known_factor, grid.resolution / self._nominal_m
        if stride(self.cells) > 1 or factor is None or not math.isclose(factor, metres):
            return None
        rooms = rescaled_rooms(self.segmentation, metres)
        return replace(rooms, grid=replace(grid, cells=rooms.grid.cells))

    @property
    def as_rival(self) -> Rival:
        """The reading as others of the same drawing see it."""
        return Rival(self.segmentation, self.H_plan_pixel, self.probability)

    def with_cells(self, cells: NDArray[np.int8], config: SegmentationConfig) -> Found:
        """Return the reading with other cells (H, W), of which nothing is thought yet."""
        rooms, _ = rooms_of(cells, self._nominal_m, config, self.known_factor)
        chance = likelihood(rooms, self.odds)
        return replace(self, cells=cells, segmentation=rooms, probability=chance, thought=None)

    @property
    def _nominal_m(self) -> float:
        return self.segmentation.grid.resolution / stride(self.cells)


def likelihood(segmentation: Segmentation, odds: float = 1.0) -> float:
    """Return how surely rooms are a building's if a reading like that has ``odds`` before."""
    chance = odds * probability(features(segmentation))
    return chance / (chance + 1.0 - chance / odds)


def rooms_of(
    cells: NDArray[np.int8],
    nominal_m: float,
    config: SegmentationConfig,
    known_factor: float | None = None,
) -> tuple[Segmentation, float]:
    """
    Return the rooms of cells (H, W), seen as coarsely as does, and true metres per nominal one.

    These are estimated where they are not known, or known by a slip of the pen.
    """
    step = stride(cells)
    rows, cols = (-(-side // step) for side in cells.shape)
    padded = np.full((rows * step, cols * step), UNKNOWN, dtype=np.int8)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    blocks = padded.reshape(rows, step, cols, step)
    wall, free = (blocks == OCCUPIED).any(axis=(1, 3)), (blocks == FREE).all(axis=(1, 3))
    coarse = np.select([wall, free], [OCCUPIED, FREE], UNKNOWN).astype(np.int8)
    grid = GridMap(coarse[::-1], nominal_m * step)
    if known_factor is not None:
        segmentation = segment_at(grid, config, known_factor)
        if not _is_slip(segmentation, known_factor):
            return segmentation, known_factor
    segmentation, scale = segment_unknown_scale(grid, config, _ROUNDS)
    return segmentation, scale.factor


def _is_slip(segmentation: Segmentation, factor: float) -> bool:
    """Tell whether rooms, if there are any, are beyond doubt those of another scale."""
    if not segmentation.rooms:
        return True
    told = estimate_metres_per_unit(segmentation, factor)
    return replace(
        told, factor=told.factor / factor, low=told.low / factor, high=told.high / factor
    ).is_denial


def stride(cells: NDArray[np.int8]) -> int:
    """Return how many cells (H, W) of a reading are one of those that it is judged by."""
    return int(-(-max(cells.shape) // _JUDGED_PX))
