# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Rasterization of selected paths of a vector page in pure colours, without anti-aliasing.

It supports what this project needs: areas, outlines, opacity, clip boxes and masks.
"""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.pages import (
    Array,
    Canvas,
    OutlinePieces,
    VectorPage,
    composed,
    transformed,
)
from fpnet_core.raster.pixels import PIXEL_BITS, fixed_point

MIN_WIDTH_PX = 2
"""Smallest width of lines: hairlines are often faces of walls. Chosen."""

# Chosen, not measured:
_MAX_WIDTH_PX = 200  # numerical
_FAINTEST = 13  # of 255, smallest opacity that is painted
_OPAQUE = 250  # of 255, opacity that counts as full
# Numerical: total pixels of transparent areas; further areas are skipped.
_MAX_BLENDED = 2_000_000_000
_FAR = 4.0  # numerical: coordinates are clipped to this many image sizes


def paint(
    page: VectorPage,
    pieces: OutlinePieces,
    canvas: Canvas,
    is_area: NDArray[np.bool_],
    is_line: NDArray[np.bool_],
    image: NDArray[np.uint8] | None = None,
) -> NDArray[np.uint8]:
    """
    Return the image ``(H, W, 3)`` of a page, on white or over ``image``.

    Parameters
    ----------
    page, pieces : the page and the segments of its outlines
    canvas : the target
    is_area : (P,)
        Paths whose area is painted if they have a fill colour.
    is_line : (N,)
        Segments that are painted if their path has a stroke colour.
    """
    image = np.full((*canvas.shape, 3), 255, np.uint8) if image is None else image
    _paint_pictures(image, page, canvas)
    is_line = is_line & (page.stroke[pieces.path, 3] >= _FAINTEST)
    is_line &= _is_near(pieces.ends, page, pieces.path, canvas)
    is_area = is_area & (page.fill[:, 3] >= _FAINTEST)
    ends = _fixed(transformed(pieces.ends, canvas.A_pixel_page), canvas)
    blended = [0]
    for start, stop in pairwise(_runs(page, is_area)):
        first, last = np.searchsorted(pieces.path, [start, stop])
        chosen = first + np.flatnonzero(is_line[first:last])
        if not (is_area[start] or len(chosen)):
            continue
        part, offset = _clipped(image, page, start, canvas)
        if not part.size:
            continue
        outside = _outside(page, start, canvas, part, offset)
        before = part.copy() if outside is not None else part
        if is_area[start]:
            _fill(part, offset, page, start, canvas, blended)
        if len(chosen):
            _draw(part, offset, page, start, canvas, ends[chosen])
        if outside is not None:
            part[outside] = before[outside]
    return image


def _runs(page: VectorPage, is_area: NDArray[np.bool_]) -> list[int]:
    """Return the starts of runs of paths whose outlines can be painted at once, and the end."""
    count = len(page.width)
    style = np.column_stack([page.stroke, page.width, page.clip, page.mask])
    changes = np.flatnonzero((style[1:] != style[:-1]).any(axis=1)) + 1
    areas = np.flatnonzero(is_area)
    starts = np.unique(np.concatenate([[0], changes, areas, [count]]))
    return [int(start) for start in starts]


def _is_near(
    ends: Array, page: VectorPage, path: NDArray[np.int64], canvas: Canvas
) -> NDArray[np.bool_]:
    """Return the mask of segments that reach the canvas."""
    placed = transformed(ends, canvas.A_pixel_page)
    reach = page.width[path, None] * canvas.pixels_per_unit + 1.0
    size = np.array(canvas.shape[::-1], dtype=np.float64)
    near: NDArray[np.bool_] = (placed.max(axis=1) > -reach).all(axis=1)
    near &= (placed.min(axis=1) < size + reach).all(axis=1)
    return near


def _fixed(points: Array, canvas: Canvas) -> NDArray[np.int32]:
    """Return points [pixels] as OpenCV's fixed-point numbers, clipped to their range."""
    far = _FAR * max(canvas.shape)
    return fixed_point(np.clip(points, -far, far))


def _outside(
    page: VectorPage,
    path: int,
    canvas: Canvas,
    part: NDArray[np.uint8],
    offset: NDArray[np.int64],
) -> NDArray[np.bool_] | None:
    """Return where in ``part`` a path is masked out; None if it has no mask."""
    if page.mask[path] < 0:
        return None
    rings = [
        _fixed(transformed(r, canvas.A_pixel_page), canvas) for r in page.masks[page.mask[path]]
    ]
    inside = np.zeros(part.shape[:2], np.uint8)
    for group in _wound([ring - (offset << PIXEL_BITS).astype(np.int32) for ring in rings]):
        cv2.fillPoly(inside, group, 1, cv2.LINE_8, PIXEL_BITS)
    outside: NDArray[np.bool_] = inside == 0
    return outside


