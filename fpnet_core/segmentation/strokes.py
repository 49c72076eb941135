# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Door symbols of drawings: an open leaf, with the quarter circle that it sweeps or half open."""

from __future__ import annotations

from functools import lru_cache

from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_any, unblocked
from fpnet_core.raster.distance import near_code
from fpnet_core.raster.morphology import Mask, grown, opened_by, square
from fpnet_core.raster.rays import cells_at
from fpnet_core.raster.windows import cells_of
from fpnet_core.segmentation.leaves import FLANK, LEAF, MAX_BEND, NEAR, REACH, at, is_ajar, is_end

# Chosen, not measured:
# Lines are about as thin as this [m] or one cell, oblique ones half of one more; filled walls are
# thicker.
_LINE_M, _LEAST_LINE = 0.1, 1.5
# Length of a leaf [m]: 0.7 to 1.3 m, at a scale wrong by a sixth.
_LEAF_M = (0.6, 1.6)
# Numerical: symbols are looked for at cells of about this size [m].
_WORK_M = 0.05
_DIRECTIONS = 120  # numerical
# Places on the arc, from its middle on; the ends merge with leaf and jamb.
_ARC_DEG = (45.0, 25.0, 65.0, 10.0, 35.0, 55.0, 75.0, 18.0, 30.0, 40.0, 50.0, 60.0, 70.0, 82.0)
# How far leaf and arc may be off on average [cells].
_MAX_MISFIT = 0.7
# Where a symbol is looked at for being blank: angles from the leaf, shares of the radius.
_SECTOR_DEG = (25.0, 35.0, 45.0, 55.0, 65.0)
_SECTOR = (0.35, 0.5, 0.65)
# The doorway is open this deep behind the leaf's line [m].
_DEPTH_M = 0.2
# Crossing lines and letters may cover so much of what should be blank.
_MAX_CLUTTER = 0.07
# Symbols whose leaves end closer together than this are one [m].
_APART_M = 0.25
# Ink this close to a symbol's lines is the symbol [cells].
_PEN_CELLS = 1
# Of a leaf at its hinge and an arc at its jamb so much stays, lest the wall's face breaks [cells].
_STUB = 1.5

Array = NDArray[np.float64]


def erase_door_symbols(free: Mask, cell_m: float) -> Mask:
    """
    Return ``free (H, W)`` with the leaves and arcs of doors turned into free space.

    A symbol is a straight stroke of 0.6 to 1.6 m, the leaf, and a quarter circle around one
    end of it, the hinge, that starts at its other end and ends across an open doorway. Both
    are thin lines and most of the sector between them is empty. Without an arc it is a leaf half
    open, with a gap as wide beside it. A drawing without such symbols is returned as it is;
    ``cell_m`` is the cell edge [m].
    """
    stride = max(1, int(_WORK_M / cell_m))
    ink = block_any(~free, stride)
    work_m = cell_m * stride
    side = max(2, round(_LINE_M / work_m) + 1)
    lines = ink & ~opened_by(ink, square(side), is_beyond=True)
    found = _symbols(lines, ink, work_m)
    if not len(found):
        return free
    pen = _drawn(_distinct(found, _APART_M / work_m), lines.shape) & lines
    return np.asarray(free | unblocked(pen, stride, free.shape))


def _symbols(lines: Mask, ink: Mask, cell_m: float) -> Array:
    """Return symbols (N, 6): misfit, tip (row, column), leaf's direction, radius, arc's side."""
    first, last = (round(length / cell_m) for length in _LEAF_M)
    if last <= first:  # cells as large as a leaf show none
        return np.zeros((0, 6))
    margin = int(np.ceil(REACH * last + FLANK)) + 1
    near_lines, near_ink = (np.pad(near_code(mask), margin, mode='edge') for mask in (lines, ink))
    blanks = _blanks(first, last, _DEPTH_M / cell_m)
    tips = cells_of(lines)
    arc = np.stack([np.cos(np.radians(_ARC_DEG)), np.sin(np.radians(_ARC_DEG))], axis=1)
    thick = max(_LINE_M / cell_m, _LEAST_LINE)
    found = _search(near_lines, near_ink, tips, margin, arc, first, blanks, thick)
    # Tips are searched one by one, which is gentle to the cache, and listed by direction.
    return np.asarray(found[np.argsort(found[:, 3], kind='stable')])


