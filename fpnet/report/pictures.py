# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rasters as embedded images, resampled to the axes of their metric frame."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
import io

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fpnet.viz.segmentation import PALE, Colour, painted
from fpnet_core.raster.pixels import corners_xy
from fpnet_core.types import UNKNOWN, GridMap, Segmentation

_COLOURS = 64  # numerical: palette size of an image


@dataclass(frozen=True)
class Picture:
    """
    A PNG as a data URI with the position of its top left corner in the frame [m], y up.

    ``width`` and ``height`` are in metres.
    """

    uri: str
    x: float
    y: float
    width: float
    height: float

    def as_layout_image(self) -> dict[str, object]:
        """Return the picture as an image of a plotly layout."""
        return {
            'source': self.uri,
            'xref': 'x',
            'yref': 'y',
            'x': self.x,
            'y': self.y,
            'sizex': self.width,
            'sizey': self.height,
            'sizing': 'stretch',
            'layer': 'below',
        }


PLAN_PX = 1600
"""Longest side of a floorplan's image. Chosen."""


def segmentation_picture(
    segmentation: Segmentation,
    longest_px: int = PLAN_PX,
    colours: Mapping[int, Colour] | None = None,
) -> Picture:
    """Return the grid with tinted rooms, at most ``longest_px`` wide and high."""
    return grid_picture(segmentation.grid, painted(segmentation, colours), longest_px)


def pale_picture(plan: Segmentation) -> Picture:
    """Return the plan with grey walls and faint rooms, as background of lidar walls and paths."""
    return grid_picture(plan.grid, painted(plan, shades=PALE), PLAN_PX, None)


def grid_picture(
    grid: GridMap, pixels: NDArray[np.uint8], longest_px: int, colours: int | None = _COLOURS
) -> Picture:
    """
    Return an image ``(H, W, 3)`` of the grid's cells, rotated to the axes of its frame.

    Unknown cells and pixels outside the grid are transparent. ``colours`` is the size of the
    palette, too coarse for pale tints; None for all colours.
    """
    corners = corners_xy(grid)
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = np.maximum(np.ceil((high - low) / grid.resolution - 1e-6).astype(int), 1)
    turned = _turned(grid, pixels, low, size)
    shrink = min(1.0, longest_px / size.max())
    if shrink < 1.0:
        target = tuple(max(1, round(float(side) * shrink)) for side in size)
        small = cv2.resize(turned, target, interpolation=cv2.INTER_AREA)
        turned = np.asarray(small, dtype=np.uint8)
    width, height = (float(side) for side in size * grid.resolution)
    return Picture(
        _data_uri(turned, colours), float(low[0]), float(low[1]) + height, width, height
    )


def _turned(
    grid: GridMap, pixels: NDArray[np.uint8], low: NDArray[np.float64], size: NDArray[np.int64]
) -> NDArray[np.uint8]:
    """Resample to rows from the highest y to ``low``, columns from the lowest x; RGBA."""
    opaque = np.where(grid.cells == UNKNOWN, 0, 255).astype(np.uint8)
    image = np.dstack([pixels, opaque])
    top = low[1] + size[1] * grid.resolution
    # Three target pixels (column, row) and the grid's cells below them fix the affine map.
    target = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    signs = np.array([grid.resolution, -grid.resolution])
    xy = np.array([low[0], top]) + (target + 0.5) * signs
    source = grid.xy_to_rc(xy)[:, ::-1]
    A_source_target = np.column_stack([source[1] - source[0], source[2] - source[0], source[0]])
    turned = cv2.warpAffine(
        image,
        A_source_target,
        (int(size[0]), int(size[1])),
        flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=(255, 255, 255, 0),
    )
    return np.asarray(turned, dtype=np.uint8)


def _data_uri(image: NDArray[np.uint8], colours: int | None) -> str:
    picture = Image.fromarray(image)
    if colours is not None:
        picture = picture.quantize(colours, method=Image.Quantize.FASTOCTREE)
    buffer = io.BytesIO()
    picture.save(buffer, format='PNG', optimize=True)
    return 'data:image/png;base64,' + base64.b64encode(buffer.getvalue()).decode('ascii')
