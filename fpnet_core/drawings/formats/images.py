# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pixels of a drawing that comes as an image, upright and on white."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from fpnet_core.drawings.formats.pages import PALE
from fpnet_core.drawings.types import Array, Drawing
from fpnet_core.errors import MapFormatError
from fpnet_core.io.images import check_size, opened_image

_ORIENTATION = 0x0112  # given: the EXIF tag that says how a camera was held
_LEVELS_OF_16_BIT = 257.0  # given: 65535 / 255


def open_image(path: Path, page: int | None = None) -> Drawing:
    """
    Open a PNG, JPEG, TIFF, WebP, GIF, BMP or PGM image; ``page`` from 1, of a TIFF of several.

    A camera's orientation is applied, transparent places become white, palettes, 16-bit and
    floating-point levels become 8-bit colours.

    Raises
    ------
    MapFormatError
        If the file is missing, no image, damaged or larger than
        :data:`fpnet_core.io.images.MAX_PIXELS`, or lacks the page.
    """
    with opened_image(path) as image:
        notes = _turned_to(page, image, path)
        turn = image.getexif().get(_ORIENTATION, 1)
        kind = (image.format or path.suffix.lstrip('.')).lower()
        A_pixel_image = _upright(turn, image.width, image.height)
        pixels = _on_white(ImageOps.exif_transpose(image))
    if turn != 1:
        notes = (*notes, 'The photograph was turned upright, as its camera says.')
    return Drawing(pixels, path.name, kind, A_pixel_image=A_pixel_image, notes=notes)


def _turned_to(page: int | None, image: Image.Image, path: Path) -> tuple[str, ...]:
    """Turn to a page of a TIFF, the first one if nobody says which; notes tell of others."""
    count = getattr(image, 'n_frames', 1) if image.format == 'TIFF' else 1
    if page is None:
        return (f'page 1 of {count} was read; --page takes another one',) if count > 1 else ()
    if count == 1:
        raise MapFormatError(f'{path} is an image, which has no page; leave that out')
    if page > count:
        raise MapFormatError(f'{path.name} has {count} pages; there is no page {page}')
    image.seek(page - 1)
    check_size(image, path)
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
    """Return the colours (H, W, 3) on white paper, or on black where they would not show there."""
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
