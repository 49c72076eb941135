# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Estimate of the unknown metric scale of a drawing or map from its doors, rooms and walls."""

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
"""A scale is certain if its 90 % interval lies within this factor of the estimate. Chosen."""

# Given: reported quantiles of a scale: the median and the 90 % interval.
_STATED = (0.05, 0.5, 0.95)
# Chosen, not measured:
# In every building about one free cell in five is farther than this from any wall [m].
_SPACIOUS_SHARE, _SPACIOUS_M = 0.2, 1.2
# Clutter: components that extend over less than this share of the map's diagonal.
_SPECK_SHARE = 0.02
# A stated scale conflicts with rooms, doors and walls if it is off by more than this at the nearer
# end of their interval.
_CONFLICT_FACTOR = 2.0
# Numerical: the iteration of scale and segmentation stops below this relative change, well below
# the sensitivity of the segmentation's thresholds, or after this many rounds.
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
        """Return whether the interval lies within ten per cent of the estimate."""
        return self.high <= self.factor * SURE_FACTOR and self.low >= self.factor / SURE_FACTOR

    @property
    def is_scale_conflict(self) -> bool:
        """Return whether rooms, doors and walls clearly contradict the stated scale."""
        return self.low > _CONFLICT_FACTOR or self.high < 1.0 / _CONFLICT_FACTOR

    def said_at(self, resolution_m: float) -> str:
        """Describe the scale that rooms, doors and walls suggest, for stated pixels [m]."""
        sizes = (each * resolution_m for each in (self.factor, self.low, self.high))
        middle, low, high = (f'{size:.3g}' for size in sizes)
        return f'its rooms, doors and walls suggest {middle} m per pixel ({low} to {high})'


STATED_SCALE = ScaleEstimate(1.0, 1.0, 1.0)
"""Numerical: the scale of a map that states its metres."""


def estimate_metres_per_unit(
    segmentation: Segmentation,
    metres_per_unit: float = 1.0,
    is_partial: bool = False,
    prior: ScalePrior | None = None,
) -> ScaleEstimate:
    """
    Return the factor from nominal to true metres, estimated from rooms, doors and walls.

    Parameters
    ----------
    segmentation : rooms and doors in nominal metres
    metres_per_unit : the factor that the segmentation was made with
    is_partial : whether it is a robot's map rather than a drawing
    prior : further prior of a nominal metre
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

    The segmentation's thresholds need a scale and the scale needs the rooms: both are iterated
    until the scale converges. The iteration starts at the ``prior``'s median; without a prior at
    the scale where one free cell in five has a clearance above about 1.2 m, as in any building.
    The regions stay in nominal metres. Fewer ``max_rounds`` are faster and enough for a preview.
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
    Return the scale that rooms, doors and walls suggest for a map of stated scale.

    Without rooms that is the stated scale. After a conflict the map is segmented again.
    """
    if not segmentation.rooms:
        return STATED_SCALE
    estimate = estimate_metres_per_unit(segmentation)
    return segment_unknown_scale(grid, config)[1] if estimate.is_scale_conflict else estimate


def segment_at(
    source: GridMap | Submap, config: SegmentationConfig, metres_per_unit: float
) -> Segmentation:
    """Segment a drawing or a robot's map at a given scale; results stay in nominal metres."""
    if isinstance(source, Submap):
        return segment_submap(source, metres_per_unit)
    return segment_floorplan(source, config, metres_per_unit)


def first_guess(source: GridMap | Submap) -> float:
    """Return the factor to true metres from the clearance, accurate to about a third."""
    grid = source.grid if isinstance(source, Submap) else source
    free = _without_specks(interior(grid.cells == FREE))
    if not free.any() or free.all():
        return 1.0
    spacious = np.quantile(clearance_m(~free, grid.resolution)[free], 1.0 - _SPACIOUS_SHARE)
    return _SPACIOUS_M / max(float(spacious), grid.resolution)


def _without_specks(free: Mask) -> Mask:
    """Return ``free (H, W)`` with obstacles filled that are small relative to the map."""
    solid = (~free).astype(np.uint8)
    _, components, stats, _ = cv2.connectedComponentsWithStats(solid, connectivity=8)
    extent = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    specks = extent < _SPECK_SHARE * np.hypot(*free.shape)
    specks[0] = False
    return np.asarray(free | specks[components])