def _draw(
    part: NDArray[np.uint8],
    offset: NDArray[np.int64],
    page: VectorPage,
    path: int,
    canvas: Canvas,
    ends: NDArray[np.int32],
) -> None:
    width = page.width[path] * canvas.pixels_per_unit
    thickness = int(np.clip(round(width), MIN_WIDTH_PX, _MAX_WIDTH_PX))
    moved = ends - (offset << PIXEL_BITS).astype(np.int32)
    colour = _on_white(page.stroke[path])
    cv2.polylines(part, list(moved), False, colour, thickness, cv2.LINE_8, PIXEL_BITS)


def _fill(
    part: NDArray[np.uint8],
    offset: NDArray[np.int64],
    page: VectorPage,
    path: int,
    canvas: Canvas,
    blended: list[int],
) -> None:
    rings = []
    for ring in range(*np.searchsorted(page.path, [path, path + 1])):
        points = page.points[page.ring_start[ring] : page.ring_start[ring + 1]]
        rings.append(_fixed(transformed(points, canvas.A_pixel_page), canvas))
    low = np.min([ring.min(axis=0) for ring in rings], axis=0) >> PIXEL_BITS
    high = (np.max([ring.max(axis=0) for ring in rings], axis=0) >> PIXEL_BITS) + 2
    x0, y0 = np.maximum(low - offset, 0)
    x1, y1 = np.maximum(high - offset, 0)
    part, offset = part[y0:y1, x0:x1], offset + np.array([x0, y0])
    if not part.size:
        return
    rings = [ring - (offset << PIXEL_BITS).astype(np.int32) for ring in rings]
    groups = [rings] if page.is_even_odd[path] or len(rings) == 1 else _wound(rings)
    red, green, blue, opacity = page.fill[path].tolist()
    if opacity >= _OPAQUE:
        for group in groups:
            cv2.fillPoly(part, group, (red, green, blue), cv2.LINE_8, PIXEL_BITS)
        return
    blended[0] += part.shape[0] * part.shape[1]
    if blended[0] < _MAX_BLENDED:
        mask = np.zeros(part.shape[:2], np.uint8)
        for group in groups:
            cv2.fillPoly(mask, group, 255, cv2.LINE_8, PIXEL_BITS)
        inside = mask > 0
        mixed = part[inside] * (1.0 - opacity / 255.0)
        part[inside] = np.rint(mixed + np.multiply((red, green, blue), opacity / 255.0))


def _wound(rings: list[NDArray[np.int32]]) -> list[list[NDArray[np.int32]]]:
    """
    Return rings in groups that the even-odd rule paints like the non-zero rule.

    A ring of opposite orientation cuts a hole; rings of one orientation are painted separately.
    """
    areas = [_signed_area(ring) for ring in rings]
    return [rings] if min(areas) < 0.0 < max(areas) else [[ring] for ring in rings]


def _signed_area(ring: NDArray[np.int32]) -> float:
    x, y = (ring - ring[0]).astype(np.float64).T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _clipped(
    image: NDArray[np.uint8], page: VectorPage, path: int, canvas: Canvas
) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Return the part of the image within a path's clip box, and its offset (x, y)."""
    clip = page.clip[path]
    size = np.array(canvas.shape[::-1])
    if not np.isfinite(clip).all():
        return image, np.zeros(2, np.int64)
    corners = transformed(clip.reshape(2, 2), canvas.A_pixel_page)
    low = np.clip(np.floor(corners.min(axis=0)), 0, size).astype(np.int64)
    high = np.clip(np.ceil(corners.max(axis=0)) + 1, 0, size).astype(np.int64)
    return image[low[1] : high[1], low[0] : high[0]], low


def _paint_pictures(image: NDArray[np.uint8], page: VectorPage, canvas: Canvas) -> None:
    for picture in page.pictures:
        cv2.warpAffine(
            picture.pixels,
            composed(canvas.A_pixel_page, picture.A_page_picture),
            canvas.shape[::-1],
            dst=image,
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_TRANSPARENT,
        )


def _on_white(colour: NDArray[np.uint8]) -> tuple[int, ...]:
    """Return (red, green, blue) of a colour with opacity, blended with white paper."""
    opacity = float(colour[3]) / 255.0
    mixed = np.rint(255.0 * (1.0 - opacity) + colour[:3] * opacity)
    return tuple(int(part) for part in mixed)
