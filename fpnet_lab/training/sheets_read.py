# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generated sheets parsed from files without prior information, as for a user."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.opening import open_drawing
from fpnet_core.drawings.pictures.hypothesis import PlanHypothesis, find_building
from fpnet_core.drawings.types import Drawing, ReadOptions
from fpnet_core.errors import FpnetError
from fpnet_core.raster.pixels import growth_at
from fpnet_core.types import GridMap
from fpnet_lab.evaluation.drawings import written
from fpnet_lab.sim.sheets import Sheet

COMPARED_CELLS = 1200
"""Numerical: cells per side of the raster for the comparison; a room has hundreds of cells."""


@dataclass(frozen=True, eq=False)
class SheetRead:
    """
    A sheet, the ``pixels (H, W, 3)`` uint8 of its file, and the selected plan hypothesis.

    ``H_pixel_page (3, 3)`` maps metres of the page to the file's pixels.
    """

    sheet: Sheet
    pixels: NDArray[np.uint8]
    found: PlanHypothesis
    H_pixel_page: NDArray[np.float64]

    @property
    def in_true_metres(self) -> GridMap:
        """Parsed floorplan with the true cell size."""
        H_plan_page = self.found.H_plan_pixel @ self.H_pixel_page
        grid = self.found.segmentation.grid
        return replace(grid, resolution=grid.resolution / growth_at(H_plan_page, self._middle))

    @property
    def _middle(self) -> NDArray[np.float64]:
        corners = [storey.on_page.extent.mean(axis=0) for storey in self.sheet.storeys]
        return np.asarray(np.mean(corners, axis=0))


def read_from_file(sheet: Sheet, config: SegmentationConfig) -> SheetRead | None:
    """Write a sheet to a file and parse it; None if it is rejected."""
    with TemporaryDirectory() as folder:
        path, H_file_page = written(sheet, Path(folder) / 'sheet', 'picture')
        drawing = open_drawing(path, ReadOptions())
    found = _found(drawing, config)
    if found is None:
        return None
    H_pixel_page = np.vstack([drawing.A_pixel_image, [0.0, 0.0, 1.0]]) @ H_file_page
    return SheetRead(sheet, drawing.pixels, found, H_pixel_page)


def picture_read(pixels: NDArray[np.uint8], config: SegmentationConfig) -> PlanHypothesis | None:
    """Return the plan hypothesis of an image (H, W, 3) parsed from a file; None if rejected."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'picture.png'
        Image.fromarray(pixels).save(path)
        drawing = open_drawing(path, ReadOptions())
    return _found(drawing, config)


def _found(drawing: Drawing, config: SegmentationConfig) -> PlanHypothesis | None:
    try:
        return find_building(drawing, ReadOptions(), config)
    except FpnetError:
        return None
