# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion between pixels of the user's image and pixels of its reduced copy.

Large images are parsed as a reduced copy: options are mapped to it, results mapped back.
"""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np

from fpnet_core.drawings.types import Array, Box, Drawing, DrawingScale, Reading, ReadOptions
from fpnet_core.raster.pixels import map_points, shrinking


def H_copy_image(drawing: Drawing) -> Array:
    """Return the map (3, 3) from pixels of the user's image to ``drawing.pixels``."""
    height, width = drawing.pixels.shape[:2]
    full_width, full_height = drawing.size
    return shrinking((width / full_width, height / full_height))


def options_of_copy(options: ReadOptions, drawing: Drawing) -> ReadOptions:
    """Return the options with coordinates in pixels of ``drawing.pixels``."""
    if not drawing.is_reduced:
        return options
    H, per_pixel = H_copy_image(drawing), _image_pixels(drawing)
    length, crop = options.length, options.crop
    if length is not None:
        (x1, y1), (x2, y2) = map_points(H, np.array(length[:4]).reshape(2, 2)).tolist()
        length = (x1, y1, x2, y2, length[4])
    if crop is not None:
        height, width = drawing.pixels.shape[:2]
        x, y = np.diag(H)[:2].tolist()
        left, top, right, bottom = crop
        crop = (
            math.floor(left * x),
            math.floor(top * y),
            min(math.ceil(right * x), width),
            min(math.ceil(bottom * y), height),
        )
    resolution_m = options.resolution_m
    return replace(
        options,
        resolution_m=None if resolution_m is None else resolution_m * per_pixel,
        length=length,
        crop=crop,
    )


def in_image_pixels(reading: Reading) -> Reading:
    """Return a parse result with all coordinates in pixels of the user's image."""
    drawing = reading.drawing
    if not drawing.is_reduced:
        return reading
    back = np.asarray(np.linalg.inv(H_copy_image(drawing)), np.float64)
    width, height = drawing.size
    copy_height, copy_width = drawing.pixels.shape[:2]
    note = (
        f'The image of {width} x {height} pixels was parsed at {copy_width} x {copy_height}; '
        'all coordinates are in pixels of the image itself.'
    )
    return replace(
        reading,
        scale=_rescaled(reading.scale, 1.0 / _image_pixels(drawing)),
        H_plan_image=reading.H_plan_image @ H_copy_image(drawing),
        storeys=tuple(_mapped(back, box) for box in reading.storeys),
        doubtful=tuple(replace(each, box=_mapped(back, each.box)) for each in reading.doubtful),
        notes=(*reading.notes, note),
    )


def _image_pixels(drawing: Drawing) -> float:
    """Return the edge of a pixel of the copy in pixels of the image."""
    x, y = np.diag(H_copy_image(drawing))[:2].tolist()
    return 1.0 / math.sqrt(x * y)


def _rescaled(scale: DrawingScale, factor: float) -> DrawingScale:
    low, metres, high = (each * factor for each in (scale.low_m, scale.resolution_m, scale.high_m))
    return replace(scale, resolution_m=metres, low_m=low, high_m=high)


def _mapped(H: Array, box: Box) -> Box:
    left, top, right, bottom = box
    corners = map_points(H, np.array([[left, top], [right, bottom]], float))
    first, last = np.rint(corners).astype(int).tolist()
    return first[0], first[1], last[0], last[1]
