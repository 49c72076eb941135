# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Imitation of robot maps from drawings: rough walls, specks, hidden and added parts."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.sim.config import ClipConfig
from fpnet_lab.sim.drawn.distort import random_piece

Cells = NDArray[np.int8]

# Chosen to span from clean to the roughest real maps of the development split:
_BUMPS, _GRAIN_CELLS = (0.0, 1.2), 2.0  # height and width of bumps on walls [cells]
_THICKENED = (-0.5, 1.0)  # additional wall thickness [cells]
_HOLLOW, _FACE_CELLS = 0.7, (1.5, 4.0)  # share of maps with wall faces only, and their depth
_SPECKS = 0.003  # maximum share of the floor
_PIECES, _PIECE_M = 12.0, (0.3, 2.0)  # mean number of changed rectangles, and their sides
_HIDDEN, _WALLED = 0.5, 0.6  # share of rectangles that hide walls; of the others that are walls
_LEAST_STD = 1e-9  # numerical: avoids division by zero on a single-cell raster


def robot_map_of(grid: GridMap, rng: np.random.Generator) -> GridMap:
    """Imitate a robot map of a drawing: rough walls, clutter, hidden parts."""
    cells = np.array(grid.cells)
    known = cells != UNKNOWN
    solid = _bumpy(cells == OCCUPIED, _BUMPS, rng) <= rng.uniform(*_THICKENED)
    cells[known] = FREE
    cells[known & solid] = OCCUPIED
    if rng.random() < _HOLLOW:
        cells[cells_to_nearest(cells != OCCUPIED) > rng.uniform(*_FACE_CELLS)] = UNKNOWN
    specks = rng.random(cells.shape) < rng.uniform(0.0, _SPECKS)
    cells[specks & (cells == FREE)] = OCCUPIED
    for _ in range(rng.poisson(_PIECES)):
        _change_piece(random_piece(cells, grid.resolution, _PIECE_M, rng), rng)
    return replace(grid, cells=cells)


def _change_piece(piece: Cells, rng: np.random.Generator) -> None:
    """Erase the walls of a piece, or fill its free cells, in place."""
    if rng.random() < _HIDDEN:
        piece[piece == OCCUPIED] = rng.choice([FREE, UNKNOWN])
    else:
        piece[piece == FREE] = OCCUPIED if rng.random() < _WALLED else UNKNOWN


def roughened(
    cells: NDArray[np.int8], rng: np.random.Generator, config: ClipConfig
) -> NDArray[np.int8]:
    """Return the cells (H, W) with bumpy walls and specks on the floor."""
    solid = _bumpy(cells == OCCUPIED, config.bumps_cells, rng) <= 0.0
    solid |= rng.random(cells.shape) < rng.uniform(*config.specks)
    known = cells != UNKNOWN
    return np.where(known, np.where(solid, OCCUPIED, FREE), UNKNOWN).astype(np.int8)


def _bumpy(
    wall: NDArray[np.bool_], height_cells: tuple[float, float], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the signed distance (H, W) of cells to bumpy walls [cells], negative inside."""
    outside, inside = cells_to_nearest(wall), cells_to_nearest(~wall)
    grain = cv2.GaussianBlur(rng.standard_normal(wall.shape), (0, 0), _GRAIN_CELLS)
    height = rng.uniform(*height_cells) / max(float(grain.std()), _LEAST_STD)
    return np.asarray(np.where(wall, -inside, outside) + height * grain)
