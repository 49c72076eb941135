# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Straightened, reduced view of a drawing with the transform to the drawing."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.pictures.straighten import (
    Levels,
    find_straightening,
    straightened_size,
)
from fpnet_core.drawings.types import Array, Box
from fpnet_core.raster.pixels import cut_from, growth_at, map_points, shrinking

WORK_PX = 1800
"""Numerical: longer side of the view; the network sees less of it at a time."""

# Chosen, not measured:
_NEAR_SHARE, _PAPER_SHARE = 0.04, 0.06  # of the longer side: ink this close needs this margin
_UNLIKE_PAPER = 48  # levels between paper and ink
_BESIDE_SHARE = 0.25  # of the border differs from paper if a table surrounds the sheet
_SAMPLES = 30_000  # numerical: sampled pixels, whose median is the paper


@dataclass(frozen=True, eq=False)
class View:
    """
    A straightened view of ``shape`` (H, W) and its transform.

    ``H_view_pixel (3, 3)`` maps the drawing's pixels to those of the view; ``is_straightened`` is
    true if it does more than scale. ``pixels (H, W, 3)`` are the drawing's.
    """

    shape: tuple[int, int]
    H_view_pixel: Array
    pixels: Levels
    is_straightened: bool

    def shown(self, box: Box, longest: int) -> tuple[Levels, Array]:
        """
        Return the drawing's pixels within ``box`` of the view, straightened like the view.

        Parameters
        ----------
        box : left, top, right, bottom in the view's pixels
        longest : longer side of the returned image; a smaller drawing is not enlarged

        Returns
        -------
        picture : (H, W, 3)
        H_picture_pixel : (3, 3), from the drawing's pixels
        """
        left, top, right, bottom = box
        middle = np.array([left + right, top + bottom]) / 2.0
        per_pixel = self._reduction(middle)
        factor = min(longest / max(right - left, bottom - top), per_pixel)
        size = [max(1, round(factor * side)) for side in (right - left, bottom - top)]
        reduced = shrinking((size[0] / (right - left), size[1] / (bottom - top)))
        H = reduced @ cut_from(left, top) @ self.H_view_pixel
        H_pixel_picture = np.asarray(np.linalg.inv(H), np.float64)
        source, H_source_pixel = _shrunk_part(
            self.pixels, H_pixel_picture, size, per_pixel / factor
        )
        H_picture_source = H @ np.linalg.inv(H_source_pixel)
        picture = cv2.warpPerspective(
            source, H_picture_source, size, borderMode=cv2.BORDER_REPLICATE
        )
        return np.asarray(picture, np.uint8), H

    def _reduction(self, centre: Array) -> float:
        """Return the edge of a pixel of the view in pixels of the drawing, at ``centre``."""
        back = np.asarray(np.linalg.inv(self.H_view_pixel), np.float64)
        return growth_at(back, centre)


def _shrunk_part(
    pixels: Levels, H_pixel_picture: Array, size: list[int], reduction: float
) -> tuple[Levels, Array]:
    """
    Return the part of ``pixels (H, W, 3)`` that an image shows, averaged to about its size.

    ``reduction`` is the edge of a pixel of the image in ``pixels``. The second return value is the
    map (3, 3) from ``pixels`` to the returned part.
    """
    corners = np.array([[0, 0], [size[0], 0], [size[0], size[1]], [0, size[1]]], float)
    there = map_points(H_pixel_picture, corners)
    limit = np.array(pixels.shape[1::-1])
    left, top = np.clip(np.floor(there.min(axis=0)).astype(int) - 2, 0, limit - 1).tolist()
    right, bottom = np.clip(np.ceil(there.max(axis=0)).astype(int) + 3, 1, limit).tolist()
    part, move = pixels[top:bottom, left:right], cut_from(left, top)
    if reduction < _WORTH_IT:
        return part, move
    small = [max(1, round(side / reduction)) for side in part.shape[1::-1]]
    shown = np.asarray(cv2.resize(part, small, interpolation=cv2.INTER_AREA), np.uint8)
    return shown, shrinking((small[0] / part.shape[1], small[1] / part.shape[0])) @ move


_WORTH_IT = 1.2  # numerical: smaller reductions need no averaging


def on_paper(pixels: Levels, H_pixel_drawing: Array) -> tuple[Levels, Array]:
    """
    Return pixels with a margin of paper if the drawing reaches the image border.

    The network was trained on sheets with margins and takes rooms at the border for outside.

    Parameters
    ----------
    pixels : (H, W, 3)
    H_pixel_drawing : (3, 3), from a drawing's pixels to these; the returned one adds the margin
    """
    long_side = max(pixels.shape[:2])
    paper = np.median(pixels.reshape(-1, 3)[:: max(1, pixels.size // _SAMPLES)], axis=0)
    away = np.abs(pixels.astype(np.int16) - paper.astype(np.int16)).max(axis=2)
    is_drawn = away > _UNLIKE_PAPER
    is_cut = np.count_nonzero(is_drawn[_rim(is_drawn.shape, 1)]) > _BESIDE_SHARE * 4 * long_side
    if is_cut or not is_drawn[_rim(is_drawn.shape, round(_NEAR_SHARE * long_side))].any():
        return pixels, H_pixel_drawing
    by = round(_PAPER_SHARE * long_side)
    framed = cv2.copyMakeBorder(pixels, by, by, by, by, cv2.BORDER_CONSTANT, value=paper.tolist())
    return np.asarray(framed, np.uint8), cut_from(-by, -by) @ H_pixel_drawing


def _rim(shape: tuple[int, ...], by: int) -> NDArray[np.bool_]:
    """Return the mask (H, W) of pixels less than ``by`` from the image border."""
    rim = np.ones(shape, np.bool_)
    rim[by : shape[0] - by, by : shape[1] - by] = False
    return rim


def view_of(pixels: Levels) -> View:
    """
    Return the view of a drawing with rotation and perspective corrected.

    ``pixels (H, W, 3)`` are those of the drawing or of its crop.
    """
    factor = min(1.0, WORK_PX / max(pixels.shape[:2]))
    size = [max(1, round(side * factor)) for side in pixels.shape[1::-1]]
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA) if factor < 1.0 else pixels
    grey = np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), np.uint8)
    scale = shrinking((size[0] / pixels.shape[1], size[1] / pixels.shape[0]))
    H = find_straightening(grey)
    if np.array_equal(H, np.eye(3)):
        return View((size[1], size[0]), H @ scale, pixels, is_straightened=False)
    width, height = straightened_size(H, grey.shape)
    return View((height, width), H @ scale, pixels, is_straightened=True)