@lru_cache(maxsize=4)
def _blanks(first: int, last: int, depth: float) -> Array:
    """Return the places of :func:`_blank_places` for all radii; nobody writes to it."""
    return np.array([_blank_places(radius, depth) for radius in range(first, last)])


def _blank_places(radius: float, depth: float) -> Array:
    """
    Return places (4, 15, 2) where a symbol is blank, [cells] from its hinge.

    Along the leaf and towards the jamb: in the sector, beside the arc, beside the leaf, and in
    the doorway.
    """
    turn, share = np.meshgrid(np.radians(_SECTOR_DEG), _SECTOR)
    sector = radius * np.stack([share * np.cos(turn), share * np.sin(turn)], axis=-1)
    turn, reach = np.meshgrid(np.radians(_SECTOR_DEG), radius + FLANK * np.array([-1, 1, 1]))
    arc = np.stack([reach * np.cos(turn), reach * np.sin(turn)], axis=-1)
    along, across = np.meshgrid(radius * np.array(LEAF), FLANK * np.array([-1, 1, -1]))
    leaf = np.stack([along, across], axis=-1)
    across, behind = np.meshgrid(radius * np.array(LEAF), -depth * np.array([0.0, 0.5, 1.0]))
    doorway = np.stack([behind, across], axis=-1)
    return np.stack([part.reshape(-1, 2) for part in (sector, arc, leaf, doorway)])


@njit(cache=True, nogil=True)
def _search(lines, ink, tips, margin, arc, first, blanks, thick):  # type: ignore[no-untyped-def]
    """
    Try each cell of a line as a leaf's tip, in all directions and with both sides.

    ``lines`` and ``ink`` hold squared distances of at most 2, or 3, with a margin all around.
    Leaves without an arc have side 0, and come after all others.
    """
    found = [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0) for _ in range(0)]
    off = np.sqrt(np.arange(4.0).astype(np.float32))
    angles = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    sines, cosines = np.sin(angles), np.cos(angles)
    # Most directions end here: whole cells are looked up for them, in one row of all.
    flat, cols = ink.reshape(-1), ink.shape[1]
    beyond = _rounded(FLANK * sines) * cols + _rounded(FLANK * cosines)
    least = _rounded(-first * sines) * cols + _rounded(-first * cosines)
    for tip_row, tip_col in tips:
        row, col = float(tip_row + margin), float(tip_col + margin)
        cell = (tip_row + margin) * cols + tip_col + margin
        for k in range(_DIRECTIONS):
            if flat[cell + beyond[k]] <= NEAR or flat[cell + least[k]] > NEAR:
                continue
            u, misfit, ends = (sines[k], cosines[k]), 0.0, False
            for length in range(1, first + len(blanks)):
                hinge = (row - length * u[0], col - length * u[1])
                code = at(ink, hinge[0], hinge[1])
                if code > NEAR:
                    break
                misfit += off[code]
                if length < first:
                    continue
                if length == first:
                    ends = is_end(ink, row, col, u)
                for side in (-1.0, 1.0):
                    v = (u[1] * side, -u[0] * side)
                    score = misfit / length + _arc_misfit(lines, off, hinge, u, v, length, arc)
                    if score <= _MAX_MISFIT and _is_blank(
                        ink, hinge, u, v, blanks[length - first]
                    ):
                        tip = (float(tip_row), float(tip_col))
                        found.append((score, tip[0], tip[1], angles[k], float(length), side))
                beside = blanks[length - first, 2]
                if (
                    ends
                    and misfit <= MAX_BEND * length
                    and is_ajar(lines, ink, hinge, u, length, beside, thick)
                ):
                    score, tip = misfit / length + _MAX_MISFIT, (float(tip_row), float(tip_col))
                    found.append((score, tip[0], tip[1], angles[k], float(length), 0.0))
    return _listed(found)


