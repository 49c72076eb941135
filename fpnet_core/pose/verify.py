# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Agreement of two maps under candidate transforms, measured on the rasters.

Three quantities are measured: the share of the robot's walls on plan walls (furniture keeps it
below 1), the share of plan walls in the observed area that were observed, and the share of
the robot's free space outside that of the plan. A wrong place cannot satisfy the
last two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import each_unwritable
from fpnet_core.geometry import Placements
from fpnet_core.geometry.distinct import evenly_drawn
from fpnet_core.pose.evidence import MapEvidence

WALL_SIGMA_M = 0.2
"""
Width of the wall kernel in verification: a wall's thickness, covered only in part by drawing and
scans. Chosen.
"""

COARSE_SIGMA_M = 0.5
"""
Width of the wall kernel in early rejection: error of candidates from doors and rooms. Chosen.
"""

Array = NDArray[np.float64]

# Chosen, not measured:
OUTSIDE_TOLERANCE_M = 0.3  # overlap of free space and a drawn wall that is tolerated
OUTSIDE_FULL_M = 1.0  # depth outside from which free space counts fully

_TILE_M = 4.0  # numerical: edge of the tiles by which plan walls are looked up


@dataclass(frozen=True, eq=False)
class WallAgreement:
    """
    Scores of ``C`` candidates, each ``(C,) float64`` in [0, 1].

    ``wall_support``: share of submap walls on plan walls. ``plan_seen``: share of plan walls
    inside the observed area that the submap confirms. ``free_violation``: share of submap free
    space outside the plan's free space.
    """

    wall_support: NDArray[np.float64]
    plan_seen: NDArray[np.float64]
    free_violation: NDArray[np.float64]

    @property
    def score(self) -> NDArray[np.float64]:
        """Score in [0, 1]: geometric mean of both wall terms minus the violation."""
        walls = np.sqrt(self.wall_support * self.plan_seen)
        return np.clip(walls - self.free_violation, 0.0, 1.0)


def coarse_support(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Placements,
    sigma_m: float,
    max_points: int,
) -> NDArray[np.float64]:
    """
    Return a cheap forward score of ``C`` candidates for early rejection, ``(C,)`` in [-1, 1].

    It is wall support minus free violation on at most ``max_points`` evenly subsampled points of
    each kind.
    """
    walls, free = evenly_drawn(sub.walls, max_points), evenly_drawn(sub.free, max_points)
    support, violation = _forward_scores(plan, walls, free, candidates, sigma_m)
    return support - violation


def wall_support(
    plan: MapEvidence,
    walls: NDArray[np.float64],
    candidates: Placements,
    sigma_m: float = WALL_SIGMA_M,
) -> NDArray[np.float64]:
    """Return the share of ``walls (P, 2)`` that ``C`` candidates put on drawn walls, ``(C,)``."""
    support, _ = _forward_scores(plan, walls, np.zeros((0, 2)), candidates, sigma_m)
    return support


