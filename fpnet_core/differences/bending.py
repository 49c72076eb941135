# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Local alignment of a submap with a drawing, to allow for odometry drift and inexact drawings.

A hall that is rotated by some degrees, or drawn half a metre off as a whole, is inexact but not
outdated. Therefore the walls around each patch are aligned rigidly with the drawing, starting
from the global placement and from those of neighbouring patches, so that errors that accumulate
along a corridor are followed. A single moved wall has little influence on a patch, because its
neighbours are still where they are drawn.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.pose import AGAIN, RIGID_STRAIN, AlignmentPrior, MapEvidence, refine, wall_support
from fpnet_core.scoring.deform import PATCH_M

Array = NDArray[np.float64]

_AROUND_M = 8.0
"""Chosen: radius of the walls aligned with a patch: a few rooms, one of which may have changed."""

_BETTER = 0.1
"""Chosen: least gain in the share of matched walls over the global placement."""

# Numerical:
_FEWEST_WALLS = 40  # samples, about as many metres of wall as a room has
_SWEEPS = 3  # passes in alternating order, to propagate alignments between patches
_SMOOTHED = 0.7  # standard deviation of the smoothing of shifts, in patches


@dataclass(frozen=True, eq=False)
class _Patch:
    """Walls around a patch at ``xy (2,)`` of the submap, with their placement on the plan."""

    xy: Array
    walls: Array
    A_plan_sub: Affine2D
    support: float


def bending(plan: MapEvidence, sub: MapEvidence, A_plan_sub: Affine2D) -> NDArray[np.float32]:
    """
    Return the local shifts that align a submap with the drawing.

    Parameters
    ----------
    plan, sub : evidence of both
    A_plan_sub : global placement of the submap

    Returns
    -------
    Shifts ``(H, W, 2)`` [m of the plan] of the cells of ``sub``.
    """
    rows, cols = sub.wall_distance.shape
    size = PATCH_M / sub.cell_m
    shape = max(1, round(rows / size)), max(1, round(cols / size))
    patches = _aligned(plan, dict(_patches(plan, sub, A_plan_sub, shape)), A_plan_sub)
    shifts, weight = np.zeros((*shape, 2), np.float32), np.full(shape, 1e-3, np.float32)
    for index, patch in patches.items():
        shifts[index] = patch.A_plan_sub.apply(patch.xy) - A_plan_sub.apply(patch.xy)
        weight[index] = 1.0
    spread = cv2.GaussianBlur(shifts * weight[..., None], (0, 0), _SMOOTHED)
    total = cv2.GaussianBlur(weight, (0, 0), _SMOOTHED)
    smooth = np.asarray(spread.reshape(*shape, 2) / total.reshape(*shape, 1), dtype=np.float32)
    return np.asarray(cv2.resize(smooth, (cols, rows)), dtype=np.float32)


def _patches(
    plan: MapEvidence, sub: MapEvidence, A_plan_sub: Affine2D, shape: tuple[int, int]
) -> Iterator[tuple[tuple[int, int], _Patch]]:
    """Yield the patches of a raster with enough walls around them."""
    A = sub.A_rc_xy
    back, cells = np.linalg.inv(A[:, :2]), np.array(sub.wall_distance.shape)
    for index in np.ndindex(shape):
        rc = (np.array(index) + 0.5) * cells / shape - 0.5
        xy = back @ (rc - A[:, 2])
        walls = sub.walls[np.hypot(*(sub.walls - xy).T) <= _AROUND_M]
        if len(walls) >= _FEWEST_WALLS:
            support = wall_support(plan, walls, Placements.of([A_plan_sub]))
            yield index, _Patch(xy, walls, A_plan_sub, float(support[0]) + _BETTER)


def _aligned(
    plan: MapEvidence, patches: dict[tuple[int, int], _Patch], A_plan_sub: Affine2D
) -> dict[tuple[int, int], _Patch]:
    """Return patches aligned one by one, from the global and the neighbours' placements."""
    alignment_prior = AlignmentPrior(RIGID_STRAIN, A_plan_sub.stretch)
    for sweep in range(_SWEEPS):
        for index in sorted(patches, reverse=bool(sweep % 2)):
            patch = patches[index]
            neighbours = [
                patches[near].A_plan_sub
                for step in ((-1, 0), (1, 0), (0, -1), (0, 1))
                if (near := (index[0] + step[0], index[1] + step[1])) in patches
            ]
            starts = Placements.of([patch.A_plan_sub, *neighbours])
            found = refine(plan, patch.walls, starts, alignment_prior, AGAIN)
            support = wall_support(plan, patch.walls, found)
            best = int(support.argmax())
            if support[best] > patch.support:
                A, value = found[best].A_plan_submap, float(support[best])
                patches[index] = _Patch(patch.xy, patch.walls, A, value)
    return patches
