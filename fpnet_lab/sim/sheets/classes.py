# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ground truth classes of a sheet's pixels, for training wall segmentation."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.pixels import growth_at, map_points
from fpnet_lab.sim.drawn.render import paint_rings
from fpnet_lab.sim.sheets.artwork import Arcs, Area, Array, Letters, Lines, Role, Stroke
from fpnet_lab.sim.sheets.lettering import LETTER_ASPECT
from fpnet_lab.sim.sheets.sheet import Sheet
from fpnet_lab.sim.sheets.storeys import PlacedStorey, facade, outlines_of, solid_parts

Classes = NDArray[np.uint8]

_FINER = 2  # numerical: supersampling factor
_HALF = 0.5  # numerical: minimum share of a pixel for a class

TEXT_BIT, SYMBOL_BIT = 1, 2
"""Bits of an overlay map: texts; furniture, stairs and other symbols; given."""

_LETTER_HALF = 0.65  # half the line height relative to the height of a capital; chosen
_SPARE_PX = 2  # numerical: additional width of lines in the overlay
_ARC_STEPS = 17  # numerical
_SYMBOLS = (Role.FURNITURE, Role.STAIRS)


def sheet_classes(
    sheet: Sheet, H_pixel_image: Array | None = None, shape: tuple[int, int] | None = None
) -> Classes:
    """
    Return the pixel classes (H, W) as in :mod:`fpnet_core.io.pixel_classes`.

    Parameters
    ----------
    sheet : the sheet
    H_pixel_image : (3, 3)
        Homography from the sheet's pixels to the target pixels; None: identity.
    shape : rows and columns of the target; None: those of the sheet
    """
    H = np.eye(3) if H_pixel_image is None else H_pixel_image
    shape = shape or (sheet.pixels.shape[0], sheet.pixels.shape[1])
    S = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]])
    painter = _Painter(S @ H @ sheet.H_image_page, shape)
    for storey in sheet.storeys:
        _paint_storey(painter, storey, sheet)
    for mark in sheet.artwork.marks:  # adds columns; repeats walls drawn as areas
        if isinstance(mark, Area) and mark.role is Role.WALL:
            painter.fill(list(mark.rings), WALL)
    return painter.classes()


def sheet_overlays(
    sheet: Sheet, H_pixel_image: Array | None = None, shape: tuple[int, int] | None = None
) -> Classes:
    """
    Return the overlay (H, W) of texts and symbols: :data:`TEXT_BIT`, :data:`SYMBOL_BIT`.

    Parameters are those of :func:`sheet_classes`. Texts are approximate bounding boxes; symbols
    are their lines and the interior of closed lines.
    """
    H = (np.eye(3) if H_pixel_image is None else H_pixel_image) @ sheet.H_image_page
    shape = shape or (sheet.pixels.shape[0], sheet.pixels.shape[1])
    texts, symbols = np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
    growth = growth_at(H, np.array(sheet.artwork.size_m) / 2.0)
    strokes = sheet.artwork.strokes
    boxes = [_letter_box(mark) for mark in strokes if isinstance(mark, Letters)]
    if boxes:
        corners = _corners(H, np.concatenate(boxes)).reshape(-1, 4, 2)
        for corner in corners:
            cv2.fillConvexPoly(texts, corner, TEXT_BIT)
    for mark in strokes:
        if mark.role in _SYMBOLS:
            _paint_symbol(symbols, mark, H, growth)
    return texts | symbols


def _letter_box(mark: Letters) -> Array:
    """Return the bounding box corners (4, 2) [m, page] of a line of text."""
    width, half = LETTER_ASPECT * len(mark.text) * mark.height_m, _LETTER_HALF * mark.height_m
    left = 0.0 if mark.align == 'left' else -width / 2.0
    right = left + width
    box = np.array([(left, -half), (right, -half), (right, half), (left, half)])
    c, s = np.cos(mark.angle_rad), np.sin(mark.angle_rad)
    return np.asarray(mark.xy + box @ np.array([[c, s], [-s, c]]))


def _corners(H: Array, points: Array) -> NDArray[np.int32]:
    return np.asarray(np.round(map_points(H, points)).astype(np.int32))


def _paint_symbol(symbols: Classes, mark: Stroke, H: Array, growth: float) -> None:
    if isinstance(mark, Letters):
        return
    if isinstance(mark, Area):
        lines, is_closed, width_px = list(mark.rings), True, 0.0
    elif isinstance(mark, Lines):
        lines, is_closed, width_px = list(mark.lines), mark.is_closed, mark.pen.width_m * growth
    else:
        lines, width_px = _arc_lines(mark), mark.pen.width_m * growth
        is_closed = bool((np.ptp(mark.span, axis=1) > 2.0 * np.pi - 1e-6).all())
    if not lines:
        return
    splits = np.cumsum([len(line) for line in lines])[:-1]
    corners = np.split(_corners(H, np.concatenate(lines)), splits)
    if is_closed:
        # Fill separately: filled together, overlapping rings would become holes.
        for ring in [corners] if isinstance(mark, Area) else [[line] for line in corners]:
            cv2.fillPoly(symbols, ring, SYMBOL_BIT)
    cv2.polylines(symbols, corners, is_closed, SYMBOL_BIT, round(width_px) + _SPARE_PX)


def _arc_lines(arcs: Arcs) -> list[Array]:
    share = np.linspace(0.0, 1.0, _ARC_STEPS)
    angle = arcs.span[:, :1] + share * np.diff(arcs.span, axis=1)
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    return list(arcs.centre[:, None] + arcs.radius[:, None, None] * unit)


def _paint_storey(painter: _Painter, storey: PlacedStorey, sheet: Sheet) -> None:
    walls, panes = solid_parts(storey, sheet.look)
    for room in storey.rooms:
        painter.fill([room], FLOOR)
    for door, opening in zip(storey.on_page.doors, storey.openings, strict=True):
        painter.fill([opening], FLOOR if door.is_open else DOOR)
    for entrance in facade(storey, sheet.look).entrances:
        painter.fill([entrance], DOOR)
    for pane in panes:
        painter.fill([pane], WINDOW)
    painter.fill(outlines_of(walls), WALL)


class _Painter:
    """Painter of page areas on a supersampled raster; later areas cover earlier ones."""

    def __init__(self, H_fine_page: Array, shape: tuple[int, int]) -> None:
        self.H = H_fine_page
        self.fine = np.full((_FINER * shape[0], _FINER * shape[1]), OUTSIDE, np.uint8)

    def fill(self, rings: Sequence[Array], value: int) -> None:
        """Fill rings (V, 2) [m, page]; a ring inside another is a hole."""
        paint_rings(self.fine, [map_points(self.H, ring) for ring in rings], value)

    def classes(self) -> Classes:
        """Return the majority class (H, W) of each pixel; ties go to the more solid class."""
        found = np.full([side // _FINER for side in self.fine.shape], OUTSIDE, np.uint8)
        size = (found.shape[1], found.shape[0])
        for value in (FLOOR, DOOR, WINDOW, WALL):
            mask = (self.fine == value).astype(np.float32)
            found[cv2.resize(mask, size, interpolation=cv2.INTER_AREA) >= _HALF] = value
        return found
