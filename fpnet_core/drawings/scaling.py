# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a drawing's scale, by the best source there is."""

from __future__ import annotations

from dataclasses import replace
import math

from fpnet_core.config import FpnetConfig, SegmentationConfig, parse_config
from fpnet_core.drawings.annotations import scale_of
from fpnet_core.drawings.pictures.hypothesis import NOMINAL_M, PlanHypothesis
from fpnet_core.drawings.room_texts import mapped, room_votes
from fpnet_core.drawings.stated import cells_per_pixel
from fpnet_core.drawings.types import DrawingScale, Reading, ScaleSource
from fpnet_core.drawings.votes import Consensus, Prior, Vote, most_likely
from fpnet_core.raster.pixels import shrinking
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import GridMap, Segmentation

_SIGMAS = 3.29  # given: standard deviations across an interval of 90 %
_EDGE_CELLS = 0.5  # numerical: a cell that a wall touches is wall
# Chosen, not measured:
_FURTHEST = 4.0  # factor by which texts may be off what doors, rooms and walls tell
_APART = 1.06  # factor between scales that contradict


def resolve_scale(found: PlanHypothesis, config: SegmentationConfig) -> tuple[DrawingScale, float]:
    """
    Return the scale of a reading's pixels, and the edge of a cell [m].

    What the user says goes before what the drawing says, and that before what doors tell. Areas
    and sizes that are printed in rooms count with the drawing's other texts; if they contradict
    these, neither is believed. Where a perspective was undone, a pixel is one in the middle of
    the building.
    """
    said = found.said.at(found.H_cell_pixel, found.cells.shape)
    if said is not None and not _is_contradicted(found, said[0]):
        return said
    grid = GridMap(found.cells[::-1], NOMINAL_M)
    segmentation, factor = segment_unknown_scale(grid, config, prior=found.prior)
    per_pixel = cells_per_pixel(found.H_cell_pixel, found.cells.shape)
    pixel_m = NOMINAL_M * per_pixel
    low, metres, high = (pixel_m * each for each in (factor.low, factor.factor, factor.high))
    told = Prior(math.log(metres), math.log(high / low) / _SIGMAS)
    agreed = _agreed(found, segmentation, told) if said is None else None
    if agreed is not None and low / _FURTHEST < agreed.resolution_m < high * _FURTHEST:
        return scale_of(agreed), agreed.resolution_m / per_pixel
    why = 'estimated from doors, rooms and walls'
    return DrawingScale(metres, low, high, ScaleSource.ESTIMATED, why), NOMINAL_M * factor.factor


def _is_contradicted(found: PlanHypothesis, said: DrawingScale) -> bool:
    """Tell whether what is printed in rooms agrees on another scale than a drawing's texts."""
    agreed = most_likely(_votes(found, found.segmentation))
    return agreed is not None and not (
        1.0 / _APART < agreed.resolution_m / said.resolution_m < _APART
    )


def _agreed(found: PlanHypothesis, segmentation: Segmentation, prior: Prior) -> Consensus | None:
    """Return what a drawing's texts agree on once its rooms are known."""
    return most_likely([*found.said.votes, *_votes(found, segmentation)], prior)


def _votes(found: PlanHypothesis, segmentation: Segmentation) -> list[Vote]:
    """Return what is printed in rooms as votes for metres per pixel of the drawing."""
    if not found.said.labels:
        return []
    step = -(-found.cells.shape[0] // segmentation.labels.shape[0])
    H = shrinking(1.0 / step) @ found.H_cell_pixel
    votes = room_votes(mapped(found.said.labels, H), segmentation.labels[::-1], _EDGE_CELLS)
    per_pixel = cells_per_pixel(found.H_cell_pixel, found.cells.shape) / step
    return [replace(vote, log_scale=vote.log_scale + math.log(per_pixel)) for vote in votes]


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
