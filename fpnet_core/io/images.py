# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader for drawings, scanned plans and robot maps that are bare images without thresholds.

The image is binarized by its histogram and border: white is free, a single grey around the
building (178 to 205 in drawings; 127, 153, 205 or 230 in robot maps) is unknown, and darker
pixels are occupied. If no pixel is darker, walls are the boundary of the free space. Images
and rasters are as stored, row 0 at the top.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
import warnings

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.JpegImagePlugin import JpegImageFile

from fpnet_core.errors import MapFormatError
from fpnet_core.plain_files import regular
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

MAX_PIXELS = 100_000_000
"""Numerical: larger images are refused before decoding (500 m x 500 m at 0.05 m per pixel)."""

Box = tuple[int, int, int, int]
"""Left, top, right and bottom [pixels]."""

_LEAST_CROP_PX = 16  # numerical
# Pillow's other formats run external programs or are not used for maps.
_FORMATS = ('PNG', 'PPM', 'JPEG', 'BMP', 'TIFF', 'WEBP', 'GIF')
# Chosen, not measured:
_WHITE_SHARE = 0.005  # paper or free space fills at least this share of the image
_WHITE_MARGIN = 25  # grey levels below white that still count as white, unless grey is nearer
_NOISE_SIGMAS = 4.0  # margin below the white level, in sigmas of the image scanner's noise
_GREY_RANGE = (40, 250)  # levels that can mean unknown
_GREY_TOLERANCE = 5  # grey levels; compression and resampling blur the unknown level
_TENT = _GREY_TOLERANCE + 1.0 - np.abs(np.arange(-_GREY_TOLERANCE, _GREY_TOLERANCE + 1))
_BELL = np.exp(-np.square(np.arange(-8.0, 9.0)) / 8.0)
_BELL /= _BELL.sum()  # numerical: blurs a histogram by two levels
_BORDER_SHARE = 0.3  # least share of the border's pixels that have the unknown level
_GREY_SHARE = 0.02  # least share of the image, for an unknown level that is not on the border
_FILL_SHARE = 0.02  # least share of the image for a shade that fills walls or furniture
_FILL_TOLERANCE = 4  # grey levels around such a shade, for blurred edges
_BLOB_SHARE = 0.5  # of a level's pixels survive a morphological opening if they are areas
_WALL_DEPTH_M = 0.4  # occupied pixels deeper than this behind a surface become unknown


def load_pixels(path: Path) -> NDArray[np.float32]:
    """
    Return an image file as ``(H, W, C) float32`` in [0, 1], as stored, C in 1, 2, 3, 4.

    If C is 2 or 4, alpha is last. The orientation tag of a photograph is ignored.

    Raises
    ------
    MapFormatError
        If the file is missing, not an image, damaged, empty or larger than ``MAX_PIXELS``.
    """
    with opened_image(path) as image:
        return levels_of(image)


@contextmanager
def opened_image(
    path: Path, check: Callable[[Image.Image, Path], None] | None = None
) -> Iterator[Image.Image]:
    """
    Open an image without decoding its pixels; a context manager.

    ``check`` refuses images that are too large; None uses :func:`check_size`.

    Raises
    ------
    MapFormatError
        As :func:`load_pixels`; also for errors inside the block.
    """
    try:
        with warnings.catch_warnings():
            # Pillow warns at 89 million pixels; the limit here is MAX_PIXELS.
            warnings.simplefilter('ignore', Image.DecompressionBombWarning)
            with _opened(regular(path)) as image:
                (check or check_size)(image, path)
                yield image
    except MapFormatError:
        raise
    except FileNotFoundError:
        raise MapFormatError(f'map image {path} does not exist') from None
    except Exception as error:
        # Pillow's decoders raise many types on damaged bytes (OSError, SyntaxError, struct.error).
        detail = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise MapFormatError(
            f'{path} is not a readable image ({detail}); '
            'expected PNG, JPEG, TIFF, WebP, GIF, BMP or PGM'
        ) from None


def _opened(path: Path) -> Image.Image:
    try:
        return Image.open(path, formats=_FORMATS)
    except Image.DecompressionBombError as error:
        # Pillow refuses large images here, but a JPEG can be decoded at a fraction of its size.
        try:
            return JpegImageFile(path)
        except SyntaxError:
            raise MapFormatError(too_large(path, 'more pixels', MAX_PIXELS)) from error


def check_size(image: Image.Image, path: Path) -> None:
    """Raise MapFormatError if an image has more than ``MAX_PIXELS``."""
    if image.width * image.height > MAX_PIXELS:
        size = f'{image.width} x {image.height} pixels'
        raise MapFormatError(too_large(path, size, MAX_PIXELS))


def too_large(path: Path, size: str, most: int) -> str:
    """Return the error message for an image with more than ``most`` pixels."""
    return (
        f'map image {path} is too large: expected at most {most // 1_000_000} million '
        f'pixels, got {size}; scale it down'
    )


def check_crop(crop: Box, size: tuple[int, int], name: str) -> None:
    """Raise MapFormatError if a crop box does not fit into an image of (width, height)."""
    width, height = size
    left, top, right, bottom = crop
    is_inside = 0 <= left < right <= width and 0 <= top < bottom <= height
    if not is_inside or min(right - left, bottom - top) < _LEAST_CROP_PX:
        raise MapFormatError(
            f'{name}: crop {crop} does not fit; expected left, top, right, '
            f'bottom within 0, 0, {width}, {height}, at least {_LEAST_CROP_PX} pixels apart'
        )


