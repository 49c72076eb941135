# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Drawings that are locally off, and robot maps made of drawings.

Real drawings are not one affine away from the building: corridors are too long here and too short
there, walls are bent, left out or drawn where a renovation took them away. A drawing of a real
building, furnished or not, becomes something like a robot's map of it by roughening its walls and
adding what stands around.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, map_coordinates

from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

Array = NDArray[np.float64]
Field = Callable[[Array], Array]
Cells = NDArray[np.int8]

# Chosen to span from hardly off to as rough as the worst real drawings of the tune half (a metre
# over a corridor's length), and drawn from evenly:
_AMPLITUDE_M = (0.05, 0.5)  # standard deviation of one step of a distortion
_AXIS_SHARE, _AXIS_STEP_M = 0.7, (4.0, 12.0)  # stretched piecewise along x and y
_BEND_SHARE, _BEND_STEP_M = 0.7, (6.0, 20.0)  # bent smoothly
_TREND = (0.3, 1.0)  # share of the overall stretch that is taken out again
_ERASED, _ERASED_M = 2.0, (0.25, 4.0)  # pieces of wall left out, in the mean, and their size
_WALL_SHARE, _FREE_SHARE = 0.35, 0.5  # of a warped cell; thin walls must stay closed
_ITERATIONS = 8  # numerical: of the inverse of a distortion that is small beside its own length
_STRIDE = 8  # numerical: cells between samples of a smooth distortion
_BUMPS, _BUMP_CELLS = (0.0, 1.2), 2.0  # height and width of bumps on walls [cells]
_THICKENED = (-0.5, 1.0)  # by so many cells
_HOLLOW, _FACE_CELLS = 0.7, (1.5, 4.0)  # share of maps that know walls' faces only, and how deep
_SPECKS = 0.003  # largest share of the floor
_PIECES, _PIECE_M = 12.0, (0.3, 2.0)  # what stands, or is hidden, and its size
_HIDDEN, _WALLED = 0.5, 0.6  # shares of the pieces that hide walls, and that are walls else


@dataclass(frozen=True, eq=False)
class RoughDrawing:
    """A drawing, and where it shows a place that the true one shows at ``xy (P, 2)`` [m]."""

    grid: GridMap
    displaced: Field


def rough_drawing(grid: GridMap, rng: np.random.Generator) -> RoughDrawing:
    """Return a drawing that is locally off: stretched piecewise, bent, with walls left out."""
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


def robot_map_of(grid: GridMap, rng: np.random.Generator) -> GridMap:
    """Return a drawing as a robot might have mapped it: rough walls, clutter, things hidden."""
    cells = np.array(grid.cells)
    noise = cv2.GaussianBlur(rng.standard_normal(cells.shape), (0, 0), _BUMP_CELLS)
    wall, known = cells == OCCUPIED, cells != UNKNOWN
    outside, inside = distance_transform_edt(~wall), distance_transform_edt(wall)
    height = rng.uniform(*_BUMPS) * noise / noise.std()
    solid = np.where(wall, -inside, outside) + height <= rng.uniform(*_THICKENED)
    cells[known] = FREE
    cells[known & solid] = OCCUPIED
    if rng.random() < _HOLLOW:
        cells[distance_transform_edt(cells == OCCUPIED) > rng.uniform(*_FACE_CELLS)] = UNKNOWN
    specks = rng.random(cells.shape) < rng.uniform(0.0, _SPECKS)
    cells[specks & (cells == FREE)] = OCCUPIED
    for _ in range(rng.poisson(_PIECES)):
        _change_piece(_piece(cells, grid.resolution, _PIECE_M, rng), rng)
    return replace(grid, cells=cells)


def _stretched(size_m: Array, step_m: float, sigma_m: float, rng: np.random.Generator) -> Field:
    """Return a distortion that stretches and shrinks pieces along both axes."""
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
    """Return a smooth distortion in any direction."""
    columns, rows = (size_m / step_m).astype(int) + 4
    values = rng.normal(0.0, sigma_m, (2, rows, columns))

    def field(xy: Array) -> Array:
        at = xy[:, ::-1].T / step_m + 1.0
        return np.column_stack([map_coordinates(v, at, order=3, mode='nearest') for v in values])

    return field


def _warped(grid: GridMap, shift: Field) -> Cells:
    """Return the cells after every place has moved by ``shift`` [m, grid axes]."""
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
    # Samples lie on whole strides: an affine resize that keeps them there.
    keep = np.array([[_STRIDE, 0.0, 0.0], [0.0, _STRIDE, 0.0]])
    back = [
        cv2.warpAffine(coarse[..., axis], keep, (cols, rows), flags=cv2.INTER_LINEAR)
        for axis in range(2)
    ]

    def share(value: int) -> NDArray[np.float32]:
        mask = (grid.cells == value).astype(np.float32)
        return np.asarray(cv2.remap(mask, back[0], back[1], cv2.INTER_LINEAR), np.float32)

    cells = np.full(grid.shape, UNKNOWN, dtype=np.int8)
    cells[share(FREE) > _FREE_SHARE] = FREE
    cells[share(OCCUPIED) > _WALL_SHARE] = OCCUPIED
    return cells


def _erase(cells: Cells, cell_m: float, rng: np.random.Generator) -> None:
    for _ in range(rng.poisson(_ERASED)):
        piece = _piece(cells, cell_m, _ERASED_M, rng)
        piece[piece == OCCUPIED] = FREE


def _piece(
    cells: Cells, cell_m: float, side_m: tuple[float, float], rng: np.random.Generator
) -> Cells:
    """Return a random rectangle of the raster, as a view."""
    row, col = (int(rng.integers(size)) for size in cells.shape)
    high, wide = np.ceil(rng.uniform(*side_m, 2) / cell_m).astype(int)
    return cells[row : row + high, col : col + wide]


def _change_piece(piece: Cells, rng: np.random.Generator) -> None:
    """Hide the walls of a piece, or put something there."""
    if rng.random() < _HIDDEN:
        piece[piece == OCCUPIED] = rng.choice([FREE, UNKNOWN])
    else:
        piece[piece == FREE] = OCCUPIED if rng.random() < _WALLED else UNKNOWN
