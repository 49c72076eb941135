# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reader of images: upright pixels on white."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fpnet_core.drawings.formats.pages import PALE
from fpnet_core.drawings.types import Array, Box, Drawing
from fpnet_core.errors import MapFormatError
from fpnet_core.io.images import MAX_PIXELS, opened_image, too_large

WORK_PIXELS = 16_000_000
"""Chosen: larger images are reduced to this size [pixels]; the network uses fewer still."""

MAX_STORED_PIXELS = {'JPEG': 500_000_000}
"""Numerical: larger images are rejected before decoding; JPEG is decoded at reduced size."""
_MAX_DECODED_PIXELS = 170_000_000  # numerical: 680 MB while an image is decoded as a whole
_STRIP_ROWS = 256  # numerical: rows of a reduced image that are computed at once

_ORIENTATION = 0x0112  # given: EXIF tag of the camera's orientation
_TURNS = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}
_LEVELS_OF_16_BIT = 257.0  # given: 65535 / 255


def open_image(path: Path, page: int | None = None, crop: Box | None = None) -> Drawing:
    """
    Open a PNG, JPEG, TIFF, WebP, GIF, BMP or PGM image; ``page`` from 1, of a multi-page TIFF.

    The EXIF orientation is applied; transparent areas become white; palettes, 16-bit and
    floating-point levels become 8-bit colours. An image of more than :data:`WORK_PIXELS` is
    reduced until it, or its part ``crop`` (in pixels of the full image), has that many.

    Raises
    ------
    MapFormatError
        If the file is missing, not an image, damaged or too large, or lacks the page.
    """
    with opened_image(path, _check_stored) as image:
        notes = _turned_to(page, image, path)
        turn = image.getexif().get(_ORIENTATION, 1)
        kind = (image.format or path.suffix.lstrip('.')).lower()
        width, height = image.size
        A_pixel_image = _upright(turn, width, height)
        pixels = _on_white(_turned_upright(_reduced(image, _factor(image.size, crop)), turn))
    if turn != 1:
        notes = (*notes, 'The photograph was turned upright by its EXIF orientation.')
    size = (height, width) if turn in _ON_ITS_SIDE else (width, height)
    full_size = None if pixels.shape[1::-1] == size else size
    return Drawing(
        pixels, path.name, kind, A_pixel_image=A_pixel_image, notes=notes, full_size=full_size
    )


_ON_ITS_SIDE = range(5, 9)  # given: orientations that exchange width and height


def _check_stored(image: Image.Image, path: Path) -> None:
    """Raise MapFormatError if an image cannot be decoded within a gigabyte."""
    is_draft = image.format == 'JPEG' and not image.info.get('progressive')
    most = MAX_STORED_PIXELS['JPEG'] if is_draft else _MAX_DECODED_PIXELS
    if image.width * image.height > most:
        raise MapFormatError(too_large(path, f'{image.width} x {image.height} pixels', most))


def _factor(size: tuple[int, int], crop: Box | None) -> float:
    """Return the factor by which an image's sides are reduced; 1 if it is small enough."""
    whole = size[0] * size[1]
    part = whole
    if crop is not None:
        part = min(max((crop[2] - crop[0]) * (crop[3] - crop[1]), 1), whole)
    # With a small crop of a huge image, the rest of the image still takes memory.
    most = min(WORK_PIXELS * whole / part, MAX_PIXELS / 2)
    return 1.0 if whole <= most else float(np.sqrt(most / whole))


def _reduced(image: Image.Image, factor: float) -> Image.Image:
    """Return an image reduced by ``factor``; each pixel is the mean of the area it covers."""
    if factor >= 1.0:
        return image
    width, height = (max(1, round(factor * side)) for side in image.size)
    image.draft(None, (width, height))  # JPEG is decoded at a half, a quarter or an eighth
    columns, rows = image.size
    strips = []
    for top in range(0, height, _STRIP_ROWS):
        bottom = min(top + _STRIP_ROWS, height)
        first, last = top * rows / height, bottom * rows / height
        above, below = int(first), min(int(np.ceil(last)), rows)
        strip = _averageable(image.crop((0, above, columns, below)))
        box = (0.0, first - above, float(columns), min(last - above, float(below - above)))
        strips.append(strip.resize((width, bottom - top), Image.Resampling.BOX, box))
    whole = Image.new(strips[0].mode, (width, height))
    for number, strip in enumerate(strips):
        whole.paste(strip, (0, number * _STRIP_ROWS))
    return whole


def _averageable(image: Image.Image) -> Image.Image:
    """Return an image in a mode whose levels can be averaged."""
    if image.mode.startswith('I') or image.mode == 'F':
        return Image.fromarray(_on_white(image))
    if 'A' in image.getbands() or 'transparency' in image.info:
        return image.convert('RGBA')
    return image.convert('L' if image.mode in ('1', 'L') else 'RGB')


def _turned_upright(image: Image.Image, turn: int) -> Image.Image:
    """Return an image turned upright by its EXIF orientation."""
    return image.transpose(_TURNS[turn]) if turn in _TURNS else image


def _turned_to(page: int | None, image: Image.Image, path: Path) -> tuple[str, ...]:
    """Seek a page of a TIFF, by default the first one; return notes on other pages."""
    count = getattr(image, 'n_frames', 1) if image.format == 'TIFF' else 1
    if page is None:
        return (f'page 1 of {count} was read; select others by --page',) if count > 1 else ()
    if count == 1:
        raise MapFormatError(f'{path} is an image, which has no pages; omit the page')
    if page > count:
        raise MapFormatError(f'{path.name} has {count} pages; there is no page {page}')
    image.seek(page - 1)
    _check_stored(image, path)
    return ()


def _upright(turn: int, width: int, height: int) -> Array:
    """Return the affine (2, 3) from stored pixels to upright ones, for an EXIF orientation."""
    right, bottom = width - 1.0, height - 1.0
    affine = {
        2: [[-1, 0, right], [0, 1, 0]],
        3: [[-1, 0, right], [0, -1, bottom]],
        4: [[1, 0, 0], [0, -1, bottom]],
        5: [[0, 1, 0], [1, 0, 0]],
        6: [[0, -1, bottom], [1, 0, 0]],
        7: [[0, -1, bottom], [-1, 0, right]],
        8: [[0, 1, 0], [-1, 0, right]],
    }.get(turn, [[1, 0, 0], [0, 1, 0]])
    return np.array(affine, dtype=np.float64)


def _on_white(image: Image.Image) -> NDArray[np.uint8]:
    """Return the colours (H, W, 3) on white, or on black if nothing is visible on white."""
    if image.mode.startswith('I') or image.mode == 'F':
        levels = np.asarray(image, dtype=np.float32)
        grey = levels * 255.0 if image.mode == 'F' else levels / _LEVELS_OF_16_BIT
        return np.repeat(np.rint(np.clip(grey, 0.0, 255.0)).astype(np.uint8)[..., None], 3, axis=2)
    if 'A' in image.getbands() or 'transparency' in image.info:
        opaque = image.convert('RGBA')
        shown = _on_paper(opaque, 'white')
        if shown.min() > PALE and (light := _on_paper(opaque, 'black')).any():
            return light
        return shown
    return np.array(image.convert('RGB'))


def _on_paper(image: Image.Image, colour: str) -> NDArray[np.uint8]:
    paper = Image.new('RGBA', image.size, colour)
    return np.array(Image.alpha_composite(paper, image).convert('RGB'))