def levels_of(image: Image.Image) -> NDArray[np.float32]:
    """Return an image as ``(H, W, C) float32`` in [0, 1]; see :func:`load_pixels`."""
    full_scale = 255.0
    if image.mode.startswith('I'):  # 16-bit grey
        full_scale = 65535.0
    elif image.mode == 'F':
        full_scale = 1.0
    elif 'A' in image.getbands() or 'transparency' in image.info:
        image = image.convert('LA' if image.mode in ('L', 'LA', '1') else 'RGBA')
    else:
        image = image.convert('L' if image.mode in ('L', '1') else 'RGB')
    pixels = np.asarray(image, dtype=np.float32).reshape(image.height, image.width, -1)
    scaled: NDArray[np.float32] = np.clip(pixels / np.float32(full_scale), 0.0, 1.0)
    return scaled


def grey_levels(pixels: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the brightness ``(H, W)`` of ``pixels (H, W, C)`` on a white background."""
    channels = pixels.shape[2]
    colour = pixels[..., :3] if channels >= 3 else pixels[..., :1]
    weights = np.array([0.299, 0.587, 0.114] if channels >= 3 else [1.0], dtype=np.float32)
    grey = colour @ weights
    if channels in (2, 4):
        alpha = pixels[..., -1]
        grey = alpha * grey + (1.0 - alpha)
    levels: NDArray[np.uint8] = np.rint(grey * 255.0).astype(np.uint8)
    return levels


def interpret(grey: NDArray[np.uint8], resolution_m: float) -> NDArray[np.int8]:
    """
    Return the cell values ``(H, W)`` of a bare image.

    Parameters
    ----------
    grey : (H, W)
        Brightness as stored.
    resolution_m
        Nominal size of a pixel; only used for the depth of walls and the width of exits.

    Raises
    ------
    MapFormatError
        If no grey level can be free space.
    """
    from fpnet_core.io.outside import outside_as_unknown  # loads OpenCV
    from fpnet_core.raster.distance import cells_to_nearest

    histogram = np.bincount(grey.ravel(), minlength=256)
    white, noise = _white_level(histogram)
    unknown_level = _unknown_level(grey, histogram, white)
    threshold = white - max(_WHITE_MARGIN, _NOISE_SIGMAS * noise)
    if unknown_level is not None:
        threshold = max(threshold, 0.5 * (white + unknown_level))
    free = grey >= threshold
    occupied = ~free if unknown_level is None else _ink(grey, histogram, unknown_level, threshold)
    if not occupied.any():  # two tones without walls: walls are the boundary of free space
        occupied = ~free
    occupied &= resolution_m * cells_to_nearest(free) <= _WALL_DEPTH_M
    cells = np.select([free, occupied], [FREE, OCCUPIED], UNKNOWN).astype(np.int8)
    return outside_as_unknown(cells, resolution_m)


def _ink(
    grey: NDArray[np.uint8], histogram: NDArray[np.int64], unknown_level: float, threshold: float
) -> NDArray[np.bool_]:
    """
    Return the mask of drawn pixels of an image with a grey level for unknown.

    Pixels darker than unknown are ink. Lighter shades are ink if they are a fill, that is one
    shade on much of the image, or the blurred edge of a line. Other shades are probably free
    space in a robot map.
    """
    from fpnet_core.raster.morphology import grown

    ink: NDArray[np.bool_] = grey < unknown_level - _GREY_TOLERANCE
    shade = (grey > unknown_level + _GREY_TOLERANCE) & (grey < threshold)
    is_fill = histogram >= _FILL_SHARE * grey.size
    near_fill = np.convolve(is_fill, np.ones(2 * _FILL_TOLERANCE + 1), mode='same') > 0.0
    ink |= shade & near_fill[grey]
    ink |= grown(ink, 1) & shade
    return ink


def _white_level(histogram: NDArray[np.int64]) -> tuple[float, float]:
    """Return the level of free space (the brightest large peak) and the noise above it."""
    smooth = np.convolve(histogram.astype(np.float64), _BELL, mode='same')
    enough = _WHITE_SHARE * histogram.sum()
    for level in range(255, 127, -1):
        window = slice(max(level - 5, 0), level + 6)
        is_peak = smooth[level] >= smooth[window].max()
        if is_peak and histogram[window].sum() >= enough:
            above = np.arange(level, 256)
            count = histogram[level:]
            noise = np.sqrt((count * (above - level) ** 2).sum() / max(count.sum(), 1))
            return float(level), float(noise)
    raise MapFormatError(
        'map image has no free space: expected white or light areas, got none; '
        'invert it, or give a YAML with negate: 1'
    )


def _unknown_level(
    grey: NDArray[np.uint8], histogram: NDArray[np.int64], white: float
) -> float | None:
    """Return the grey level that means unknown or outside, or None if there is none."""
    from fpnet_core.raster.morphology import opened_by, square

    low, high = _GREY_RANGE[0], int(min(_GREY_RANGE[1], white - 2 * _GREY_TOLERANCE))
    border = np.concatenate([grey[0], grey[-1], grey[1:-1, 0], grey[1:-1, -1]])
    on_border = np.bincount(border, minlength=256)[low:high]
    near = np.convolve(on_border, np.ones(2 * _GREY_TOLERANCE + 1), mode='same')
    if near.max() >= _BORDER_SHARE * border.size:
        # The tent filter peaks in the middle of a blurred level, where the box filter is flat.
        return float(low + np.convolve(on_border, _TENT, mode='same').argmax())
    for level in low + np.argsort(histogram[low:high])[::-1][:3]:
        if histogram[level] < _GREY_SHARE * grey.size:
            break
        mask = grey == level
        if np.count_nonzero(opened_by(mask, square(5))) > _BLOB_SHARE * mask.sum():
            return float(level)
    return None
