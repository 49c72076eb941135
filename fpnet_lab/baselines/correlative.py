# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Exhaustive raster search: every rotation and scale, all translations at once by FFT.

It uses no graph and no regions. The score rewards submap walls near plan walls and penalizes
submap free space outside of the plan or on walls. Slow and thorough: a reference for the
matchers that run in milliseconds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.ndimage import distance_transform_edt

from fpnet_core.geometry import Affine2D, Placement, rotation
from fpnet_core.types import FREE, OCCUPIED, GridMap

Array = NDArray[np.float64]

PLAN_PIXELS = 150
"""Numerical: longer side of the plan's raster."""

ROTATIONS, SCALES = 90, 18  # numerical
SCALE_RANGE = (0.5, 2.0)
"""Range of plan metres per submap metre, sampled in equal ratios. Chosen."""

WALL_PIXELS = 2.0
"""Distance from a wall at which its value has decayed to 1/e. Chosen."""

ON_WALL_COST = 0.7
"""Cost of free space on a wall; free space outside of the plan costs 1. Chosen."""

SHRINK_COST = 0.12
"""Score per unit of log scale: without it tiny submaps fit everywhere. Chosen."""

_MAX_POINTS = 4000  # numerical: sampled cells of each kind of the submap


@dataclass(frozen=True, eq=False)
class _Field:
    """Spectra of the plan's wall values and costs, and the geometry of its raster."""

    walls: NDArray[np.complex128]
    costs: NDArray[np.complex128]
    shape: tuple[int, int]
    used: tuple[int, int]
    pixel_m: float
    origin: Array


def search_placement(plan: GridMap, sub: GridMap, scales: Array | None = None) -> Placement | None:
    """
    Return the best placement; None if the submap has no walls or no free space.

    Units are the metres of both maps; a score of about 1 is perfect agreement. ``scales (L,)`` are
    plan metres per submap metre; None tries all of ``SCALE_RANGE``.
    """
    walls, free = _points(sub, OCCUPIED), _points(sub, FREE)
    if not (len(walls) and len(free) and (plan.cells == OCCUPIED).any()):
        return None
    scales = np.geomspace(*SCALE_RANGE, SCALES) if scales is None else scales
    field = _plan_field(plan, sub, float(scales.max()))
    best, placed = -np.inf, None
    for scale in scales:
        for yaw in np.arange(ROTATIONS) * (2.0 * np.pi / ROTATIONS):
            linear = scale * rotation(yaw)
            score, translation = _best_translation(field, walls @ linear.T, free @ linear.T)
            score += SHRINK_COST * float(np.log(scale))
            if score > best:
                best, placed = score, Affine2D(linear, translation)
    return None if placed is None else Placement(placed, float(best))


def _points(grid: GridMap, value: int) -> Array:
    """Return up to ``_MAX_POINTS`` evenly sampled cell centres with ``value`` [m]."""
    rc = np.argwhere(grid.cells == value)
    step = max(1, len(rc) // _MAX_POINTS)
    return grid.rc_to_xy(rc[::step])


def _plan_field(plan: GridMap, sub: GridMap, largest_scale: float) -> _Field:
    """Return the plan's spectra, padded so that a submap of the largest scale cannot wrap."""
    pixel_m = max(plan.shape) * plan.resolution / PLAN_PIXELS
    known_xy = {
        value: plan.rc_to_xy(np.argwhere(plan.cells == value)) for value in (FREE, OCCUPIED)
    }
    corners = plan.rc_to_xy(
        np.array([[0, 0], [0, plan.shape[1]], [plan.shape[0], 0], [*plan.shape]])
    )
    origin = corners.min(axis=0)
    used = np.ceil(np.ptp(corners, axis=0) / pixel_m).astype(int) + 1
    diagonal_m = float(np.hypot(*sub.shape)) * sub.resolution * largest_scale
    # Shifted by more than twice the plan, a submap is outside of it with any padding.
    reach = int(min(diagonal_m / pixel_m, 2.0 * PLAN_PIXELS)) + 1
    shape = (fft.next_fast_len(int(used[0]) + reach), fft.next_fast_len(int(used[1]) + reach))
    is_wall, is_free = (np.zeros(shape, dtype=np.bool_) for _ in range(2))
    for mask, value in ((is_wall, OCCUPIED), (is_free, FREE)):
        index = ((known_xy[value] - origin) / pixel_m).astype(int)
        mask[index[:, 0], index[:, 1]] = True
    near = np.exp(-((distance_transform_edt(~is_wall) / WALL_PIXELS) ** 2))
    cost = np.where(is_wall | is_free, ON_WALL_COST * near, 1.0)
    return _Field(
        fft.rfft2(near), fft.rfft2(cost), shape, (int(used[0]), int(used[1])), pixel_m, origin
    )


def _best_translation(field: _Field, walls: Array, free: Array) -> tuple[float, Array]:
    """Return the best score and translation [m] of rotated and scaled points."""
    low = np.minimum(walls.min(axis=0), free.min(axis=0))
    spectra = (
        np.conj(_spectrum((points - low) / field.pixel_m, field.shape)) for points in (walls, free)
    )
    wall_spectrum, free_spectrum = spectra
    score = fft.irfft2(wall_spectrum * field.walls - free_spectrum * field.costs, s=field.shape)
    row, column = np.unravel_index(int(score.argmax()), field.shape)
    # Shifts in the second half are negative: the submap extends beyond the lower edge.
    shift = np.array([row, column], dtype=np.float64)
    shift = np.where(shift >= np.array(field.used), shift - np.array(field.shape), shift)
    return float(score.max()), field.origin + shift * field.pixel_m - low


def _spectrum(pixels: Array, shape: tuple[int, int]) -> NDArray[np.complex128]:
    """Return the spectrum of the points' raster; the raster sums to one."""
    index = pixels.astype(int) % np.array(shape)
    flat = np.bincount(index[:, 0] * shape[1] + index[:, 1], minlength=shape[0] * shape[1])
    spectrum: NDArray[np.complex128] = fft.rfft2(flat.reshape(shape) / len(pixels))
    return spectrum
