# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Walls and free space of a raster, prepared for fast comparison.

Plan and submap use the same type, so that a candidate transform can be tested in both
directions: the robot's walls on the plan, and the plan's walls in the area that the robot
observed (see :mod:`fpnet_core.pose.verify`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_middles, thinned
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pixels import xy_to_rc
from fpnet_core.types import FREE, OCCUPIED, GridMap, RegionGraph, Segmentation

Made = TypeVar('Made')

WALL_REACH_M = 0.15
"""An observed wall has free space in front of it within a few cells. Chosen."""

_DISTANCE_CAP_M = 3.0  # numerical
_FIELD_CELL_M = 0.1  # numerical
_WALL_SPACING_M = 0.15  # numerical
_FREE_SPACING_M = 0.4  # numerical
# Chosen, not measured:
_STRAIGHT_SIGMA_M = 0.2  # width of a wall's likelihood: tolerance of drawing and observation
_STRAIGHT_WINDOW_M = 0.4  # window in which a wall must be straight
_STRONG = 0.2  # share of the largest gradient from which a wall's direction is reliable
_FLAT = 1e-6  # numerical: squared gradient below which there is no wall


@dataclass(frozen=True, eq=False)
class MapEvidence:
    """
    Walls and free space of one map, as points and as fields.

    ``walls (Pw, 2)`` and ``free (Pf, 2)`` are thinned samples [m] in the map's frame.
    ``wall_distance``, ``outside_depth`` and ``observed`` share one raster ``(H, W)`` of edge
    ``cell_m``: distance to the nearest wall [m, capped], distance to the nearest free cell
    [m, capped, 0 inside], and True where the map is known. ``is_free`` is the map's own
    raster, cells of ``resolution_m``. ``A_rc_xy (2, 3)`` maps metres to fractional (row, col).
    ``orientation`` is the dominant wall direction modulo 90 degrees [rad] and
    ``orientation_strength`` in [0, 1] how dominant it is.
    """

    walls: NDArray[np.float64]
    free: NDArray[np.float64]
    wall_distance: NDArray[np.float32]
    observed: NDArray[np.bool_]
    A_rc_xy: NDArray[np.float64]
    cell_m: float
    orientation: float
    orientation_strength: float
    is_free: NDArray[np.bool_]
    resolution_m: float

    @cached_property
    def outside_depth(self) -> NDArray[np.float32]:
        """Distance to the nearest free cell (H, W); lazy, as only plans need it."""
        step = round(self.cell_m / self.resolution_m)
        return distance_to(self.is_free, self.resolution_m, step)

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """Corners (4, 2) of the box around the walls [m], or around free space without walls."""
        points = self.walls if len(self.walls) else self.free
        if len(points) == 0:
            return np.zeros((4, 2))
        # By columns: with rows, the axis of length two would be the innermost loop.
        x, y = points.T
        return box_corners(np.array([x.min(), y.min()]), np.array([x.max(), y.max()]))

    def wall_likelihood(self, sigma_m: float) -> NDArray[np.float32]:
        """Return ``exp(-d^2 / (2 sigma_m^2))`` of the wall distance; computed once."""
        field = self._likelihoods.get(sigma_m)
        if field is None:
            field = np.exp(-0.5 * np.square(self.wall_distance / np.float32(sigma_m)))
            self._likelihoods[sigma_m] = field
        return field

    @cached_property
    def straightness(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """:meth:`straightness_at` for all cells, ``(H, W)`` each; efficient for many lookups."""
        sigma = _STRAIGHT_WINDOW_M / self.cell_m
        gx, gy = self._gradient
        return _straightness(
            *(
                np.asarray(cv2.GaussianBlur(product, (0, 0), sigma), np.float32)
                for product in (gx * gx, gy * gy, gx * gy)
            )
        )

    def straightness_at(
        self, cells: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """
        Return straightness and normal of the walls at cells ``(P,)``, flat indices of the raster.

        ``(P,)`` each: coherence in [0, 1] of the structure tensor of the walls' likelihood, and
        twice the direction of its normal in the raster's axes [rad].
        """
        sigma = _STRAIGHT_WINDOW_M / self.cell_m
        reach = round(4.0 * sigma)
        weight = cv2.getGaussianKernel(2 * reach + 1, sigma, cv2.CV_32F)
        gx, gy = (np.pad(part, reach, mode='reflect') for part in self._gradient)
        row, col = np.divmod(cells, self.observed.shape[1])
        return _straightness(*_structure_at(gx, gy, weight.astype(np.float32).ravel(), row, col))

    @cached_property
    def _gradient(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Gradient of the walls' likelihood along columns and rows, ``(H, W)`` each."""
        field = self.wall_likelihood(_STRAIGHT_SIGMA_M)
        gx, gy = cv2.Sobel(field, cv2.CV_32F, 1, 0), cv2.Sobel(field, cv2.CV_32F, 0, 1)
        return np.asarray(gx, np.float32), np.asarray(gy, np.float32)

    @cached_property
    def _likelihoods(self) -> dict[float, NDArray[np.float32]]:
        return {}

    def kept(self, make: Callable[[MapEvidence], Made]) -> Made:
        """Return ``make(self)``; computed once and cached for the lifetime of the map."""
        if make not in self._kept:
            self._kept[make] = make(self)
        found: Made = self._kept[make]
        return found

    @cached_property
    def _kept(self) -> dict[Callable[[MapEvidence], Any], Any]:
        return {}

    @property
    def wall_length_m(self) -> float:
        """Length of all walls, estimated from the thinned samples [m]."""
        return len(self.walls) * _WALL_SPACING_M

    def unseen_wall_m(self, seen_m2: float) -> float:
        """Estimate the length of walls not yet observed after ``seen_m2`` of floor [m]."""
        return self.wall_length_m * max(0.0, 1.0 - seen_m2 / max(self.free_area_m2, 1e-6))

    @property
    def free_area_m2(self) -> float:
        """Free area, estimated from the thinned samples [m^2]."""
        return len(self.free) * _FREE_SPACING_M**2


@dataclass(frozen=True, eq=False)
class PreparedMap:
    """One map as segmentation, region graph and raster evidence."""

    segmentation: Segmentation
    graph: RegionGraph
    evidence: MapEvidence

    @cached_property
    def room_of_cell(self) -> NDArray[np.int32]:
        """Room labels ``(H, W)`` on the raster of the evidence; 0 outside rooms."""
        step = round(self.evidence.cell_m / self.evidence.resolution_m)
        labels = block_middles(self.segmentation.labels, step)
        labels.setflags(write=False)  # as for step 1, so that compiled functions see one type
        return labels

    @cached_property
    def door_points(self) -> NDArray[np.float64]:
        """Centres ``(D, 2)`` of the doors' opening lines [m], in the order of the portals."""
        ends = np.array([portal.ends for portal in self.segmentation.portals], dtype=np.float64)
        return np.asarray(ends.reshape(-1, 2, 2).mean(axis=1))


def box_corners(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners (4, 2) of an axis-aligned box, given by two opposite ones (2,)."""
    return np.array([low, high, [low[0], high[1]], [high[0], low[1]]])


def map_evidence(grid: GridMap, interior: NDArray[np.bool_] | None = None) -> MapEvidence:
    """
    Return the evidence of ``grid``; its samples are empty without walls or free space.

    Parameters
    ----------
    grid : the raster
    interior : (H, W) bool
        Cells that count as free; None: the grid's free cells. Pass the rooms of a drawing on
        white paper here, so that the paper around the building is not free space.
    """
    free = (grid.cells == FREE) if interior is None else np.asarray(interior)
    near_free = grown(free, max(1, round(WALL_REACH_M / grid.resolution)))
    walls = (grid.cells == OCCUPIED) & near_free & ~free
    step = max(1, round(_FIELD_CELL_M / grid.resolution))
    orientation, strength = dominant_orientation(walls)
    yaw_grid = grid.T_frame_grid.yaw
    return MapEvidence(
        walls=grid.rc_to_xy(thinned(walls, _WALL_SPACING_M / grid.resolution)),
        free=grid.rc_to_xy(thinned(free, _FREE_SPACING_M / grid.resolution)),
        wall_distance=distance_to(walls, grid.resolution, step),
        observed=block_middles(near_free, step),
        A_rc_xy=xy_to_rc(grid, step),
        cell_m=grid.resolution * step,
        orientation=float(np.mod(orientation + yaw_grid, np.pi / 2)),
        orientation_strength=strength,
        is_free=free,
        resolution_m=grid.resolution,
    )


def distance_to(mask: NDArray[np.bool_], resolution: float, step: int) -> NDArray[np.float32]:
    """Return the distance of every ``step``-th cell to the nearest True cell [m], capped."""
    if not mask.any():
        return np.full(block_middles(mask, step).shape, _DISTANCE_CAP_M, dtype=np.float32)
    most = _DISTANCE_CAP_M / resolution + 1.0
    metres = cells_to_nearest(mask, step, most=most) * np.float32(resolution)
    return np.asarray(np.minimum(metres, np.float32(_DISTANCE_CAP_M)), dtype=np.float32)


def dominant_orientation(walls: NDArray[np.bool_]) -> tuple[float, float]:
    """
    Return the dominant wall direction modulo 90 degrees, grid axes (x = column), and its strength.

    Gradients of the blurred wall image vote with four-fold symmetry: mean of
    ``exp(4 i angle)`` weighted by gradient magnitude. Its length is 1 for a building with a single
    right-angled direction and 0 for none.
    """
    if not walls.any():
        return 0.0, 0.0
    image = cv2.GaussianBlur(walls.astype(np.float32), (0, 0), 1.5)
    re, im, total = _fourth_powers(
        np.asarray(cv2.Sobel(image, cv2.CV_32F, 1, 0), np.float32).ravel(),
        np.asarray(cv2.Sobel(image, cv2.CV_32F, 0, 1), np.float32).ravel(),
        np.float32(_STRONG**2),
    )
    angle = np.arctan2(im, re)
    return float(np.mod(angle / 4.0, np.pi / 2)), float(np.hypot(re, im) / total)


def _fourth_powers(
    gx: NDArray[np.float32], gy: NDArray[np.float32], share: np.float32
) -> tuple[float, float, float]:
    """
    Return the sums of ``|g| (g / |g|)^4``, real and imaginary part, and of ``|g|``.

    ``g`` are the gradients ``gx + i gy``, ``(P,)`` each, that exceed a share of the largest one.
    Squares are compared; OpenCV's magnitudes are rounded depending on the arrays' alignment.
    """
    squared = gx * gx + gy * gy
    is_strong = squared > share * squared.max()
    x, y = (each[is_strong].astype(np.float64) for each in (gx, gy))
    squares = x * x + y * y
    length = np.sqrt(squares)
    u, v = (x * x - y * y) / squares, 2.0 * x * y / squares
    return float(length @ (u * u - v * v)), 2.0 * float(length @ (u * v)), float(length.sum())


def _straightness(
    xx: NDArray[np.float32], yy: NDArray[np.float32], xy: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return coherence and doubled direction of structure tensors with components (...)."""
    spread = np.sqrt((xx - yy) ** 2 + 4.0 * xy**2)
    coherence = spread / (xx + yy + np.float32(_FLAT))
    return coherence, np.arctan2(2.0 * xy, xx - yy)


@njit(cache=True, nogil=True, fastmath={'reassoc', 'contract'})
def _structure_at(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    weight: NDArray[np.float32],
    row: NDArray[np.int64],
    col: NDArray[np.int64],
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """
    Return the structure tensor's components xx, yy and xy ``(P,)`` at given cells.

    ``gx`` and ``gy`` are the gradient, padded by half of ``weight (K,)``, a separable Gaussian
    window. Blurring the whole raster would take four times as long.
    """
    xx, yy, xy = np.empty((3, len(row)), np.float32)
    for k in range(len(row)):
        a = b = c = np.float32(0.0)
        for i in range(len(weight)):
            x = gx[row[k] + i, col[k] : col[k] + len(weight)]
            y = gy[row[k] + i, col[k] : col[k] + len(weight)]
            u = v = w = np.float32(0.0)
            for j in range(len(weight)):
                u += weight[j] * x[j] * x[j]
                v += weight[j] * y[j] * y[j]
                w += weight[j] * x[j] * y[j]
            a, b, c = a + weight[i] * u, b + weight[i] * v, c + weight[i] * w
        xx[k], yy[k], xy[k] = a, b, c
    return xx, yy, xy
