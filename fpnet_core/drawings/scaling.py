# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a drawing's scale, by the best source there is."""

from __future__ import annotations

import numpy as np

from fpnet_core.config import FpnetConfig, SegmentationConfig, parse_config
from fpnet_core.drawings.annotations import annotated_scale
from fpnet_core.drawings.pictures.choosing import NOMINAL_M, Found
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ReadOptions, ScaleSource
from fpnet_core.raster.pixels import growth_at, map_points
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import GridMap


def resolve_scale(
    drawing: Drawing, options: ReadOptions, found: Found, config: SegmentationConfig
) -> tuple[DrawingScale, float]:
    """
    Return the scale of the drawing's pixels, and the edge of a cell [m].

    What the user says goes before what the drawing says, and that before what doors tell. Where
    a perspective was undone, a pixel is one in the middle of the building.
    """
    cells_per_pixel = _growth(found)
    if options.resolution_m is not None:
        metres = options.resolution_m
        return _exact(metres, ScaleSource.STATED, 'stated'), metres / cells_per_pixel
    if options.length is not None:
        x1, y1, x2, y2, metres = options.length
        ends = map_points(found.H_cell_pixel, np.array([[x1, y1], [x2, y2]]))
        cell_m = metres / float(np.hypot(*(ends[1] - ends[0])))
        scale = _exact(cell_m * cells_per_pixel, ScaleSource.LENGTH, f'a length of {metres:g} m')
        return scale, cell_m
    known = drawing.scale or annotated_scale(drawing)
    if known is not None:
        return known, known.resolution_m / cells_per_pixel
    grid = GridMap(found.cells[::-1], NOMINAL_M)
    _, factor = segment_unknown_scale(grid, config)
    pixel_m = NOMINAL_M * cells_per_pixel
    low, metres, high = (pixel_m * each for each in (factor.low, factor.factor, factor.high))
    why = 'estimated from doors, rooms and walls'
    return DrawingScale(metres, low, high, ScaleSource.ESTIMATED, why), NOMINAL_M * factor.factor


def with_scale_of(reading: Reading, config: FpnetConfig) -> FpnetConfig:
    """
    Return the configuration with an unknown scale searched as one.

    Whoever has set ``localizer.scale_policy`` means it.
    """
    if reading.scale.is_known or 'scale_policy' in config.localizer.model_fields_set:
        return config
    values = config.model_dump()
    values['localizer']['scale_policy'] = 'unknown'
    return parse_config(values)


def _exact(metres: float, source: ScaleSource, why: str) -> DrawingScale:
    return DrawingScale(metres, metres, metres, source, why)


def _growth(found: Found) -> float:
    """Return how many cells are as long as a pixel, in the middle of the map."""
    middle = np.array(found.cells.shape[::-1]) / 2.0
    back = np.asarray(np.linalg.inv(found.H_cell_pixel), dtype=np.float64)
    return 1.0 / growth_at(back, middle)
