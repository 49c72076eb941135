# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Compiled lookups for the evidence of the placement scorer.

Letters: ``C`` placements, ``P`` wall samples of the submap, ``F`` its free samples, ``Q`` wall
samples of the plan, ``B`` patches of the submap, ``S`` local shifts to try.
``A (C, 2, 3)`` always maps metres of one map to fractional (row, col) of the other map's raster.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import each_unwritable
from fpnet_core.raster.rays import nearest_cell

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Ints = NDArray[np.int64]
Scalar = TypeVar('Scalar', bound=np.generic)


def shift_table(
    A: Array, walls: Array, patch: Ints, offsets: Ints, likelihood: Floats, patches: int
) -> Floats:
    """
    Return the wall support of every patch under every local shift, ``(C, B, S) float32``.

    It sums ``likelihood`` over a patch's walls; ``offsets (S, 2)`` are cells of the plan's raster.
    """
    table = np.zeros((len(A), patches, len(offsets)), dtype=np.float32)
    ahead = offsets @ (likelihood.shape[1], 1)
    reach = int(np.abs(offsets).max(initial=0))
    _add_shifts(*[*each_unwritable(A, walls, patch, offsets, ahead, likelihood), reach, table])
    return table


@numba.njit(cache=True, nogil=True)
def _add_shifts(  # type: ignore[no-untyped-def]
    A, walls, patch, offsets, ahead, likelihood, reach, table
):
    """Write what :func:`shift_table` returns; ``reach`` is the longest offset on an axis."""
    rows, cols = likelihood.shape
    flat = likelihood.reshape(-1)
    for c in range(len(A)):
        to_cell = A[c]
        for k in range(len(walls)):
            row, col = nearest_cell(to_cell, walls[k, 0], walls[k, 1])
            total = table[c, patch[k]]
            if min(row, col) >= reach and row + reach < rows and col + reach < cols:
                here = row * cols + col
                for s in range(len(ahead)):
                    total[s] += flat[np.uint64(here + ahead[s])]
                continue
            for s in range(len(offsets)):
                r, q = row + offsets[s, 0], col + offsets[s, 1]
                if 0 <= r < rows and 0 <= q < cols:
                    total[s] += likelihood[r, q]


def smooth_shifts(
    table: Floats,
    offsets_m: Array,
    neighbours: Ints,
    stiffness: float,
    anchor: float,
    sweeps: int,
) -> Ints:
    """
    Return the shift of each patch that explains its walls smoothly, ``(C, B) int64``.

    Minimises the negative support ``table (C, B, S)`` plus ``stiffness`` times the squared
    difference to the mean shift of the neighbouring patches plus ``anchor`` times its square.
    ``neighbours (B, 8)`` are patch numbers, -1 where there is none; ``offsets_m (S, 2)``.
    """
    rest = int(np.flatnonzero((offsets_m == 0.0).all(axis=1))[-1])
    chosen = np.full(table.shape[:2], rest, dtype=np.int64)
    read = each_unwritable(table, offsets_m, neighbours)
    _smooth_shifts(*[*read, float(stiffness), float(anchor), sweeps, rest, chosen])
    return chosen


@numba.njit(cache=True, nogil=True)
def _smooth_shifts(  # type: ignore[no-untyped-def]
    table, offsets_m, neighbours, stiffness, anchor, sweeps, rest, chosen
):
    """Write what :func:`smooth_shifts` returns; ``rest`` is the number of the zero shift."""
    count, patches, shifts = table.shape
    for c in range(count):
        for _ in range(sweeps):
            for b in range(patches):
                u, v, n = 0.0, 0.0, 0
                for j in range(neighbours.shape[1]):
                    other = neighbours[b, j]
                    if other >= 0:
                        u += offsets_m[chosen[c, other], 0]
                        v += offsets_m[chosen[c, other], 1]
                        n += 1
                if n:
                    u /= n
                    v /= n
                best, least = rest, np.inf
                for s in range(shifts):
                    x, y = offsets_m[s, 0], offsets_m[s, 1]
                    cost = anchor * (x * x + y * y) - table[c, b, s]
                    if n:
                        cost += stiffness * ((x - u) ** 2 + (y - v) ** 2)
                    if cost < least - 1e-9:
                        best, least = s, cost
                chosen[c, b] = best


