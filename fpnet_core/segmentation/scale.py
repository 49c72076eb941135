# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The metric scale of a drawing or a map that nobody has stated: doors, rooms and walls tell."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from fpnet_core.config import SegmentationConfig
from fpnet_core.io.outside import interior
from fpnet_core.raster.morphology import Mask
from fpnet_core.segmentation.floorplan import segment_floorplan
from fpnet_core.segmentation.scale_figures import scale_figures
from fpnet_core.segmentation.scale_model import (
    ScalePrior,
    Side,
    packaged_scale_model,
    pooled,
    quantiles,
)
from fpnet_core.segmentation.scene import clearance_m
from fpnet_core.segmentation.submap import segment_submap
from fpnet_core.types import FREE, GridMap, Segmentation, Submap

SURE_FACTOR = 1.1
"""
A scale is sure whose 90 % interval ends within this factor of the estimate, on both sides. Chosen.
"""

# Chosen, not measured:
# What is stated of a scale: its median, and the interval that holds it with 90 %.
_STATED = (0.05, 0.5, 0.95)
# In every building about one free cell in five is further than this from any wall [m].
_SPACIOUS_SHARE, _SPACIOUS_M = 0.2, 1.2
# Clutter: pieces that extend over less than this share of the map's diagonal.
_SPECK_SHARE = 0.02
# A stated scale that is off by more, at either end of the interval that rooms, doors and walls
# tell, is a slip of the pen.
_MISSTATED = 2.0
# Numerical: the loop of scale and segmentation stops below this relative change, which is far less
# than the segmentation's thresholds notice, or after so many rounds.
_CONVERGED = 0.1
_MAX_ROUNDS = 3  # numerical


@dataclass(frozen=True)
class ScaleEstimate:
    """True metres per nominal metre: the median, and the 90 % interval ``low`` to ``high``."""

    factor: float
    low: float
    high: float

    @property
    def is_sure(self) -> bool:
        """Tell whether the interval lies within ten per cent of the estimate."""
        return self.high <= self.factor * SURE_FACTOR and self.low >= self.factor / SURE_FACTOR

    @property
    def is_scale_conflict(self) -> bool:
        """Tell whether rooms, doors and walls are beyond doubt those of another scale."""
        return self.low > _MISSTATED or self.high < 1.0 / _MISSTATED

    def said_at(self, resolution_m: float) -> str:
        """Return in words what rooms, doors and walls tell of pixels that were to be so large."""
        sizes = (each * resolution_m for each in (self.factor, self.low, self.high))
        middle, low, high = (f'{size:.3g}' for size in sizes)
        return (
            f'its rooms, doors and walls are those of a building at {middle} m per pixel '
            f'({low} to {high})'
        )


STATED_SCALE = ScaleEstimate(1.0, 1.0, 1.0)
"""Numerical: what is known of a map that states its metres."""


def estimate_metres_per_unit(
    segmentation: Segmentation,
    metres_per_unit: float = 1.0,
    is_partial: bool = False,
    prior: ScalePrior | None = None,
) -> ScaleEstimate:
    """
    Return the factor that makes nominal metres true ones, as far as rooms, doors and walls tell.

    Parameters
    ----------
    segmentation : rooms and doors in nominal metres
    metres_per_unit : the factor that the segmentation was made with
    is_partial : it is a robot's map, not a drawing
    prior : what else is known of a nominal metre
    """
    side: Side = 'map' if is_partial else 'plan'
    figures = scale_figures(segmentation, metres_per_unit)
    posterior = packaged_scale_model().posterior(figures, side)
    if prior is not None:
        posterior = pooled(posterior, prior, metres_per_unit)
    low, median, high = metres_per_unit * np.exp(quantiles(posterior, _STATED))
    return ScaleEstimate(float(median), float(low), float(high))


def segment_unknown_scale(
    source: GridMap | Submap,
    config: SegmentationConfig,
    max_rounds: int = _MAX_ROUNDS,
    prior: ScalePrior | None = None,
) -> tuple[Segmentation, ScaleEstimate]:
    """
    Segment a drawing or a map whose scale is unknown, and estimate that scale.

    The segmentation's thresholds need a scale and the scale needs its rooms: both are repeated
    until the scale stays. The first guess is what a ``prior`` tells of a nominal metre, or comes
    from the clearance, of which one cell in five has more than about 1.2 m in any building. The
    regions stay in nominal metres. Fewer ``max_rounds`` are faster and do for a look.
    """
    factor = first_guess(source) if prior is None else prior.median
    for number in range(max_rounds):
        segmentation = segment_at(source, config, factor)
        is_partial = isinstance(source, Submap)
        estimate = estimate_metres_per_unit(segmentation, factor, is_partial, prior)
        if abs(np.log(estimate.factor / factor)) < _CONVERGED or number == max_rounds - 1:
            break
        factor = estimate.factor
    return segmentation, estimate


def told_scale(
    grid: GridMap, segmentation: Segmentation, config: SegmentationConfig
) -> ScaleEstimate:
    """
    Return what rooms, doors and walls say of a stated scale; nothing where there are none.

    Rooms that were cut at a scale that is far off say little of the true one.
    """
    if not segmentation.rooms:
        return STATED_SCALE
    told = estimate_metres_per_unit(segmentation)
    return segment_unknown_scale(grid, config)[1] if told.is_scale_conflict else told


def segment_at(
    source: GridMap | Submap, config: SegmentationConfig, metres_per_unit: float
) -> Segmentation:
    """Segment a drawing or a robot's map whose nominal metres are so many true ones."""
    if isinstance(source, Submap):
        return segment_submap(source, metres_per_unit)
    return segment_floorplan(source, config, metres_per_unit)


def first_guess(source: GridMap | Submap) -> float:
    """Return the factor to true metres that the clearance suggests, by about a third."""
    grid = source.grid if isinstance(source, Submap) else source
    free = _without_specks(interior(grid.cells == FREE))
    if not free.any() or free.all():
        return 1.0
    spacious = np.quantile(clearance_m(~free, grid.resolution)[free], 1.0 - _SPACIOUS_SHARE)
    return _SPACIOUS_M / max(float(spacious), grid.resolution)


def _without_specks(free: Mask) -> Mask:
    """Return ``free (H, W)`` with what stands in it filled, if that is small beside the map."""
    solid = (~free).astype(np.uint8)
    _, components, stats, _ = cv2.connectedComponentsWithStats(solid, connectivity=8)
    extent = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    specks = extent < _SPECK_SHARE * np.hypot(*free.shape)
    specks[0] = False
    return np.asarray(free | specks[components])
