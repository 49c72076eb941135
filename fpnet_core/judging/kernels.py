# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Compiled look-ups behind the judge's evidence.

Letters: ``C`` placements, ``P`` wall samples of the submap, ``F`` its free samples, ``Q`` wall
samples of the plan, ``B`` patches of the submap, ``S`` local shifts that are tried.
``A (C, 2, 3)`` always maps a side's metres to fractional (row, col) of the other side's raster.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.rays import nearest_cell

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Ints = NDArray[np.int64]


@numba.njit(cache=True, nogil=True)
def shift_table(
    A: Array, walls: Array, patch: Ints, offsets: Ints, likelihood: Floats, patches: int
) -> Floats:
    """
    Return the wall support of every patch under every local shift, ``(C, B, S) float32``.

    Sums of ``likelihood`` over a patch's walls; ``offsets (S, 2)`` are cells of the plan's raster.
    """
    rows, cols = likelihood.shape
    flat, ahead = likelihood.reshape(-1), offsets[:, 0] * cols + offsets[:, 1]
    low, high = offsets.min(), offsets.max()
    table = np.zeros((len(A), patches, len(offsets)), dtype=np.float32)
    for c in range(len(A)):
        to_cell = A[c]
        for k in range(len(walls)):
            row, col = nearest_cell(to_cell, walls[k, 0], walls[k, 1])
            total = table[c, patch[k]]
            if min(row, col) + low >= 0 and row + high < rows and col + high < cols:
                here = row * cols + col
                for s in range(len(ahead)):
                    total[s] += flat[np.uint64(here + ahead[s])]
                continue
            for s in range(len(offsets)):
                r, q = row + offsets[s, 0], col + offsets[s, 1]
                if 0 <= r < rows and 0 <= q < cols:
                    total[s] += likelihood[r, q]
    return table


@numba.njit(cache=True, nogil=True)
def smooth_shifts(
    table: Floats,
    offsets_m: Array,
    neighbours: Ints,
    stiffness: float,
    anchor: float,
    sweeps: int,
) -> Ints:
    """
    Return the shift of each patch that explains its walls without tearing, ``(C, B) int64``.

    Minimises what ``table (C, B, S)`` leaves unexplained plus ``stiffness`` times the squared
    difference to the mean shift of the neighbouring patches plus ``anchor`` times its square.
    ``neighbours (B, 8)`` are patch numbers, -1 where there is none; ``offsets_m (S, 2)``.
    """
    count, patches, shifts = table.shape
    rest = 0
    for s in range(shifts):
        if offsets_m[s, 0] == 0.0 and offsets_m[s, 1] == 0.0:
            rest = s
    chosen = np.full((count, patches), rest, dtype=np.int64)
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
    return chosen


@numba.njit(cache=True, nogil=True)
def wall_distances(
    A: Array, walls: Array, patch: Ints, shift_cells: Array, distance: Floats, beyond: float
) -> tuple[Floats, Ints]:
    """
    Distance of each wall sample to the nearest drawn wall, ``(C, P) float32``, and its cell.

    ``shift_cells (C, B, 2)`` moves each patch first. The cell ``(C, P)`` is a flat index of
    ``distance``, -1 outside of it.
    """
    rows, cols = distance.shape
    found = np.full((len(A), len(walls)), np.float32(beyond))
    cell = np.full((len(A), len(walls)), -1, dtype=np.int64)
    for c in range(len(A)):
        for k in range(len(walls)):
            x, y, b = walls[k, 0], walls[k, 1], patch[k]
            down, along = shift_cells[c, b, 0], shift_cells[c, b, 1]
            row = int(np.floor(A[c, 0, 0] * x + A[c, 0, 1] * y + A[c, 0, 2] + down + 0.5))
            col = int(np.floor(A[c, 1, 0] * x + A[c, 1, 1] * y + A[c, 1, 2] + along + 0.5))
            if 0 <= row < rows and 0 <= col < cols:
                found[c, k] = distance[row, col]
                cell[c, k] = row * cols + col
    return found, cell