def cells_under(
    A: Array, points: Array, shape: tuple[int, ...], shift: tuple[Array, Ints] | None = None
) -> Ints:
    """
    Return the cell under every placed point ``(C, P)`` as flat index of a raster, -1 outside.

    ``shift`` holds the displacement of each patch of points in cells, ``(C, B, 2)``, and the
    patch of each point, ``(P,)``.
    """
    found = np.empty((len(A), len(points)), np.int64)
    shift_cells, patch = shift or (np.zeros((len(A), 1, 2)), np.zeros(len(points), np.int64))
    rows, cols = shape
    read = each_unwritable(A, points, shift_cells, patch)
    _cells_under(*[*read, rows, cols, found])
    return found


@numba.njit(cache=True, nogil=True)
def _cells_under(A, points, shift, patch, rows, cols, found):  # type: ignore[no-untyped-def]
    """Write what :func:`cells_under` returns."""
    for c in range(len(A)):
        to_cell = A[c]
        for k in range(len(points)):
            x, y, b = points[k, 0], points[k, 1], patch[k]
            row = to_cell[0, 0] * x + to_cell[0, 1] * y + to_cell[0, 2] + shift[c, b, 0]
            col = to_cell[1, 0] * x + to_cell[1, 1] * y + to_cell[1, 2] + shift[c, b, 1]
            r, q = np.int64(np.floor(row + 0.5)), np.int64(np.floor(col + 0.5))
            is_on = r >= 0 and q >= 0 and r < rows and q < cols
            found[c, k] = r * cols + q if is_on else -1


def look_up(A: Array, points: Array, raster: NDArray[Scalar], beyond: Any) -> NDArray[Scalar]:
    """Return ``raster`` under every placed point, ``(C, F)``; ``beyond`` outside of it."""
    return looked_up(cells_under(A, points, raster.shape), raster, beyond)


def looked_up(cell: Ints, raster: NDArray[Scalar], beyond: Any) -> NDArray[Scalar]:
    """Return ``raster`` at flat indices (...); ``beyond`` where they are negative."""
    found = raster.reshape(-1)[cell]
    found[cell < 0] = beyond
    return found


def drawn_walls(
    A: Array,
    walls: Array,
    distance: Floats,
    observed: NDArray[np.bool_],
    patch_of: NDArray[np.int32],
    shift_cells: Array,
    edges_m: Array,
) -> tuple[Array, Array]:
    """
    Compare the plan's walls with the walls that the robot observed.

    ``A (C, 2, 3)`` maps plan metres to the submap's raster, whose cells belong to the patches
    ``patch_of (H, W)``; ``shift_cells (C, B, 2)`` undoes each patch's shift there.

    Returns
    -------
    Histograms ``(C, 1 + len(edges_m))`` of the distance from each plan wall inside the observed
    area to the nearest observed one, without and with the shifts.
    """
    placed = cells_under(A, walls, distance.shape)
    which, point = np.nonzero(looked_up(placed, observed, False))
    cell = placed[which, point]
    rc = np.stack(np.divmod(cell, distance.shape[1]), axis=1)
    there = np.floor(rc + shift_cells[which, patch_of.reshape(-1)[cell]] + 0.5).astype(np.int64)
    is_on = ((there >= 0) & (there < distance.shape)).all(axis=1)
    moved = np.where(is_on, there[:, 0] * distance.shape[1] + there[:, 1], cell)
    bins, flat = len(edges_m) + 1, distance.reshape(-1)
    plain, shifted = (
        np.bincount(
            which * bins + np.searchsorted(edges_m, flat[at]), minlength=len(A) * bins
        ).reshape(-1, bins).astype(np.float64)
        for at in (cell, moved)
    )  # fmt: skip
    return plain, shifted


def room_overlap(labels: NDArray[np.int32], rooms: Ints, sub_count: int, plan_count: int) -> Ints:
    """Count the free samples per pair of rooms, ``(C, sub_count, plan_count)``; 0 is no room."""
    shape = len(labels), sub_count, plan_count
    pair = (np.arange(len(labels))[:, None] * sub_count + rooms) * plan_count + labels
    return np.bincount(pair.ravel(), minlength=int(np.prod(shape))).reshape(shape)


def contested(likelihood: Floats) -> tuple[Array, Array]:
    """
    Compare all pairs of placements where they disagree.

    ``likelihood (C, P)`` is that of each wall sample under each placement. Returns ``net (C, C)``,
    the sum of differences [k, j], and ``total (C, C)``, the sum of their magnitudes.
    """
    net, total = np.zeros((2, len(likelihood), len(likelihood)))
    for k, own in enumerate(likelihood):
        apart = own - likelihood[:k]
        net[k, :k] = apart.sum(axis=1, dtype=np.float64)
        total[k, :k] = np.abs(apart).sum(axis=1, dtype=np.float64)
    return net - net.T, total + total.T
