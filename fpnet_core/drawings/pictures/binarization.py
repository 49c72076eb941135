# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Contrast of ink on a drawing: darker than its surroundings, whatever the colour and shading.

A line contrasts with its surroundings, be it paper, a coloured fill or the shadow of a hand; a
fill does not. Levels of contrast are 0 to 255, relative to the brightness around a pixel.
"""

from __future__ import annotations

from functools import reduce
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from fpnet_core.raster.morphology import shrunk, square
from fpnet_core.raster.windows import border_of

Levels = NDArray[np.uint8]

# Chosen, not measured:
_REACH_SHARE = 1.0 / 50.0  # of the longer side: thickest wall found by contrast alone
_LEAST_REACH_PX = 9
_DARK_FLOOR = 64.0  # lower bound of the surroundings' grey level: relative noise grows below it
_MASS = 150  # contrast to the paper from which filled areas are ink as well
_PAPER_PX = 96  # numerical: longer side of the image for the paper's brightness
_PAPER_REACH = 0.3  # of that image: dark areas larger than this are dark paper
_TABLE_PX = 320  # numerical: longer side of the image for detecting a sheet on a table
_LINE_REACH = 0.03  # of that image: thicker than lines and walls
_BRIGHT_EDGE = 0.35  # of the image border may be as bright as the sheet
_BRIGHTER = 1.3  # smallest brightness of the sheet over that of the table
_SHEET_SHARE, _CONVEX = 0.25, 0.93  # smallest share of the sheet in the image, and in its hull
_LEVELS, _LEVEL_REACH = 4, 3  # grey levels of a clean image, and their half-width


def brightest(pixels: Levels) -> Levels:
    """Return the maximum (H, W) of each pixel's channels."""
    return _levels(reduce(cv2.max, cv2.split(pixels)))


def colourfulness(pixels: Levels) -> Levels:
    """Return the maximum minus minimum (H, W) of each pixel's channels."""
    channels = cv2.split(pixels)
    return _levels(cv2.subtract(reduce(cv2.max, channels), reduce(cv2.min, channels)))


def brightness(pixels: Levels) -> Levels:
    """Return the brightness (H, W) of pixels (H, W, 3)."""
    weights = np.array([0.299, 0.587, 0.114], dtype=np.float32)
    return np.asarray(np.rint(pixels.astype(np.float32) @ weights), dtype=np.uint8)


def commonest_levels(grey: Levels) -> list[tuple[int, float]]:
    """
    Return the commonest grey levels with the shares of pixels near each.

    A level is a peak of the smoothed histogram: the shades that a JPEG or a scanner makes of one
    level are no further levels.
    """
    count = np.bincount(grey.ravel(), minlength=256).astype(np.float64) / grey.size
    window = np.ones(2 * _LEVEL_REACH + 1)
    found = []
    for _ in range(_LEVELS):
        near = np.convolve(count, window, mode='same')
        level = int(near.argmax())
        found.append((level, float(near[level])))
        smooth = gaussian_filter1d(count, _LEVEL_REACH)  # stretched contrast leaves gaps
        low = level - max(_LEVEL_REACH, _downhill(smooth[level::-1]))
        high = level + max(_LEVEL_REACH, _downhill(smooth[level:]))
        count[max(0, low) : high + 1] = 0.0
    return found


def _downhill(height: NDArray[np.float64]) -> int:
    """Return the number of steps over which ``height (N,)`` does not rise from its start."""
    rises = np.flatnonzero(np.diff(height) > 0.0)
    return int(rises[0]) if len(rises) else len(height) - 1


def contrast(pixels: Levels) -> Levels:
    """
    Return how much darker (H, W) each pixel is than its surroundings, 0 to 255.

    Parameters
    ----------
    pixels : (H, W, 3)
        Dark lines on a lighter background. The channel with the most contrast counts, so that
        yellow lines on white are detected.
    """
    found = _mass(pixels)
    for channel in _channels(pixels):
        np.maximum(found, _share_darker(channel, paper_around(channel)), out=found)
    found[_table(pixels)] = 0
    # Subtract noise: the brightest pixel nearby is brighter than the paper.
    return np.asarray(cv2.subtract(found, np.full_like(found, np.median(found))), dtype=np.uint8)


