# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What each pixel of a sheet shows: the truth for whatever learns to read walls."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.pixels import map_points
from fpnet_lab.sim.drawn.render import paint_rings
from fpnet_lab.sim.sheets.artwork import Area, Array, Role
from fpnet_lab.sim.sheets.sheet import Sheet
from fpnet_lab.sim.sheets.storeys import PlacedStorey, outlines_of, solid_parts

Classes = NDArray[np.uint8]

_FINER = 2  # numerical: areas are painted on a raster so many times as fine
_HALF = 0.5  # numerical: of a pixel is wall


def sheet_classes(
    sheet: Sheet, H_pixel_image: Array | None = None, shape: tuple[int, int] | None = None
) -> Classes:
    """
    Return the class (H, W) of each pixel, of :mod:`fpnet_core.io.pixel_classes`.

    Parameters
    ----------
    sheet : what is shown
    H_pixel_image : (3, 3)
        From the sheet's pixels to those that are asked for; its own if None.
    shape : rows and columns that are asked for; the sheet's own if None
    """
    H = np.eye(3) if H_pixel_image is None else H_pixel_image
    shape = shape or (sheet.pixels.shape[0], sheet.pixels.shape[1])
    S = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]])
    painter = _Painter(S @ H @ sheet.H_image_page, shape)
    for storey in sheet.storeys:
        _paint_storey(painter, storey, sheet)
    for mark in sheet.artwork.marks:  # columns; walls once more where they are areas
        if isinstance(mark, Area) and mark.role is Role.WALL:
            painter.fill(list(mark.rings), WALL)
    return painter.classes()


def _paint_storey(painter: _Painter, storey: PlacedStorey, sheet: Sheet) -> None:
    walls, panes = solid_parts(storey, sheet.look)
    for room in storey.rooms:
        painter.fill([room], FLOOR)
    for door, opening in zip(storey.on_page.doors, storey.openings, strict=True):
        painter.fill([opening], FLOOR if door.is_open else DOOR)
    for pane in panes:
        painter.fill([pane], WINDOW)
    painter.fill(outlines_of(walls), WALL)


class _Painter:
    """Paints areas of the page finely; later ones cover earlier ones."""

    def __init__(self, H_fine_page: Array, shape: tuple[int, int]) -> None:
        self.H = H_fine_page
        self.fine = np.full((_FINER * shape[0], _FINER * shape[1]), OUTSIDE, np.uint8)

    def fill(self, rings: Sequence[Array], value: int) -> None:
        """Fill rings (V, 2) [m, page], each within another a hole."""
        paint_rings(self.fine, [map_points(self.H, ring) for ring in rings], value)

    def classes(self) -> Classes:
        """Return what most of each pixel shows, what is solid first."""
        found = np.full([side // _FINER for side in self.fine.shape], OUTSIDE, np.uint8)
        size = (found.shape[1], found.shape[0])
        for value in (FLOOR, DOOR, WINDOW, WALL):
            mask = (self.fine == value).astype(np.float32)
            found[cv2.resize(mask, size, interpolation=cv2.INTER_AREA) >= _HALF] = value
        return found
