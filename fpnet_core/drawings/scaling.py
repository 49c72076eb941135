# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a drawing's scale, by the best source there is."""

from __future__ import annotations

from fpnet_core.config import FpnetConfig, SegmentationConfig, parse_config
from fpnet_core.drawings.pictures.found import NOMINAL_M, Found
from fpnet_core.drawings.stated import cells_per_pixel
from fpnet_core.drawings.types import DrawingScale, Reading, ScaleSource
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import GridMap


def resolve_scale(found: Found, config: SegmentationConfig) -> tuple[DrawingScale, float]:
    """
    Return the scale of a reading's pixels, and the edge of a cell [m].

    What the user says goes before what the drawing says, and that before what doors tell. Where
    a perspective was undone, a pixel is one in the middle of the building.
    """
    said = found.said.at(found.H_cell_pixel, found.cells.shape)
    if said is not None:
        return said
    grid = GridMap(found.cells[::-1], NOMINAL_M)
    _, factor = segment_unknown_scale(grid, config)
    pixel_m = NOMINAL_M * cells_per_pixel(found.H_cell_pixel, found.cells.shape)
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
