# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A robot's map laid on a drawing piece by piece, as odometry bends the one and hands draw the other.

What turned by some degrees in a hall, or is drawn half a metre off as a whole, is inexact and not
out of date. So the walls around each place are aligned with the drawing on their own, rigidly:
from where the whole map lies, and from where the places beside it came to lie, so that what adds
up along a corridor is followed. A wall that was moved leaves its neighbours where they are drawn,
and hardly moves what is around it.
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
"""Chosen: walls so near to a place are aligned with it: some rooms, of which one has changed."""

_BETTER = 0.1
"""Chosen: by so much more of the walls must lie on drawn ones than where the whole map lies."""

# Numerical:
_FEWEST_WALLS = 40  # samples, about as many metres of wall as a room has
_SWEEPS = 3  # there and back: alignments spread from place to place
_SMOOTHED = 0.7  # standard deviation, in places: of the shifts between them


@dataclass(frozen=True, eq=False)
class _Place:
    """The walls around a place ``xy (2,)`` of the robot's map, and where they lie on the plan."""

    xy: Array
    walls: Array
    A_plan_sub: Affine2D
    support: float


def bending(plan: MapEvidence, sub: MapEvidence, A_plan_sub: Affine2D) -> NDArray[np.float32]:
    """
    Return by how much a robot's map must be moved on the drawing, place by place.

    Parameters
    ----------
    plan, sub : evidence of both
    A_plan_sub : where the whole map lies

    Returns
    -------
    Shifts ``(H, W, 2)`` [m of the plan] of the cells of ``sub``.
    """
    rows, cols = sub.wall_distance.shape
    size = PATCH_M / sub.cell_m
    shape = max(1, round(rows / size)), max(1, round(cols / size))
    places = _aligned(plan, dict(_places(plan, sub, A_plan_sub, shape)), A_plan_sub)
    shifts, weight = np.zeros((*shape, 2), np.float32), np.full(shape, 1e-3, np.float32)
    for index, place in places.items():
        shifts[index] = place.A_plan_sub.apply(place.xy) - A_plan_sub.apply(place.xy)
        weight[index] = 1.0
    spread = cv2.GaussianBlur(shifts * weight[..., None], (0, 0), _SMOOTHED)
    total = cv2.GaussianBlur(weight, (0, 0), _SMOOTHED)
    smooth = np.asarray(spread.reshape(*shape, 2) / total.reshape(*shape, 1), dtype=np.float32)
    return np.asarray(cv2.resize(smooth, (cols, rows)), dtype=np.float32)


def _places(
    plan: MapEvidence, sub: MapEvidence, A_plan_sub: Affine2D, shape: tuple[int, int]
) -> Iterator[tuple[tuple[int, int], _Place]]:
    """Yield the places of a raster around which there are enough walls."""
    A = sub.A_rc_xy
    back, cells = np.linalg.inv(A[:, :2]), np.array(sub.wall_distance.shape)
    for index in np.ndindex(shape):
        rc = (np.array(index) + 0.5) * cells / shape - 0.5
        xy = back @ (rc - A[:, 2])
        walls = sub.walls[np.hypot(*(sub.walls - xy).T) <= _AROUND_M]
        if len(walls) >= _FEWEST_WALLS:
            support = wall_support(plan, walls, Placements.of([A_plan_sub]))
            yield index, _Place(xy, walls, A_plan_sub, float(support[0]) + _BETTER)


def _aligned(
    plan: MapEvidence, places: dict[tuple[int, int], _Place], A_plan_sub: Affine2D
) -> dict[tuple[int, int], _Place]:
    """Return the places aligned on their own, from the whole map's placement and neighbours'."""
    alignment_prior = AlignmentPrior(RIGID_STRAIN, A_plan_sub.stretch)
    for sweep in range(_SWEEPS):
        for index in sorted(places, reverse=bool(sweep % 2)):
            place = places[index]
            around = [
                places[near].A_plan_sub
                for step in ((-1, 0), (1, 0), (0, -1), (0, 1))
                if (near := (index[0] + step[0], index[1] + step[1])) in places
            ]
            starts = Placements.of([place.A_plan_sub, *around])
            found = refine(plan, place.walls, starts, alignment_prior, AGAIN)
            support = wall_support(plan, place.walls, found)
            best = int(support.argmax())
            if support[best] > place.support:
                A, value = found[best].A_plan_submap, float(support[best])
                places[index] = _Place(place.xy, place.walls, A, value)
    return places
