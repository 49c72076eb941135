# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Differences between a drawing and the building, applied to the drawing's raster.

Drawings have another origin, global and local stretch, deformation, another resolution and wall
thickness; they may be partial, or older or newer than the building. Drawing styles are in
:mod:`fpnet_lab.sim.drawn.styles`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.warping import warping_of
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.sim.config import BuildingConfig
from fpnet_lab.sim.drawn.render import MARGIN_M, fill_polygons
from fpnet_lab.sim.drawn.walls import draw_wall_changes
from fpnet_lab.sim.types import BuildingPlan, ring_of

Array = NDArray[np.float64]
Field = Callable[[Array], Array]
Cells = NDArray[np.int8]

# Chosen, not measured: minimum interpolated wall share of a wall cell, below one half, so that
# one-cell lines stay closed at any angle.
_WARPED_WALL_SHARE = 0.4

# Chosen, not measured:
_LARGEST_SHIFT_M = 20.0
_ALL_WALLS = BuildingConfig(moved_walls=1.0, removed_walls=1.0, added_walls=1.0, glass=(0.0, 0.0))
_THICKENED, _THINNED = 0.2, 0.2  # shares of drawings with thicker and thinner walls

# Chosen to span from nearly exact to the worst real drawings of the development split (1 m along a
# corridor); sampled uniformly:
_AMPLITUDE_M = (0.05, 0.5)  # standard deviation of one step of a distortion
_AXIS_SHARE, _AXIS_STEP_M = 0.7, (4.0, 12.0)  # piecewise stretch along x and y
_BEND_SHARE, _BEND_STEP_M = 0.7, (6.0, 20.0)  # smooth deformation
_TREND = (0.3, 1.0)  # share of the overall stretch that is removed again
_ERASED, _ERASED_M = 2.0, (0.25, 4.0)  # mean number of erased rectangles, and their sides
_WALL_SHARE, _FREE_SHARE = 0.35, 0.5  # minimum shares of a cell; thin walls must stay closed
_ITERATIONS = 8  # numerical: fixed-point iterations of a distortion's inverse
_FITTED_EVERY = 20  # numerical: subsampling of the free cells in the affine fit
_STRIDE = 8  # numerical: cells between samples of a smooth distortion

# Chosen to span from a few stains to a very dirty scan; sampled log-uniformly:
_LITTER_PER_M2 = (0.2, 4.0)
_LEAST_LITTER_M, _MOST_LITTER_M = 0.04, (0.1, 0.5)  # sides of the smallest and the largest piece


@dataclass(frozen=True, eq=False)
class DrawnPlan:
    """A plan's raster; ``A_plan_building`` maps true metres to nominal metres."""

    grid: GridMap
    A_plan_building: Affine2D


def laid_elsewhere(
    sheet: GridMap, A_sheet_building: Affine2D, rng: np.random.Generator
) -> DrawnPlan:
    """Return a drawing with a random origin and rotation."""
    x, y = rng.uniform(-_LARGEST_SHIFT_M, _LARGEST_SHIFT_M, size=2)
    T_plan_sheet = SE2.from_xy_yaw(x, y, float(rng.uniform(-np.pi, np.pi)))
    grid = replace(sheet, T_frame_grid=T_plan_sheet @ sheet.T_frame_grid)
    return DrawnPlan(grid, T_plan_sheet @ A_sheet_building)


def littered(grid: GridMap, rng: np.random.Generator) -> GridMap:
    """Return a drawing with stains and small marks scattered over its floor."""
    cells, cell_m = grid.cells.copy(), grid.resolution
    free = np.argwhere(cells == FREE)
    per_m2 = float(np.exp(rng.uniform(*np.log(_LITTER_PER_M2))))
    most_m = float(rng.uniform(*_MOST_LITTER_M))
    count = int(per_m2 * len(free) * cell_m**2)
    for row, col in free[rng.integers(len(free), size=count)].tolist():
        sides = np.rint(rng.uniform(_LEAST_LITTER_M, most_m, 2) / cell_m)
        rows, cols = np.maximum(1, sides).astype(int).tolist()
        piece = cells[row : row + rows, col : col + cols]
        piece[piece == FREE] = OCCUPIED
    return replace(grid, cells=cells)


