# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A small, smooth, penalised deformation of the drawing under a placement.

Drawings are off locally: one corridor a little too short moves all that lies behind it. The
submap's walls are taken in patches; each may shift a little on the plan to where more of its walls
are drawn, at a price for moving at all and a higher one for moving unlike its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.pose import MapEvidence
from fpnet_core.scoring import kernels

Array = NDArray[np.float64]

WIDTH_M = 0.2
"""
Walls agree within about this: the accuracy of drawings and of a raster's cell together. Chosen.
"""

PATCH_M = 4.0
"""Edge of a patch: rooms and stretches of corridor move as a whole. Chosen."""

_STEP_M, _REACH = 0.25, 3  # numerical: shifts tried: so many steps to each side
# Chosen, not measured:
_STIFFNESS = 6.0  # wall samples that a shift of 1 m against the neighbours must explain
_ANCHOR = 1.5  # the same for a shift of 1 m against the placement
_SWEEPS = 4  # numerical


@dataclass(frozen=True, eq=False)
class Patches:
    """Patches of a submap: ``of_wall (P,)``, ``of_cell (H, W)``, ``neighbours (B, 8)``."""

    of_wall: NDArray[np.int64]
    of_cell: NDArray[np.int32]
    neighbours: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Count the patches."""
        return len(self.neighbours)


@dataclass(frozen=True, eq=False)
class Deformation:
    """
    How ``C`` placements bend the drawing.

    ``shift_cells (C, B, 2)`` in cells of the plan's raster (row, col); ``size_m`` and
    ``roughness_m (C,)`` are root mean squares over walls of the shift and of its difference to
    the neighbours'. ``contrast_mean`` and ``contrast_least (C,)``: by how much the support falls
    when the whole map is shifted, in the mean over directions and in the least telling one.
    """

    shift_cells: Array
    size_m: Array
    roughness_m: Array
    contrast_mean: Array
    contrast_least: Array


def patches_of(walls: Array, sub: MapEvidence) -> Patches:
    """Cut a submap and its ``walls (P, 2)`` into square patches."""
    size = max(1, round(PATCH_M / sub.cell_m))
    rows, cols = sub.wall_distance.shape
    down, across = -(-rows // size), -(-cols // size)
    row, col = (np.arange(count, dtype=np.int32) // size for count in (rows, cols))
    of_cell = row[:, None] * across + col
    A = sub.A_rc_xy
    rc = np.rint(walls @ A[:, :2].T + A[:, 2]).astype(np.int64)
    rc = np.clip(rc, 0, np.array([rows - 1, cols - 1]))
    used = of_cell[rc[:, 0], rc[:, 1]]
    # Patches without walls follow nobody and are asked by nobody but drawn walls.
    grid = np.arange(down * across).reshape(down, across)
    padded = np.pad(grid, 1, constant_values=-1)
    around = [
        padded[1 + i : 1 + i + down, 1 + j : 1 + j + across].ravel()
        for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j
    ]  # fmt: skip
    return Patches(used.astype(np.int64), of_cell, np.stack(around, axis=1))


def deform(plan: MapEvidence, to_plan: Array, walls: Array, patches: Patches) -> Deformation:
    """Bend the drawing under each placement ``to_plan (C, 2, 3)``, metres to the plan's cells."""
    step = max(1, round(_STEP_M / plan.cell_m))
    steps = np.arange(-_REACH, _REACH + 1) * step
    offsets = np.stack(np.meshgrid(steps, steps, indexing='ij'), axis=-1).reshape(-1, 2)
    offsets_m = np.asarray(offsets * plan.cell_m, dtype=np.float64)
    table = kernels.shift_table(
        to_plan, walls, patches.of_wall, offsets, plan.wall_likelihood(WIDTH_M), patches.count
    )
    chosen = kernels.smooth_shifts(
        table, offsets_m, patches.neighbours, _STIFFNESS, _ANCHOR, _SWEEPS
    )
    weight = np.bincount(patches.of_wall, minlength=patches.count) / max(len(walls), 1)
    shifts = offsets_m[chosen]
    size = np.sqrt((shifts**2).sum(axis=2) @ weight)
    others = patches.neighbours >= 0
    around = np.where(others[None, :, :, None], shifts[:, np.maximum(patches.neighbours, 0)], 0.0)
    mean = around.sum(axis=2) / np.maximum(others.sum(axis=1), 1)[None, :, None]
    rough = np.sqrt(((shifts - mean) ** 2).sum(axis=2) @ weight)
    whole = table.sum(axis=1) / max(len(walls), 1)
    edge = np.abs(offsets).max(axis=1) == _REACH * step
    centre = np.flatnonzero((offsets == 0).all(axis=1))[0]
    drop = whole[:, [centre]] - whole[:, edge]
    return Deformation(
        offsets[chosen].astype(np.float64), size, rough, drop.mean(axis=1), drop.min(axis=1)
    )
