# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scale of a drawing from the best available source."""

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

_SIGMAS = 3.29  # given: width of a 90 % interval in standard deviations
_EDGE_CELLS = 0.5  # numerical: a cell that a wall touches counts as wall
# Chosen, not measured:
_FURTHEST = 4.0  # largest factor of texts beyond the interval from doors, rooms and walls
_APART = 1.06  # smallest factor between contradicting scales


def resolve_scale(found: PlanHypothesis, config: SegmentationConfig) -> tuple[DrawingScale, float]:
    """
    Return the scale of a drawing's pixels and the edge of a cell [m].

    The user's statement precedes the drawing's, and that precedes the estimate from doors, rooms
    and walls. Areas and sizes printed in rooms count with the drawing's other texts; if both
    contradict each other, neither is used. If perspective was removed, the scale is that of a
    pixel at the centre of the building.
    """
    said = found.said.at(found.H_cell_pixel, found.cells.shape)
    if said is not None and not _is_contradicted(found, said[0]):
        return said
    grid = GridMap(found.cells[::-1], NOMINAL_M)
    segmentation, factor = segment_unknown_scale(grid, config, prior=found.prior)
    per_pixel = cells_per_pixel(found.H_cell_pixel, found.cells.shape)
    pixel_m = NOMINAL_M * per_pixel
    low, metres, high = (pixel_m * each for each in (factor.low, factor.factor, factor.high))
    estimate = Prior(math.log(metres), math.log(high / low) / _SIGMAS)
    agreed = _agreed(found, segmentation, estimate) if said is None else None
    if agreed is not None and low / _FURTHEST < agreed.resolution_m < high * _FURTHEST:
        return scale_of(agreed), agreed.resolution_m / per_pixel
    why = 'estimated from doors, rooms and walls'
    return DrawingScale(metres, low, high, ScaleSource.ESTIMATED, why), NOMINAL_M * factor.factor


def _is_contradicted(found: PlanHypothesis, said: DrawingScale) -> bool:
    """Return whether the texts in rooms agree on a scale other than the stated one."""
    agreed = most_likely(_votes(found, found.segmentation))
    return agreed is not None and not (
        1.0 / _APART < agreed.resolution_m / said.resolution_m < _APART
    )


def _agreed(found: PlanHypothesis, segmentation: Segmentation, prior: Prior) -> Consensus | None:
    """Return the consensus of a drawing's texts, including those in its rooms."""
    return most_likely([*found.said.votes, *_votes(found, segmentation)], prior)


def _votes(found: PlanHypothesis, segmentation: Segmentation) -> list[Vote]:
    """Return the votes of texts in rooms for metres per pixel of the drawing."""
    if not found.said.labels:
        return []
    step = -(-found.cells.shape[0] // segmentation.labels.shape[0])
    H = shrinking(1.0 / step) @ found.H_cell_pixel
    votes = room_votes(mapped(found.said.labels, H), segmentation.labels[::-1], _EDGE_CELLS)
    per_pixel = cells_per_pixel(found.H_cell_pixel, found.cells.shape) / step
    return [replace(vote, log_scale=vote.log_scale + math.log(per_pixel)) for vote in votes]


def with_scale_of(reading: Reading, config: FpnetConfig) -> FpnetConfig:
    """
    Return the configuration with scale policy ``unknown`` if the scale is not stated.

    An explicitly set ``localizer.scale_policy`` is kept.
    """
    if reading.scale.is_known or 'scale_policy' in config.localizer.model_fields_set:
        return config
    values = config.model_dump()
    values['localizer']['scale_policy'] = 'unknown'
    return parse_config(values)