def renovated(
    sheet: GridMap, plan: BuildingPlan, A_plan_building: Affine2D, rng: np.random.Generator
) -> GridMap:
    """Return a drawing with walls removed and added; the building is unchanged."""
    changes = draw_wall_changes(plan, rng, _ALL_WALLS)
    cells = sheet.cells.copy()
    for walls, value in ((changes.removed, FREE), (changes.added, OCCUPIED)):
        rings = [ring_of(wall) for wall in walls]
        rings_px = [sheet.xy_to_rc(A_plan_building.apply(r))[:, ::-1] + 0.5 for r in rings]
        fill_polygons(cells, rings_px, value, keep_thin=True)
    return replace(sheet, cells=cells)


def cut_map(grid: GridMap, ring: NDArray[np.float64]) -> GridMap:
    """Return ``grid`` with all cells outside of a convex polygon ``ring (V, 2)`` unknown."""
    inside = np.zeros(grid.shape, dtype=np.uint8)
    corners = np.rint(grid.xy_to_rc(ring)[:, ::-1]).astype(np.int32)
    cv2.fillConvexPoly(inside, corners, 1)
    return replace(grid, cells=np.where(inside > 0, grid.cells, UNKNOWN))


def warp_map(grid: GridMap, A_plan_building: Affine2D) -> GridMap:
    """
    Transform ``grid`` from frame ``building`` to ``plan``, with the same cell size.

    Walls stay closed; cells outside of ``grid`` are unknown.
    """
    pose, size, back = warping_of(grid, A_plan_building, MARGIN_M)

    def warped(values: NDArray[np.generic], flags: int, outside: float) -> NDArray[np.float32]:
        image = cv2.warpAffine(
            values.astype(np.float32),
            back.matrix[:2],
            size,
            flags=flags | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=outside,
        )
        return np.asarray(image, dtype=np.float32)

    wall = warped(grid.cells == OCCUPIED, cv2.INTER_LINEAR, 0.0) > _WARPED_WALL_SHARE
    nearest = warped(grid.cells, cv2.INTER_NEAREST, float(UNKNOWN))
    cells = np.where(wall, OCCUPIED, np.where(nearest == OCCUPIED, UNKNOWN, nearest))
    return GridMap(cells.astype(np.int8), grid.resolution, pose, 'plan')


def redrawn(grid: GridMap, cell_m: float) -> GridMap:
    """Return a drawing resampled to another cell size [m]."""
    rows, cols = (max(1, round(size * grid.resolution / cell_m)) for size in grid.shape)
    how = cv2.INTER_AREA if cell_m > grid.resolution else cv2.INTER_LINEAR

    def sampled(mask: NDArray[np.float32]) -> cv2.typing.MatLike:
        return cv2.resize(mask, (cols, rows), interpolation=how)

    cells = _resampled(grid, sampled)
    return replace(grid, cells=cells, resolution=grid.resolution * grid.shape[0] / rows)


def rewalled(grid: GridMap, rng: np.random.Generator) -> GridMap:
    """Return a drawing, sometimes with walls one cell thicker or thinner, but never open."""
    kind, cells = rng.random(), np.array(grid.cells)
    wall = cells == OCCUPIED
    if kind < _THICKENED:
        cells[grown(wall, 1)] = OCCUPIED
    elif kind < _THICKENED + _THINNED:
        depth = cells_to_nearest(~wall)
        cells[wall & (depth <= 1.0) & grown(depth > 1.5, 1) & grown(cells == FREE, 1)] = FREE
    return replace(grid, cells=cells)


@dataclass(frozen=True, eq=False)
class RoughDrawing:
    """A drawing, and its map from positions ``xy (P, 2)`` [m] in the undistorted drawing."""

    grid: GridMap
    displaced: Field

    def fitted(self) -> Affine2D:
        """Return the least-squares affine approximation of ``displaced`` on the free cells."""
        xy = self.grid.rc_to_xy(np.argwhere(self.grid.cells == FREE)[::_FITTED_EVERY])
        ones = np.ones((len(xy), 1))
        found = np.linalg.lstsq(np.hstack([xy, ones]), self.displaced(xy), rcond=None)[0]
        return Affine2D(np.asarray(found[:2].T, float), np.asarray(found[2], float))


