# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Canvas for rasters, lines, arrows and text, with antialiasing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.raster.pixels import PIXEL_BITS, fixed_point

Colour = tuple[int, ...]
Text = tuple[tuple[int, int], str, Colour]

# Chosen, not measured:
_FONT_PX = 18
_ARROW_PX = 15.0  # from tail to tip
_RIM_PX = 2
_FILLED = 0.97  # of the size of a box
_LARGER = 2  # numerical: supersampling, reduced at the end

ARROW = np.array([[0.6, 0.0], [-0.4, 0.36], [-0.2, 0.0], [-0.4, -0.36]])
"""Corners of an arrowhead of length 1 that points along x. Chosen."""


@dataclass(frozen=True)
class Box:
    """A rectangle on a canvas [px], x right and y down."""

    x: int
    y: int
    width: int
    height: int


def fitted(xy: NDArray[np.float64], box: Box, T_frame_up: SE2 | None = None) -> Affine2D:
    """
    Return the map from metres to pixels that fits ``xy (P, 2)`` into the middle of a box.

    The axes of ``T_frame_up``, by default those of the frame, point right and up.
    """
    T_up_frame = SE2.identity() if T_frame_up is None else T_frame_up.inv()
    placed = T_up_frame.apply(xy)
    low, high = placed.min(axis=0), placed.max(axis=0)
    size = np.array([box.width, box.height])
    scale = _FILLED * float((size / np.maximum(high - low, 1e-6)).min())
    flip = np.diag([scale, -scale])
    middle = np.array([box.x, box.y]) + 0.5 * size
    A_px_up = Affine2D(flip, middle - flip @ (0.5 * (low + high)))
    A_px_frame: Affine2D = A_px_up @ T_up_frame
    return A_px_frame


class PictureSheet:
    """A canvas; positions are pixels of the finished image, integers at pixel corners."""

    def __init__(self, pixels: NDArray[np.uint8], texts: Sequence[Text] = ()) -> None:
        self._pixels, self._texts = pixels, list(texts)

    @classmethod
    def blank(cls, size: tuple[int, int]) -> PictureSheet:
        """Return a white canvas; ``size`` is its width and height."""
        width, height = size
        return cls(np.full((_LARGER * height, _LARGER * width, 3), 255, np.uint8))

    def copy(self) -> PictureSheet:
        """Return an independent copy."""
        return PictureSheet(self._pixels.copy(), self._texts)

    def picture(
        self,
        image: NDArray[np.uint8],
        opacity: NDArray[np.float64],
        A_px_cell: Affine2D,
        box: Box | None = None,
    ) -> None:
        """Draw an image (H, W, 3); ``A_px_cell`` places its (column, row); clip to a box."""
        A = Affine2D(_LARGER * np.eye(2), np.full(2, -0.5)) @ A_px_cell
        size = self._pixels.shape[1::-1]
        # Premultiplied by opacity, colours of transparent cells do not bleed into others.
        weights = np.asarray(opacity, dtype=np.float32)
        layers = np.dstack([image * weights[..., None], weights])
        warped = cv2.warpAffine(layers, A.matrix[:2], size, flags=cv2.INTER_AREA)
        if box is not None:
            inside = np.zeros(warped.shape[:2], bool)
            inside[self._rows_and_columns(box)] = True
            warped[~inside] = 0.0
        colours, covered = warped[..., :3], warped[..., 3:]
        self._pixels[:] = np.clip(np.rint(colours + (1.0 - covered) * self._pixels), 0, 255)

    @staticmethod
    def _rows_and_columns(box: Box) -> tuple[slice, slice]:
        rows = slice(_LARGER * box.y, _LARGER * (box.y + box.height))
        return rows, slice(_LARGER * box.x, _LARGER * (box.x + box.width))

    def line(self, places: NDArray[np.float64], colour: Colour, width_px: int) -> None:
        """Draw a line through positions (P, 2)."""
        points = [self._points(places)]
        cv2.polylines(
            self._pixels, points, False, colour, width_px * _LARGER, cv2.LINE_AA, PIXEL_BITS
        )

    def arrow(
        self, place: NDArray[np.float64], ahead: NDArray[np.float64], colour: Colour
    ) -> None:
        """Draw an arrowhead at a position, in direction ``ahead`` (2,), with a white outline."""
        x, y = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        outline = place + _ARROW_PX * ARROW @ np.array([[x, y], [-y, x]])
        points = [self._points(outline)]
        rim = 2 * _RIM_PX * _LARGER
        cv2.polylines(self._pixels, points, True, (255, 255, 255), rim, cv2.LINE_AA, PIXEL_BITS)
        cv2.fillPoly(self._pixels, points, colour, cv2.LINE_AA, PIXEL_BITS)

    @staticmethod
    def _points(places: NDArray[np.float64]) -> NDArray[np.int32]:
        return fixed_point(places * _LARGER)

    def text(self, place: tuple[int, int], text: str, colour: Colour) -> None:
        """Write a line of text with its top left corner at a position, on top of all else."""
        self._texts.append((place, text, colour))

    def image(self) -> Image.Image:
        """Return the finished image."""
        height, width = (side // _LARGER for side in self._pixels.shape[:2])
        small = cv2.resize(self._pixels, (width, height), interpolation=cv2.INTER_AREA)
        image = Image.fromarray(small)
        draw = ImageDraw.Draw(image)
        font = ImageFont.load_default(_FONT_PX)
        for place, text, colour in self._texts:
            draw.text(place, text, fill=colour, font=font)
        return image