@njit(cache=True, nogil=True)
def _listed(found):  # type: ignore[no-untyped-def]
    """Return symbols (N, 6) that were found one after the other."""
    listed = np.empty((len(found), 6))
    for n in range(len(found)):
        for column in range(6):
            listed[n, column] = found[n][column]
    return listed


@njit(cache=True, nogil=True)
def _rounded(cells):  # type: ignore[no-untyped-def]
    """Return whole numbers of cells (K,)."""
    return np.floor(cells + 0.5).astype(np.int64)


@njit(cache=True, nogil=True)
def _arc_misfit(lines, off, hinge, u, v, radius, arc):  # type: ignore[no-untyped-def]
    """Return the mean distance [cells] of an arc from lines, infinite where it is not drawn."""
    total = 0.0
    for k in range(len(arc)):
        a, b = radius * arc[k, 0], radius * arc[k, 1]
        code = at(lines, hinge[0] + a * u[0] + b * v[0], hinge[1] + a * u[1] + b * v[1])
        if code > NEAR:
            return np.inf
        total += off[code]
    return total / len(arc)


@njit(cache=True, nogil=True)
def _is_blank(ink, origin, u, v, blanks):  # type: ignore[no-untyped-def]
    """Tell whether hardly any place of each of ``blanks (4, K, 2)``, in u and v, holds ink."""
    for places in blanks:
        clutter = 0
        for a, b in places:
            row, col = origin[0] + a * u[0] + b * v[0], origin[1] + a * u[1] + b * v[1]
            clutter += at(ink, row, col) == 0
        if clutter > _MAX_CLUTTER * len(places):
            return False
    return True


def _distinct(found: Array, apart: float) -> Array:
    """Return of each group of symbols with nearly the same tip the one that fits best."""
    ordered = found[np.argsort(found[:, 0], kind='stable')]
    return ordered[_is_first(ordered, apart)]


@njit(cache=True, nogil=True)
def _is_first(symbols: Array, apart: float) -> Mask:
    """
    Tell which symbols (N, 6) have no kept earlier one's tip near by.

    One without an arc has no arc around it either.
    """
    kept = np.zeros(len(symbols), dtype=np.bool_)
    for k in range(len(symbols)):
        kept[k] = True
        for j in range(k):
            row, col = symbols[k, 1:3] - symbols[j, 1:3]
            near = apart
            if symbols[k, 5] == 0.0 and symbols[j, 5] != 0.0:
                angle, near = symbols[j, 3], symbols[j, 4] + apart
                row, col = row + symbols[j, 4] * np.sin(angle), col + symbols[j, 4] * np.cos(angle)
            if kept[j] and np.hypot(row, col) <= near:
                kept[k] = False
                break
    return kept


def _drawn(symbols: Array, shape: tuple[int, ...]) -> Mask:
    """Return where the leaves and arcs (N, 6) are, with a pen that covers their lines."""
    is_drawn = np.zeros(shape, np.bool_)
    for _, row, col, angle, radius, side in symbols:
        u = np.array([np.sin(angle), np.cos(angle)])
        v = np.array([u[1], -u[0]]) * side
        hinge = np.array([row, col]) - radius * u
        end = np.pi / 2.0 - _STUB / radius
        turn = np.linspace(0.0, end, int(2.0 * radius) + 2)[:, None]
        sweep = hinge + radius * (np.cos(turn) * u + np.sin(turn) * v)
        leaf = hinge + np.linspace(_STUB, radius, int(2.0 * radius) + 2)[:, None] * u
        is_drawn[cells_at(np.concatenate([leaf, sweep]), shape)] = True
    return grown(is_drawn, _PEN_CELLS)