def rough_drawing(grid: GridMap, rng: np.random.Generator) -> RoughDrawing:
    """Return a drawing with local errors: piecewise stretch, deformation, missing walls."""
    size_m = np.array(grid.shape[::-1]) * grid.resolution
    amplitude = float(rng.uniform(*_AMPLITUDE_M))
    fields: list[Field] = []
    if rng.random() < _AXIS_SHARE:
        fields.append(_stretched(size_m, float(rng.uniform(*_AXIS_STEP_M)), amplitude, rng))
    if rng.random() < _BEND_SHARE:
        fields.append(_bent(size_m, float(rng.uniform(*_BEND_STEP_M)), amplitude, rng))

    def shift(in_grid: Array) -> Array:
        return np.asarray(sum((field(in_grid) for field in fields), np.zeros_like(in_grid)))

    cells = _warped(grid, shift)
    _erase(cells, grid.resolution, rng)
    T = grid.T_frame_grid

    def displaced(xy: Array) -> Array:
        in_grid = T.inv().apply(xy)
        return T.apply(in_grid + shift(in_grid))

    return RoughDrawing(replace(grid, cells=cells), displaced)


def _stretched(size_m: Array, step_m: float, sigma_m: float, rng: np.random.Generator) -> Field:
    """Return a piecewise stretch along both axes."""
    knots, values = [], []
    for length in size_m:
        at = np.arange(-step_m, length + 2.0 * step_m, step_m)
        walk = np.cumsum(rng.normal(0.0, sigma_m, len(at)))
        trend = np.polyval(np.polyfit(at, walk, 1), at)
        knots.append(at)
        values.append(walk - rng.uniform(*_TREND) * trend)
    return lambda xy: np.column_stack(
        [np.interp(xy[:, axis], knots[axis], values[axis]) for axis in range(2)]
    )


def _bent(size_m: Array, step_m: float, sigma_m: float, rng: np.random.Generator) -> Field:
    """Return a smooth deformation in both directions."""
    columns, rows = (size_m / step_m).astype(int) + 4
    values = rng.normal(0.0, sigma_m, (2, rows, columns))

    def field(xy: Array) -> Array:
        at = xy[:, ::-1].T / step_m + 1.0
        return np.column_stack([map_coordinates(v, at, order=3, mode='nearest') for v in values])

    return field


def _warped(grid: GridMap, shift: Field) -> Cells:
    """Return the cells after a displacement by ``shift`` [m, grid axes]."""
    rows, cols = grid.shape
    x, y = np.meshgrid(
        np.arange(0, cols + _STRIDE, _STRIDE), np.arange(0, rows + _STRIDE, _STRIDE)
    )
    corners = np.column_stack([x.ravel(), y.ravel()])
    target = np.asarray(corners * grid.resolution, dtype=np.float64)
    source = target.copy()
    for _ in range(_ITERATIONS):
        source = target - shift(source)
    coarse = (source / grid.resolution).reshape(*x.shape, 2).astype(np.float32)
    # Samples are at multiples of the stride; unlike resize, this keeps them in place.
    keep = np.array([[_STRIDE, 0.0, 0.0], [0.0, _STRIDE, 0.0]])
    back = [
        cv2.warpAffine(coarse[..., axis], keep, (cols, rows), flags=cv2.INTER_LINEAR)
        for axis in range(2)
    ]

    return _resampled(grid, lambda mask: cv2.remap(mask, back[0], back[1], cv2.INTER_LINEAR))


def _resampled(
    grid: GridMap, sampled: Callable[[NDArray[np.float32]], cv2.typing.MatLike]
) -> Cells:
    """Return cells classified by their resampled shares of floor and wall."""
    floor, wall = (
        np.asarray(sampled((grid.cells == value).astype(np.float32))) for value in (FREE, OCCUPIED)
    )
    cells = np.full(floor.shape, UNKNOWN, dtype=np.int8)
    cells[floor > _FREE_SHARE] = FREE
    cells[wall > _WALL_SHARE] = OCCUPIED
    return cells


def _erase(cells: Cells, cell_m: float, rng: np.random.Generator) -> None:
    for _ in range(rng.poisson(_ERASED)):
        piece = random_piece(cells, cell_m, _ERASED_M, rng)
        piece[piece == OCCUPIED] = FREE


def random_piece(
    cells: Cells, cell_m: float, side_m: tuple[float, float], rng: np.random.Generator
) -> Cells:
    """Return a random rectangle of the raster, as a view."""
    row, col = (int(rng.integers(size)) for size in cells.shape)
    high, wide = np.ceil(rng.uniform(*side_m, 2) / cell_m).astype(int)
    return cells[row : row + high, col : col + wide]
