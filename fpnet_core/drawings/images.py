# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images of drawings: upright, in colour, on white where they are transparent."""

from __future__ import annotations

from pathlib import Path
import warnings

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from fpnet_core.drawings.types import Array, Drawing
from fpnet_core.io.images import load_pixels

_ORIENTATION = 0x0112  # EXIF's tag


def open_image(path: Path) -> Drawing:
    """
    Return an image file as a drawing.

    Raises
    ------
    MapFormatError
        If the file is missing, no image, damaged, empty or too large.
    """
    stored = on_white(load_pixels(path))
    turn = _orientation(path)
    pixels = _turned(stored, turn)
    A = _affine(stored.shape[:2], turn)
    kind = path.suffix[1:].lower() or 'image'
    return Drawing(pixels, path.name, 'jpeg' if kind == 'jpg' else kind, A_pixel_image=A)


def on_white(pixels: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return ``(H, W, 3)`` colours of ``pixels (H, W, C)`` in [0, 1]; see ``load_pixels``."""
    channels = pixels.shape[2]
    colour = pixels[..., :3] if channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    if channels in (2, 4):
        alpha = pixels[..., -1:]
        colour = alpha * colour + (1.0 - alpha)
    levels: NDArray[np.uint8] = np.rint(colour * 255.0).astype(np.uint8)
    return levels


def _orientation(path: Path) -> int:
    """Return EXIF's code of how the picture is turned, 1 where it is not."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('ignore')
            with Image.open(path) as image:
                code = image.getexif().get(_ORIENTATION, 1)
    except Exception:  # damaged tags come with good pixels
        return 1
    return int(code) if isinstance(code, int) and 1 <= code <= 8 else 1


def _turned(pixels: NDArray[np.uint8], code: int) -> NDArray[np.uint8]:
    image = Image.fromarray(pixels)
    image.getexif()[_ORIENTATION] = code
    return np.asarray(ImageOps.exif_transpose(image))


def _affine(shape: tuple[int, ...], code: int) -> Array:
    """Return the affine (2, 3) from stored pixels to those of the upright picture."""
    x, y = float(shape[1] - 1), float(shape[0] - 1)
    matrices = {
        1: [[1, 0, 0], [0, 1, 0]],
        2: [[-1, 0, x], [0, 1, 0]],
        3: [[-1, 0, x], [0, -1, y]],
        4: [[1, 0, 0], [0, -1, y]],
        5: [[0, 1, 0], [1, 0, 0]],
        6: [[0, -1, y], [1, 0, 0]],
        7: [[0, -1, y], [-1, 0, x]],
        8: [[0, 1, 0], [-1, 0, x]],
    }
    return np.array(matrices[code], dtype=np.float64)
