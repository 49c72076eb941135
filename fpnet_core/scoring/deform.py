# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Small, smooth, penalised deformation of the plan under a placement.

Plans have local errors: a corridor drawn a little too short displaces everything behind it. The
submap's walls are split into patches. Each patch may shift to where the plan explains more of its
walls, with a penalty for the shift and a higher one for differing from its neighbours.
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
Distance within which walls agree: accuracy of the plan plus one raster cell. Chosen.
"""

PATCH_M = 4.0
"""Edge of a patch: rooms and pieces of corridor shift as a whole. Chosen."""

_STEP_M, _REACH = 0.25, 3  # numerical: step of the shifts, and steps tried to each side
# Chosen, not measured:
_STIFFNESS = 6.0  # wall samples that justify a shift of 1 m relative to the neighbours
_ANCHOR = 1.5  # the same for a shift of 1 m relative to the placement
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
    Deformation of the plan under each of ``C`` placements.

    ``shift_cells (C, B, 2)`` in cells of the plan's raster (row, col); ``size_m`` and
    ``roughness_m (C,)`` are root mean squares over the walls of the shift and of its difference to
    the neighbours' mean. ``contrast_mean`` and ``contrast_least (C,)`` are the drops in support
    when the whole map is shifted: mean over directions, and in the least informative one.
    """

    shift_cells: Array
    size_m: Array
    roughness_m: Array
    contrast_mean: Array
    contrast_least: Array


def patches_of(walls: Array, sub: MapEvidence) -> Patches:
    """Split a submap and its ``walls (P, 2)`` into square patches."""
    size = max(1, round(PATCH_M / sub.cell_m))
    rows, cols = sub.wall_distance.shape
    down, across = -(-rows // size), -(-cols // size)
    row, col = (np.arange(count, dtype=np.int32) // size for count in (rows, cols))
    of_cell = row[:, None] * across + col
    A = sub.A_rc_xy
    rc = np.rint(walls @ A[:, :2].T + A[:, 2]).astype(np.int64)
    rc = np.clip(rc, 0, np.array([rows - 1, cols - 1]))
    used = of_cell[rc[:, 0], rc[:, 1]]
    # Patches without walls follow their neighbours; only plan walls look up their shifts.
    grid = np.arange(down * across).reshape(down, across)
    padded = np.pad(grid, 1, constant_values=-1)
    around = [
        padded[1 + i : 1 + i + down, 1 + j : 1 + j + across].ravel()
        for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j
    ]  # fmt: skip
    return Patches(used.astype(np.int64), of_cell, np.stack(around, axis=1))


def deform(plan: MapEvidence, to_plan: Array, walls: Array, patches: Patches) -> Deformation:
    """Deform the plan under each placement ``to_plan (C, 2, 3)``, metres to the plan's cells."""
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
