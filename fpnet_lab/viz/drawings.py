# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images of floorplan drawings and of the rooms parsed from them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from fpnet.viz.segmentation import region_colour

# Chosen, not measured:
_SIDE_PX = 1100  # longest side of either half of the image
_CAPTION_PX = 46
_TILE_PX, _TITLE_PX, _GAP_PX = (460, 360), 18, 10
_GROUND = (205, 205, 205)
_COLOURS = 160  # palette of a contact sheet: half the bytes without a visible difference
_TRUE_LINE = (220, 0, 0)


def on_white(pixels: NDArray[np.uint8]) -> Image.Image:
    """Return pixels (H, W, 3 or 4) as an image, with white in transparent areas."""
    image = Image.fromarray(pixels)
    if image.mode == 'RGBA':
        image = Image.alpha_composite(Image.new('RGBA', image.size, 'white'), image)
    return image.convert('RGB')


def save_contact_sheet(
    path: Path, pictures: Sequence[tuple[str, NDArray[np.uint8]]], columns: int
) -> None:
    """Write titled images (H, W, 3 or 4) as a grid with ``columns`` columns."""
    rows = -(-len(pictures) // columns)
    height = _TILE_PX[1] + _TITLE_PX
    shown = Image.new('RGB', (columns * _TILE_PX[0], rows * height), _GROUND)
    pen = ImageDraw.Draw(shown)
    for number, (title, pixels) in enumerate(pictures):
        left, top = number % columns * _TILE_PX[0], number // columns * height
        tile = on_white(pixels)
        tile.thumbnail((_TILE_PX[0] - _GAP_PX, _TILE_PX[1] - _GAP_PX), Image.Resampling.LANCZOS)
        pen.text((left + _GAP_PX, top + _GAP_PX / 2), title, fill='black')
        shown.paste(tile, (left + _GAP_PX, top + _TITLE_PX))
    path.parent.mkdir(parents=True, exist_ok=True)
    shown.quantize(_COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def save_comparison(
    path: Path,
    pixels: NDArray[np.uint8],
    rooms: tuple[NDArray[np.int32], NDArray[np.int32]] | None,
    caption: str,
) -> None:
    """
    Write a drawing next to the rooms parsed from it.

    Parameters
    ----------
    path : image to write
    pixels : (H, W, 3 or 4) of the drawing
    rooms : parsed labels (H', W'), drawn coloured, and true labels, drawn as red outlines, both
        with row 0 at the bottom; None if parsing failed
    caption : up to three lines
    """
    halves = [on_white(pixels)]
    if rooms is not None:
        halves.append(_rooms(*rooms))
    for half in halves:
        half.thumbnail((_SIDE_PX, _SIDE_PX))
    size = (sum(half.width for half in halves), max(half.height for half in halves) + _CAPTION_PX)
    shown = Image.new('RGB', size, 'white')
    left = 0
    for half in halves:
        shown.paste(half, (left, _CAPTION_PX))
        left += half.width
    ImageDraw.Draw(shown).text((4, 4), caption, fill='black')
    path.parent.mkdir(parents=True, exist_ok=True)
    shown.save(path)


def _rooms(found: NDArray[np.int32], true: NDArray[np.int32]) -> Image.Image:
    colours = np.full((int(found.max()) + 1, 3), 255, np.uint8)
    for label in range(1, len(colours)):
        colours[label] = np.round(255.0 * np.array(region_colour(label - 1)))
    shown = np.ascontiguousarray(colours[found][::-1])
    for label in range(1, int(true.max()) + 1):
        mask = np.ascontiguousarray((true[::-1] == label).astype(np.uint8))
        outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        cv2.drawContours(shown, outlines, -1, _TRUE_LINE, 3)
    return Image.fromarray(shown)