def paper_around(pixels: Levels) -> Levels:
    """Return pixels (H, W) or (H, W, C) without darker lines up to the thickness of walls."""
    reach = max(_LEAST_REACH_PX, round(_REACH_SHARE * max(pixels.shape[:2])))
    return _levels(cv2.morphologyEx(pixels, cv2.MORPH_CLOSE, square(reach)))


def sheet_outline(pixels: Levels) -> NDArray[np.float64] | None:
    """Return the convex outline (V, 2), x and y, of a sheet photographed on a table, or None."""
    small = _small(pixels, _TABLE_PX)
    hull = _sheet_on_table(small)
    if hull is None:
        return None
    per_small = np.array(pixels.shape[1::-1]) / np.array(small.shape[1::-1])
    return np.asarray((hull.reshape(-1, 2) + 0.5) * per_small - 0.5, dtype=np.float64)


def _table(pixels: Levels) -> NDArray[np.bool_]:
    """Return the mask (H, W) of the table around a photographed sheet."""
    small = _small(pixels, _TABLE_PX)
    hull = _sheet_on_table(small)
    if hull is None:
        return np.zeros(pixels.shape[:2], dtype=np.bool_)
    inner = np.zeros(small.shape[:2], dtype=np.uint8)
    cv2.drawContours(inner, [hull], -1, 1, -1)
    inner = _levels(shrunk(inner > 0, 2))
    size = (pixels.shape[1], pixels.shape[0])
    return np.asarray(cv2.resize(inner, size, interpolation=cv2.INTER_NEAREST) == 0)


def _sheet_on_table(small: Levels) -> NDArray[np.int32] | None:
    """Return the hull (V, 1, 2) of a bright convex shape on a darker background, or None."""
    grey = _grey(small)
    side = max(3, round(_LINE_REACH * max(grey.shape)))
    plain = cv2.morphologyEx(grey, cv2.MORPH_CLOSE, square(side))
    split, bright = cv2.threshold(plain, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    del split
    if border_of(bright).mean() > _BRIGHT_EDGE or not bright.any() or bright.all():
        return None
    if plain[bright > 0].mean() < _BRIGHTER * plain[bright == 0].mean():
        return None
    contours, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    sheet = max(contours, key=cv2.contourArea)
    hull = cv2.convexHull(sheet)
    area = cv2.contourArea(hull)
    if area < _SHEET_SHARE * grey.size or cv2.contourArea(sheet) < _CONVEX * area:
        return None
    return np.asarray(hull, dtype=np.int32)


def _channels(pixels: Levels) -> list[Levels]:
    red, green, blue = (np.ascontiguousarray(pixels[..., k]) for k in range(3))
    if np.array_equal(red, green) and np.array_equal(red, blue):
        return [red]
    return [red, green, blue]


def _share_darker(level: Levels, around: Levels) -> Levels:
    gap = cv2.subtract(around, level).astype(np.float32)
    return np.asarray(255.0 * gap / np.maximum(around, _DARK_FLOOR), dtype=np.uint8)


def _mass(pixels: Levels) -> Levels:
    """
    Return the contrast of areas far darker than the paper in every channel, 0 elsewhere.

    One bright channel suffices to exclude an area: a room filled with pure red is no wall.
    """
    grey = brightest(pixels)
    small = _small(grey, _PAPER_PX)
    side = max(3, round(_PAPER_REACH * max(small.shape)))
    paper = cv2.blur(cv2.morphologyEx(small, cv2.MORPH_CLOSE, square(side)), (9, 9))
    paper = cv2.resize(paper, grey.shape[::-1], interpolation=cv2.INTER_LINEAR)
    darker = _share_darker(grey, _levels(paper))
    return np.where(darker >= _MASS, darker, 0).astype(np.uint8)


def _grey(pixels: Levels) -> Levels:
    return _levels(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY))


def _levels(values: NDArray[Any]) -> Levels:
    return np.asarray(values, dtype=np.uint8)


def _small(pixels: Levels, longest: int) -> Levels:
    factor = min(1.0, longest / max(pixels.shape[:2]))
    size = [max(1, round(side * factor)) for side in pixels.shape[1::-1]]
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
