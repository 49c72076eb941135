# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Best placement of a robot map's walls on those of a plan, among all shifts.

Doors and corners propose a placement only if some were found; walls need none. On a raster with
cells of a metre, rotated so that most walls run along its axes, their correlation at every shift
is one Fourier transform for each scale and each of four orientations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from fpnet_core.geometry import Placements, rotation
from fpnet_core.raster.windows import cells_of
from fpnet_core.types import OCCUPIED, UNKNOWN, GridMap

# Chosen, not measured:
_CELL_M = 1.0  # walls a metre apart are distinguished
_BLUR_M = 0.6  # position error of walls: drawings are stretched, and scales are tried in steps
# Numerical:
_MARGIN = 1.25  # raster size over plan size, so that less of the robot map wraps around
_ROUNDED = 32  # raster sizes are multiples of this, so that many plans share one
_KEPT = 8  # raster sizes for which the robot map's spectra are cached: some megabytes each

Array = NDArray[np.float64]
_Spectra = NDArray[np.complex64]


@dataclass(frozen=True, eq=False)
class _Upright:
    """
    A map on cells of a metre, aligned with its walls: masks ``known`` and ``walls``, ``(H, W)``.

    ``low (2,)`` [m] is the outer corner of the first cell in rotated coordinates.
    """

    low: Array
    known: NDArray[np.bool_]
    walls: NDArray[np.bool_]

    @classmethod
    def of(cls, grid: GridMap, direction: float, factor: float = 1.0) -> _Upright:
        """Rotate a coarse raster by -``direction`` [rad] and scale it by ``factor``."""
        linear = factor * rotation(-direction)
        rows, cols = grid.shape
        ends = [[0, 0], [rows - 1, 0], [0, cols - 1], [rows - 1, cols - 1]]
        placed = grid.rc_to_xy(np.array(ends)) @ linear.T
        low = placed.min(axis=0) - _CELL_M / 2.0
        size = np.floor((placed.max(axis=0) - low) / _CELL_M).astype(np.int64) + 1
        steps = np.diff(grid.rc_to_xy(np.array([[0, 0], [1, 0], [0, 1]])), axis=0)
        down, right = steps[0], steps[0] + steps[1]
        planes = np.zeros((2, size[1], size[0]), np.bool_)
        A = np.column_stack([linear @ down, linear @ right, placed[0] - low]) / _CELL_M
        _spread(grid.cells, A, planes)
        return cls(low, planes[0], planes[1])

    def quarter(self, count: int) -> _Upright:
        """Return it rotated by ``count`` right angles, counter-clockwise."""
        size = _CELL_M * np.array(self.known.shape[::-1])
        ends = np.array([self.low, self.low + size]) @ np.rint(rotation(count * np.pi / 2.0)).T
        known, walls = (np.rot90(plane, -count) for plane in (self.known, self.walls))
        return _Upright(ends.min(axis=0), known, walls)


def _spread(cells: NDArray[np.int8], A: Array, planes: NDArray[np.bool_]) -> None:
    """Mark coarse cells with known cells, and with walls; ``A (2, 3)`` maps (r, c, 1) to x, y."""
    for plane, mask in zip(planes, (cells != UNKNOWN, cells == OCCUPIED), strict=True):
        r, c = cells_of(mask).T
        x, y = (each[0] * r + each[1] * c + each[2] for each in A)
        plane[y.astype(np.int64), x.astype(np.int64)] = True


