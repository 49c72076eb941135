# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The metric scale of a drawing, from the one length that buildings agree on: door widths."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.io.outside import interior
from fpnet_core.segmentation.floorplan import segment_floorplan
from fpnet_core.segmentation.scene import Mask, clearance_m
from fpnet_core.segmentation.submap import segment_submap
from fpnet_core.types import FREE, GridMap, Segmentation, Submap

# Standard deviation of the density over the logarithm of widths (about 8 percent of a width).
_BANDWIDTH = 0.08
# Widths are compared on this many points between the narrowest and the widest.
_GRID_POINTS = 400
# Doors at which half of the confidence that numbers can give is reached.
_DOORS_FOR_HALF = 3.0
# In every building about one free cell in five is further than this from any wall [m].
_SPACIOUS_SHARE, _SPACIOUS_M = 0.2, 1.2
# Clutter: pieces that extend over less than this share of the map's diagonal.
_SPECK_SHARE = 0.02
# By how much, in its logarithm, the scale is off that a segmentation was made with: openings of
# twice a door's width are no doors, however many there are.
_EXPECTED_SPREAD = 0.7
# The loop of scale and segmentation stops below this relative change, which is far less than the
# segmentation's thresholds notice, or after so many rounds.
_CONVERGED = 0.06
_MAX_ROUNDS = 4


@dataclass(frozen=True)
class ScaleEstimate:
    """True metres per nominal metre, and in [0, 1] how sure that is; 0 where there is no door."""

    factor: float
    confidence: float


def estimate_metres_per_unit(
    segmentation: Segmentation,
    config: SegmentationConfig | None = None,
    expected: float | None = None,
) -> ScaleEstimate:
    """
    Return the factor that makes the most frequent door width a typical one.

    Multiply nominal metres by the factor to get true ones. No door gives factor 1 with
    confidence 0. ``expected`` is the factor that the segmentation was made with: widths that
    would make it very wrong count less.
    """
    typical_m = (config or SegmentationConfig()).typical_door_width_m
    widths = np.array([portal.width_m for portal in segmentation.portals])
    if widths.size == 0:
        return ScaleEstimate(1.0, 0.0)
    mode, share = _mode(widths, None if expected is None else typical_m / expected)
    return ScaleEstimate(typical_m / mode, share * widths.size / (widths.size + _DOORS_FOR_HALF))


def _mode(widths: NDArray[np.float64], expected: float | None) -> tuple[float, float]:
    """Return the densest width, near the expected one, and the share of widths around it."""
    logs = np.log(widths)
    at = np.linspace(logs.min(), logs.max(), _GRID_POINTS)
    weight = np.exp(-0.5 * ((at[:, None] - logs) / _BANDWIDTH) ** 2)
    density = weight.sum(axis=1)
    if expected is not None:
        density *= np.exp(-0.5 * ((at - np.log(expected)) / _EXPECTED_SPREAD) ** 2)
    best = float(at[int(np.argmax(density))])
    return float(np.exp(best)), float(np.mean(np.abs(logs - best) < 2.0 * _BANDWIDTH))


def segment_unknown_scale(
    source: GridMap | Submap, config: SegmentationConfig, max_rounds: int = _MAX_ROUNDS
) -> tuple[Segmentation, ScaleEstimate]:
    """
    Segment a drawing or a map whose scale is unknown, and estimate that scale.

    The segmentation's thresholds need a scale and the scale needs its doors: both are repeated
    until the scale stays. The first guess comes from the clearance, of which one cell in five
    has more than about 1.2 m in any building. The regions stay in nominal metres. Fewer
    ``max_rounds`` are faster and do for a look.
    """
    factor = _first_guess(source)
    segmentation = _segment(source, config, factor)
    estimate = estimate_metres_per_unit(segmentation, config, factor)
    for _ in range(max_rounds - 1):
        if estimate.confidence == 0.0 or abs(estimate.factor / factor - 1.0) < _CONVERGED:
            break
        factor = estimate.factor
        segmentation = _segment(source, config, factor)
        estimate = estimate_metres_per_unit(segmentation, config, factor)
    return segmentation, estimate


def _first_guess(source: GridMap | Submap) -> float:
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


def _segment(source: GridMap | Submap, config: SegmentationConfig, factor: float) -> Segmentation:
    if isinstance(source, Submap):
        return segment_submap(source, config, factor)
    return segment_floorplan(source, config, factor)
