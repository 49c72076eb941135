# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scale features of a map: lengths of rooms and doors that are similar in all buildings.

Doors are the most informative, but they are wide in hospitals, narrow in homes, and missing where
a drawing shows them closed. Rooms, corridors and walls inform the scale without doors, and
contradict supposed doors that are cupboards or gates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import Mask, is_peak
from fpnet_core.segmentation.furniture import free_standing
from fpnet_core.types import FREE, Segmentation

Array = NDArray[np.float64]

LENGTHS = (
    'door_mode', 'door_10', 'door_25', 'door_50', 'door_75',
    'side_25', 'side_50', 'side_75',
    'width_25', 'width_50', 'width_75',
    'corridor_50',
    'wall_25', 'wall_50', 'wall_75',
    'clear_10', 'clear_25', 'clear_50', 'clear_90',
)  # fmt: skip
"""
Logarithms of lengths over the reference length: the most frequent door width, and percentiles of
door widths, square roots of room areas, widths of rooms, corridors and walls, and distances from
free cells to the nearest cell that is not free.
"""

COUNTS = ('door_agreement', 'log_doors', 'log_rooms', 'log_corridors', 'has_walls')
"""Share of doors near the most frequent width, and how much there was to measure."""

FIGURES = (*LENGTHS, *COUNTS)

# Numerical:
# A room whose area exceeds this many squares of its width is a corridor.
_CORRIDOR_ASPECT = 3.0
# Thinner drawn walls are lines; their width is not the wall's [cells].
_LINE_CELLS = 2.5
# Thicker parts are unknown space between rooms, not walls [m].
_THICKEST_WALL_M = 1.0
# Walls with fewer cells along their middle lines are not measured.
_LEAST_WALL_CELLS = 32
# Number of evenly sampled free cells for the clearance percentiles.
_CLEARANCES = 20_000
# Standard deviation of the density over the logarithm of door widths.
_BANDWIDTH = 0.08
# The most frequent width is sought near a typical door width; the percentiles cover others.
_DOOR_M, _DOOR_SPREAD = 0.95, 0.6


@dataclass(frozen=True, eq=False)
class ScaleFigures:
    """
    Scale features of a segmented map.

    ``values (D,)`` as in :data:`FIGURES`, NaN where there was nothing to measure. ``reference`` is
    the logarithm of the reference length, in the assumed metres: the 75th percentile of the
    distances from free cells to the nearest cell that is not free. It is None if no cell is free,
    or all are.
    """

    values: Array
    reference: float | None


def scale_figures(segmentation: Segmentation, metres_per_unit: float = 1.0) -> ScaleFigures:
    """
    Measure the scale features of a segmented map.

    Parameters
    ----------
    segmentation : rooms and doors in nominal metres
    metres_per_unit : factor from nominal to true metres that the segmentation used
    """
    cell_m = segmentation.grid.resolution * metres_per_unit
    free = (segmentation.grid.cells == FREE) | (segmentation.labels > 0)
    # Rooms exclude possible pieces of wall between doorways; dirt and chairs can look like one.
    free |= free_standing(free, cell_m)
    if not free.any() or free.all():
        return ScaleFigures(np.full(len(FIGURES), np.nan), None)
    clearance = np.maximum(cells_to_nearest(~free) - 0.5, 0.5) * cell_m
    areas = np.array([room.area_m2 for room in segmentation.rooms]) * metres_per_unit**2
    widths = _widths(segmentation, clearance)
    is_corridor = areas > _CORRIDOR_ASPECT * widths**2
    doors = np.log([max(p.width_m * metres_per_unit, cell_m) for p in segmentation.portals])
    walls = _walls(free, cell_m)
    mode, agreement = _mode(doors)
    sample = clearance[free]
    sample = sample[:: max(1, len(sample) // _CLEARANCES)]
    *clear, reference, most = np.log(np.quantile(sample, [0.1, 0.25, 0.5, 0.75, 0.9]))
    lengths = [
        np.array([mode]),
        _percentiles(doors, 10, 25, 50, 75),
        _percentiles(0.5 * np.log(areas), 25, 50, 75),
        _percentiles(np.log(widths[~is_corridor]), 25, 50, 75),
        _percentiles(np.log(widths[is_corridor]), 50),
        _percentiles(np.log(walls), 25, 50, 75),
        np.array([*clear, most]),
    ]
    many = np.log1p([len(doors), len(areas), is_corridor.sum()])
    counts = [agreement, *many, float(len(walls) > 0)]
    values = np.concatenate([np.concatenate(lengths) - reference, counts])
    return ScaleFigures(values, float(reference))


def _widths(segmentation: Segmentation, clearance: NDArray[np.float32]) -> Array:
    """Return the diameter of the largest disc in each room."""
    radii = np.full(len(segmentation.rooms) + 1, clearance.min(), dtype=np.float32)
    inside = segmentation.labels > 0
    np.maximum.at(radii, segmentation.labels[inside], clearance[inside])
    return 2.0 * radii[1:].astype(np.float64)


def _walls(free: Mask, cell_m: float) -> Array:
    """Return wall thicknesses along the walls' middle lines; empty if there are too few cells."""
    depth = cells_to_nearest(free)
    middle = (depth > 0.0) & is_peak(depth, 3)
    # A wall of an even number of cells has two middle lines, each half a cell off.
    thick = 2.0 * depth[middle].astype(np.float64) - 0.5
    thick = cell_m * thick[(thick > _LINE_CELLS) & (thick * cell_m < _THICKEST_WALL_M)]
    return thick if len(thick) >= _LEAST_WALL_CELLS else thick[:0]


def _mode(logs: Array) -> tuple[float, float]:
    """Return the densest logarithm of a door width, and the share of doors around it."""
    if not len(logs):
        return float('nan'), 0.0
    near = np.exp(-0.5 * ((logs[:, None] - logs) / _BANDWIDTH) ** 2).sum(axis=1)
    near *= np.exp(-0.5 * ((logs - np.log(_DOOR_M)) / _DOOR_SPREAD) ** 2)
    best = int(near.argmax())
    return float(logs[best]), float(near[best] / len(logs))


def _percentiles(values: Array, *at: int) -> Array:
    return np.percentile(values, at) if len(values) else np.full(len(at), np.nan)