@dataclass(frozen=True, eq=False)
class Shifts:
    """
    A robot map, a coarse raster whose walls run in ``direction`` [rad], at ``S`` scales.

    It is placed on plans at every shift, in four orientations.
    """

    walls: GridMap
    direction: float
    factors: Sequence[float]

    def best(self, plan: GridMap, direction: float) -> Placements:
        """
        Return the best placement on a plan at each of ``S`` scales, with scores of at most 1.

        The score is the correlation of its walls with the plan's blurred ones, minus the share of
        its floor outside the plan. The plan's walls run in ``direction`` [rad].
        """
        own = _Upright.of(plan, direction)
        shape = _raster(own.known.shape)
        walls, known = _plan_spectra(own, shape)
        seen_walls, seen_floor = self._spectra(shape)
        product = walls * seen_walls + known * seen_floor
        fits = fft.irfft2(product, shape).reshape(len(product), -1)
        places = fits.argmax(axis=1)
        found = fits[np.arange(len(fits)), places].reshape(len(self.factors), 4)
        quarter = found.argmax(axis=1)
        scale = np.arange(len(quarter))
        rc = np.column_stack(np.divmod(places.reshape(-1, 4)[scale, quarter], shape[1]))
        # Shifts beyond the plan's size are negative shifts that wrapped around.
        rc -= np.where(rc > own.known.shape, shape, 0)
        linear, offset = [], []
        for index, (factor, count) in enumerate(zip(self.factors, quarter, strict=True)):
            linear.append(factor * rotation(direction + count * np.pi / 2.0 - self.direction))
            start = self._turned[index][count].low
            offset.append(rotation(direction) @ (own.low - start + rc[index, ::-1] * _CELL_M))
        fits = found[scale, quarter] - 1.0
        return Placements(np.array(linear), np.array(offset), fits)

    @cached_property
    def _turned(self) -> list[list[_Upright]]:
        """Four orientations per scale."""
        upright = (_Upright.of(self.walls, self.direction, each) for each in self.factors)
        return [[each.quarter(count) for count in range(4)] for each in upright]

    def _spectra(self, shape: tuple[int, int]) -> tuple[_Spectra, _Spectra]:
        """Return the spectra of walls and floor at all scales and orientations, on a raster."""
        if shape not in self._made:
            if len(self._made) == _KEPT:
                del self._made[next(iter(self._made))]
            planes = [_planes(each, shape) for four in self._turned for each in four]
            walls, floor = np.array(planes, np.float32).swapaxes(0, 1)
            self._made[shape] = fft.rfft2(walls).conj(), fft.rfft2(floor).conj()
        return self._made[shape]

    @cached_property
    def _made(self) -> dict[tuple[int, int], tuple[_Spectra, _Spectra]]:
        return {}


def _raster(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the raster size for the shape of a plan."""
    rows, cols = (_ROUNDED * -(-int(_MARGIN * side + 2) // _ROUNDED) for side in shape)
    return rows, cols


def _planes(seen: _Upright, shape: tuple[int, int]) -> NDArray[np.float32]:
    """Return weights (2, H, W) whose sums over a plan are wall correlation and floor inside."""
    is_wall = seen.walls[seen.known]
    floor = seen.known & ~seen.walls
    weight = (seen.walls - is_wall.mean()) / (is_wall.std() + 1e-6) / len(is_wall)
    planes = np.array([weight * seen.known, floor / max(int(floor.sum()), 1)], np.float32)
    # Parts beyond the raster, e.g. from rays through windows, wrap around.
    (rows, cols), (high, wide) = seen.known.shape, shape
    whole = np.pad(planes, ((0, 0), (0, -rows % high), (0, -cols % wide)))
    folded = whole.reshape(2, -(-rows // high), high, -(-cols // wide), wide)
    return np.asarray(folded.sum(axis=(1, 3)), np.float32)


def _plan_spectra(plan: _Upright, shape: tuple[int, int]) -> _Spectra:
    """Return the spectra (2, H, W / 2 + 1) of a plan's walls, with unit variance, and floor."""
    rows, cols = plan.known.shape
    planes = np.zeros((2, *shape), np.float32)
    planes[0, :rows, :cols], planes[1, :rows, :cols] = plan.walls, plan.known
    walls = cv2.GaussianBlur(planes[0], (0, 0), _BLUR_M / _CELL_M)
    spread = walls[:rows, :cols][plan.known].std()
    planes[0] = walls / max(float(spread), 1e-6)
    planes[1] = cv2.dilate(planes[1], np.ones((3, 3), np.uint8))
    return np.asarray(fft.rfft2(planes), np.complex64)