@numba.njit(cache=True, nogil=True)
def look_up(A: Array, points: Array, raster: NDArray[Any], beyond: Any) -> NDArray[Any]:
    """Return ``raster`` under every placed point, ``(C, F)``, ``beyond`` outside of it."""
    rows, cols = raster.shape
    found = np.empty((len(A), len(points)), dtype=raster.dtype)
    found[:] = beyond
    for c in range(len(A)):
        to_cell = A[c]
        for k in range(len(points)):
            row, col = nearest_cell(to_cell, points[k, 0], points[k, 1])
            if 0 <= row < rows and 0 <= col < cols:
                found[c, k] = raster[row, col]
    return found


@numba.njit(cache=True, nogil=True)
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
    Look for the plan's walls in what the robot saw.

    ``A (C, 2, 3)`` maps plan metres to the submap's raster, whose cells belong to the patches
    ``patch_of (H, W)``; ``shift_cells (C, B, 2)`` undoes each patch's shift there.

    Returns
    -------
    Histograms ``(C, 1 + len(edges_m))`` of the distance from each drawn wall inside the observed
    area to the nearest seen one, without and with the shifts.
    """
    rows, cols = distance.shape
    bins = len(edges_m) + 1
    plain, shifted = np.zeros((len(A), bins)), np.zeros((len(A), bins))
    for c in range(len(A)):
        to_cell = A[c]
        for k in range(len(walls)):
            row, col = nearest_cell(to_cell, walls[k, 0], walls[k, 1])
            if not (0 <= row < rows and 0 <= col < cols and observed[row, col]):
                continue
            d, b = distance[row, col], patch_of[row, col]
            plain[c, _bin_of(d, edges_m)] += 1.0
            r = int(np.floor(row + shift_cells[c, b, 0] + 0.5))
            q = int(np.floor(col + shift_cells[c, b, 1] + 0.5))
            if 0 <= r < rows and 0 <= q < cols:
                d = distance[r, q]
            shifted[c, _bin_of(d, edges_m)] += 1.0
    return plain, shifted


@numba.njit(nogil=True, inline='always')
def _bin_of(value: float, edges: Array) -> int:
    """Count the few ``edges`` below ``value``."""
    place = 0
    for edge in edges:
        place += int(edge < value)
    return place


@numba.njit(cache=True, nogil=True)
def lengths_between(placed: Array, drawn: Array) -> Array:
    """Return how far points ``placed (C, D, 2)`` are from ``drawn (E, 2)``, ``(C, D, E)``."""
    found = np.empty((placed.shape[0], placed.shape[1], len(drawn)))
    for c in range(placed.shape[0]):
        for d in range(placed.shape[1]):
            for e in range(len(drawn)):
                x, y = placed[c, d, 0] - drawn[e, 0], placed[c, d, 1] - drawn[e, 1]
                found[c, d, e] = np.sqrt(x * x + y * y)
    return found


@numba.njit(cache=True, nogil=True)
def room_overlap(
    labels: NDArray[np.int32], rooms: Ints, sub_count: int, plan_count: int
) -> NDArray[np.float32]:
    """Count the free samples of each pair of rooms, ``(C, sub_count, plan_count)``; 0 is none."""
    counts = np.zeros((len(labels), sub_count, plan_count), dtype=np.float32)
    for c in range(len(labels)):
        for k in range(len(rooms)):
            counts[c, rooms[k], labels[c, k]] += 1.0
    return counts


@numba.njit(cache=True, nogil=True)
def contested(likelihood: Floats) -> tuple[Array, Array]:
    """
    Compare all placements by pairs, where they disagree.

    ``likelihood (C, P)`` is each placement's for each wall sample. Returns ``net (C, C)``, the sum
    of differences [k, j], and ``total (C, C)``, the sum of their magnitudes.
    """
    count, points = likelihood.shape
    net, total = np.zeros((count, count)), np.zeros((count, count))
    for k in range(count):
        for j in range(k):
            gain, loss = 0.0, 0.0
            for p in range(points):
                d = likelihood[k, p] - likelihood[j, p]
                if d > 0.0:
                    gain += d
                else:
                    loss -= d
            net[k, j], net[j, k] = gain - loss, loss - gain
            total[k, j] = total[j, k] = gain + loss
    return net, total