def agreement(
    plan: MapEvidence,
    sub: MapEvidence,
    candidates: Placements,
    sigma_m: float,
    max_points: int | None = None,
) -> WallAgreement:
    """
    Return the two-way scores of ``C`` candidates; zero candidates give empty arrays.

    Parameters
    ----------
    plan, sub : evidence of both maps
    candidates : ``C`` placements of the submap
    sigma_m : width of the wall kernel ``exp(-d^2 / (2 sigma^2))``
    max_points : evenly subsampled points of each kind of the submap, and about as
        many of the plan where the submap may lie; None: all
    """
    walls, free, drawn = sub.walls, sub.free, plan.kept(_in_tiles)
    if max_points is not None:
        walls, free = evenly_drawn(walls, max_points), evenly_drawn(free, max_points)
        drawn = drawn.every(max(1, len(sub.walls) // max_points))
    support, violation = _forward_scores(plan, walls, free, candidates, sigma_m)
    seen = np.zeros(len(candidates))
    if len(candidates):
        inverse = np.asarray(np.linalg.inv(candidates.linear), dtype=np.float64)
        back = -np.einsum('cij,cj->ci', inverse, candidates.translation)
        fields = sub.wall_likelihood(sigma_m), sub.observed
        A, tiles = _chained(sub.A_rc_xy, inverse, back), drawn.within(candidates, sub)
        _backward(*[*each_unwritable(A, drawn.walls, drawn.first, tiles, *fields), seen])
    return WallAgreement(support, seen, violation)


@dataclass(frozen=True, eq=False)
class _Tiled:
    """
    A plan's walls in square tiles; a row of tiles is contiguous.

    ``walls (2, P)`` are the samples [m], ``first (R, C + 1)`` the index of each tile's first
    sample and the end of the row; the tiles begin at ``low (2,)`` [m].
    """

    walls: Array
    first: NDArray[np.int64]
    low: Array

    def every(self, step: int) -> _Tiled:
        """Return every ``step``-th of the walls."""
        return _Tiled(
            np.ascontiguousarray(self.walls[:, ::step]), -(-self.first // step), self.low
        )

    def within(self, candidates: Placements, sub: MapEvidence) -> NDArray[np.int64]:
        """Return the first tile and the end of the tiles (C, 2, 2) that a submap may cover."""
        to_xy = np.linalg.inv(sub.A_rc_xy[:, :2])
        high = np.array(sub.observed.shape) - 0.5
        rc = np.array([[-0.5, -0.5], [-0.5, high[1]], [high[0], -0.5], high])
        corners = (rc - sub.A_rc_xy[:, 2]) @ to_xy.T
        placed = np.einsum('cij,pj->cpi', candidates.linear, corners)
        placed += candidates.translation[:, None] - self.low
        ends = np.stack([placed.min(axis=1), placed.max(axis=1) + _TILE_M], axis=1) / _TILE_M
        most = np.array([self.first.shape[1] - 1, self.first.shape[0]])
        return np.asarray(np.clip(np.floor(ends), 0, most), dtype=np.int64)


def _in_tiles(plan: MapEvidence) -> _Tiled:
    """Return the walls of a plan in tiles; without walls there are no tiles."""
    walls = plan.walls
    if not len(walls):
        return _Tiled(np.zeros((2, 0)), np.zeros((0, 1), np.int64), np.zeros(2))
    low = walls.min(axis=0)
    col, row = np.floor((walls - low) / _TILE_M).astype(np.int64).T
    rows, cols = int(row.max()) + 1, int(col.max()) + 1
    tile = row * cols + col
    first = np.r_[0, np.cumsum(np.bincount(tile, minlength=rows * cols))]
    begins = np.arange(rows)[:, None] * cols + np.arange(cols + 1)
    order = np.argsort(tile, kind='stable')
    return _Tiled(np.ascontiguousarray(walls[order].T), first[begins], low)


def _forward_scores(
    plan: MapEvidence, walls: Array, free: Array, candidates: Placements, sigma_m: float
) -> tuple[Array, Array]:
    """Return wall support and free violation (C,) of samples (Pw, 2), (Pf, 2) of the submap."""
    support, violation = np.zeros(len(candidates)), np.zeros(len(candidates))
    A = _chained(plan.A_rc_xy, candidates.linear, candidates.translation)
    read = (A, walls.T, free.T, plan.wall_likelihood(sigma_m), plan.outside_depth)
    _forward(*[*each_unwritable(*read), support, violation])
    return support, violation


@numba.njit(cache=True, nogil=True)
def _forward(  # type: ignore[no-untyped-def]
    A, walls, free, wall_likelihood, outside_depth, support, violation
):
    """Write the scores (C,) of samples (2, Pw), (2, Pf) of the submap; see :func:`_chained`."""
    likelihood, depth = wall_likelihood.reshape(-1), outside_depth.reshape(-1)
    most_walls, most_free, first = walls.shape[1], free.shape[1], np.int64(0)
    cells = np.empty(most_walls + most_free, np.int32)
    for c in range(len(A)):
        _cells_of(A[c], walls, first, most_walls, wall_likelihood.shape, cells)
        total = 0.0
        for k in range(most_walls):
            if cells[k] >= 0:
                total += likelihood[cells[k]]
        support[c] = total / max(most_walls, 1)
        _cells_of(A[c], free, first, most_free, outside_depth.shape, cells)
        outside = 0.0
        for k in range(most_free):
            own = depth[cells[k]] if cells[k] >= 0 else OUTSIDE_FULL_M
            share = (own - OUTSIDE_TOLERANCE_M) / (OUTSIDE_FULL_M - OUTSIDE_TOLERANCE_M)
            outside += min(max(share, 0.0), 1.0)
        violation[c] = outside / max(most_free, 1)


@numba.njit(cache=True, nogil=True)
def _backward(  # type: ignore[no-untyped-def]
    A, walls, first, tiles, wall_likelihood, observed, seen
):
    """Write the share of observed plan walls in the tiles of each candidate to ``seen``."""
    likelihood, is_observed = wall_likelihood.reshape(-1), observed.reshape(-1)
    cells = np.empty(walls.shape[1], np.int32)
    for c in range(len(A)):
        total, count = 0.0, 0
        for row in range(tiles[c, 0, 1], tiles[c, 1, 1]):
            begin, end = first[row, tiles[c, 0, 0]], first[row, tiles[c, 1, 0]]
            _cells_of(A[c], walls, begin, end, observed.shape, cells)
            for k in range(end - begin):
                if cells[k] >= 0 and is_observed[cells[k]]:
                    total += likelihood[cells[k]]
                    count += 1
        seen[c] = total / max(count, 1)


@numba.njit(cache=True, nogil=True)
def _cells_of(A, xy, begin, end, shape, cells):  # type: ignore[no-untyped-def]
    """
    Write the flat indices of the cells nearest to points ``(2, P)`` to ``cells``, -1 outside.

    ``A (2, 3)`` maps metres to (row, column). A separate loop without sums and lookups, over
    contiguous coordinates, can be vectorised by the compiler.
    """
    xs, ys = xy[0, begin:end], xy[1, begin:end]
    rows, cols = float(shape[0]), float(shape[1])
    for k in range(len(xs)):
        x, y = xs[k], ys[k]
        row = np.floor(A[0, 0] * x + A[0, 1] * y + A[0, 2] + 0.5)
        col = np.floor(A[1, 0] * x + A[1, 1] * y + A[1, 2] + 0.5)
        is_inside = (row >= 0.0) & (col >= 0.0) & (row < rows) & (col < cols)
        cells[k] = np.int32(row * cols + col) if is_inside else np.int32(-1)


def _chained(A_rc_xy: Array, linear: Array, translation: Array) -> Array:
    """Return affine maps (C, 2, 3) from source metres to raster indices of the target."""
    columns = np.concatenate([linear, translation[..., None]], axis=2)
    A: Array = A_rc_xy[:, :1] * columns[:, None, 0] + A_rc_xy[:, 1:2] * columns[:, None, 1]
    A[..., 2] += A_rc_xy[:, 2]
    return A
