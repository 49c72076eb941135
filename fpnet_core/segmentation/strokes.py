# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Door symbols of drawings: an open leaf with its quarter-circle arc.

Pictures are parsed by a network that knows leaves; maps of stated walls are not. Without this
module the doors of styles *sketch* and *architect* of ``benchmarks/drawing_styles.py`` are lost.
"""

from __future__ import annotations

from functools import lru_cache

from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import unwritable
from fpnet_core.geometry.distinct import first_distinct
from fpnet_core.raster.blocks import block_any, unblocked
from fpnet_core.raster.distance import near_code
from fpnet_core.raster.morphology import Mask, grown, opened_by, square
from fpnet_core.raster.rays import cells_at
from fpnet_core.raster.windows import cells_of

# Chosen, not measured:
_LINE_M = 0.1  # lines are about this thin or one cell; filled walls are thicker
_NEAR = 2  # largest squared distance of ink from its expected place [cells squared]
_FLANK = 3.0  # distance at which nothing may be drawn beside leaves and arcs [cells]
# Physical: length of a leaf [m], 0.7 to 1.3 m, at a scale wrong by a sixth.
_LEAF_M = (0.6, 1.6)
# Numerical: symbols are searched for at cells of about this size [m].
_WORK_M = 0.05
_DIRECTIONS = 120  # numerical
_ANGLES = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS  # numerical
# Numerical: their unit vectors.
_UNITS = np.stack([np.sin(_ANGLES), np.cos(_ANGLES)], axis=1)
_FAR = 1024.0  # numerical
_OFF = np.sqrt(np.arange(4.0).astype(np.float32))  # given: distances that codes stand for [cells]
# Numerical: samples on the arc, from its middle on; the ends merge with leaf and jamb.
_ARC_DEG = (45.0, 25.0, 65.0, 10.0, 35.0, 55.0, 75.0, 18.0, 30.0, 40.0, 50.0, 60.0, 70.0, 82.0)
# Numerical: their places on a circle of radius 1.
_ARC = np.stack([np.cos(np.radians(_ARC_DEG)), np.sin(np.radians(_ARC_DEG))], axis=1)
# Numerical: sample positions on leaves, as shares of their length.
_LEAF = (0.35, 0.45, 0.55, 0.65, 0.75)
# Chosen: largest mean deviation of leaf and arc [cells].
_MAX_MISFIT = 0.7
# Numerical: samples in a symbol that must be blank: angles from the leaf, shares of the radius.
_SECTOR_DEG = (25.0, 35.0, 45.0, 55.0, 65.0)
_SECTOR = (0.35, 0.5, 0.65)  # numerical
# The doorway is open this deep behind the leaf's line [m].
_DEPTH_M = 0.2
# Largest share of the blank samples that crossing lines and letters may cover.
_MAX_CLUTTER = 0.07
# Symbols whose leaf tips are closer than this are one [m].
_APART_M = 0.25
# Ink this close to a symbol's lines belongs to it [cells].
_PEN_CELLS = 1
# Length kept of a leaf at its hinge and of an arc at its jamb, so that walls stay closed [cells].
_STUB = 1.5

Array = NDArray[np.float64]
Codes = NDArray[np.uint8]
"""Squared distances (H, W) to the nearest drawn cell, see ``near_code``."""


def erase_door_symbols(free: Mask, cell_m: float) -> Mask:
    """
    Return ``free (H, W)`` with the leaves and arcs of doors turned into free space.

    A symbol is a straight stroke of 0.6 to 1.6 m, the leaf, with a quarter circle around its hinge
    that runs from its other end across an open doorway. Both are thin lines and most of the sector
    between them is empty. A drawing without such symbols is returned unchanged; ``cell_m`` is the
    cell edge [m].
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
    margin = int(np.ceil(np.sqrt(2.0) * last + _FLANK)) + 1
    near_lines, near_ink = (np.pad(near_code(mask), margin, mode='edge') for mask in (lines, ink))
    blanks = _blanks(first, last, _DEPTH_M / cell_m)
    found = _search(near_lines, near_ink, cells_of(lines) + margin, first, blanks)
    found[:, 1:3] -= margin
    return found


@lru_cache(maxsize=4)
def _blanks(first: int, last: int, depth: float) -> Array:
    """Return the places of :func:`_blank_places` for all radii; callers must not modify it."""
    return np.array([_blank_places(radius, depth) for radius in range(first, last)])


def _blank_places(radius: float, depth: float) -> Array:
    """
    Return places (4, 15, 2) where a symbol is blank, [cells] from its hinge.

    Axes are along the leaf and towards the jamb. The places lie in the sector, beside the arc,
    beside the leaf, and in the doorway.
    """
    turn, share = np.meshgrid(np.radians(_SECTOR_DEG), _SECTOR)
    sector = radius * np.stack([share * np.cos(turn), share * np.sin(turn)], axis=-1)
    turn, reach = np.meshgrid(np.radians(_SECTOR_DEG), radius + _FLANK * np.array([-1, 1, 1]))
    arc = np.stack([reach * np.cos(turn), reach * np.sin(turn)], axis=-1)
    along, across = np.meshgrid(radius * np.array(_LEAF), _FLANK * np.array([-1, 1, -1]))
    leaf = np.stack([along, across], axis=-1)
    across, behind = np.meshgrid(radius * np.array(_LEAF), -depth * np.array([0.0, 0.5, 1.0]))
    doorway = np.stack([behind, across], axis=-1)
    return np.stack([part.reshape(-1, 2) for part in (sector, arc, leaf, doorway)])


def _search(lines: Codes, ink: Codes, tips: NDArray[np.int64], first: int, blanks: Array) -> Array:
    """
    Try each cell of a line as a leaf's tip, in all directions and with both sides.

    ``lines`` and ``ink`` hold squared distances up to 2, or 3, with a margin all around. Returns
    symbols (N, 6), by direction.
    """
    tip, way, misfit = _straight(ink, tips, first, first + len(blanks) - 1)
    line, longer = np.nonzero(np.isfinite(misfit[:, first - 1 :]))
    length, misfit = longer + first, misfit[line, longer + first - 1]
    tip, u, angle = tips[tip[line]].astype(np.float64), _UNITS[way[line]], _ANGLES[way[line]]
    hinges = tip - length[:, None] * u
    arcs = np.empty((len(line), 2))
    _arc_misfits(unwritable(lines), hinges, u, length, _ARC, arcs)
    score = misfit[:, None] / length[:, None] + arcs
    found, which = np.nonzero(score <= _MAX_MISFIT)
    side = 2.0 * which - 1.0
    v = side[:, None] * np.stack([u[found, 1], -u[found, 0]], axis=1)
    is_blank = _is_blank(ink, hinges[found], u[found], v, blanks[longer[found]])
    found, score, side = found[is_blank], score[found, which][is_blank], side[is_blank]
    symbols = np.column_stack([score, tip[found], angle[found], length[found], side])
    return np.asarray(symbols[np.lexsort([found, angle[found]])])


def _straight(
    ink: Codes, tips: NDArray[np.int64], first: int, last: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """
    Return the straight lines of ``first`` to ``last`` cells that end at ``tips (K, 2)``.

    Indices of their tips and directions (N,), and the total deviation of a line by its length in
    cells (N, last), infinite where none is drawn.
    """
    flat, cols = ink.reshape(-1), ink.shape[1]
    cells = tips[:, 0] * cols + tips[:, 1]
    # Whole cells are looked up in the flattened raster. The large offset rounds ties between two
    # cells the same way as at the tips.
    steps = np.floor(_FAR - np.arange(1, last + 1)[:, None, None] * _UNITS + 0.5) - _FAR
    steps = (steps[..., 0] * cols + steps[..., 1]).astype(np.int64)
    beyond, least = (
        np.floor(by * _UNITS + 0.5).astype(np.int64) @ (cols, 1) for by in (_FLANK, -first)
    )
    is_line = np.zeros((len(cells), _DIRECTIONS), np.bool_)
    _mark_lines(unwritable(flat), cells, steps[:first], beyond, least, is_line)
    tip, way = np.divmod(np.flatnonzero(is_line), _DIRECTIONS)
    codes = flat[cells[tip][:, None] + steps[:, way].T]
    misfit = np.cumsum(_OFF[codes], axis=1, dtype=np.float64)
    misfit[np.logical_or.accumulate(codes > _NEAR, axis=1)] = np.inf
    return tip, way, misfit


@njit(cache=True, nogil=True)
def _mark_lines(ink, cells, steps, beyond, least, is_line):  # type: ignore[no-untyped-def]
    """Mark directions with ink at all ``steps (S, D)`` from the tips and none beyond the tips."""
    for tip in range(len(cells)):
        for way in range(len(least)):
            if ink[cells[tip] + beyond[way]] <= _NEAR or ink[cells[tip] + least[way]] > _NEAR:
                continue
            step = 0
            while step < len(steps) and ink[cells[tip] + steps[step, way]] <= _NEAR:
                step += 1
            is_line[tip, way] = step == len(steps)


@njit(cache=True, nogil=True)
def _arc_misfits(lines, hinges, u, radii, arc, misfits):  # type: ignore[no-untyped-def]
    """Write mean distances (N, 2) [cells] of both sides' arcs from lines, infinite without one."""
    for n in range(len(hinges)):
        for which in range(2):
            side, total = 2.0 * which - 1.0, 0.0
            for k in range(len(arc)):
                a, b = radii[n] * arc[k, 0], radii[n] * arc[k, 1] * side
                row = hinges[n, 0] + a * u[n, 0] + b * u[n, 1]
                code = lines[int(row + 0.5), int(hinges[n, 1] + a * u[n, 1] - b * u[n, 0] + 0.5)]
                total += np.sqrt(np.float32(code))
                if code > _NEAR:
                    total = np.inf
                    break
            misfits[n, which] = total / len(arc)


def _is_blank(ink: Codes, origins: Array, u: Array, v: Array, blanks: Array) -> Mask:
    """Return whether almost no place of each of ``blanks (N, 4, K, 2)``, in u and v, holds ink."""
    along, across = blanks[..., :1] * u[:, None, None], blanks[..., 1:] * v[:, None, None]
    row, col = cells_at(origins[:, None, None] + along + across, ink.shape)
    clutter = (ink[row, col] == 0).sum(axis=2)
    return np.asarray((clutter <= _MAX_CLUTTER * blanks.shape[2]).all(axis=1))


def _distinct(found: Array, apart: float) -> Array:
    """Return the best fitting symbol of each group with nearly the same tip."""
    ordered = found[np.argsort(found[:, 0], kind='stable')]
    tips = ordered[:, 1:3]

    def is_same(index: int, others: NDArray[np.int64]) -> Mask:
        return np.asarray(np.hypot(*(tips[others] - tips[index]).T) <= apart)

    return ordered[first_distinct(len(ordered), is_same)]


def _drawn(symbols: Array, shape: tuple[int, ...]) -> Mask:
    """Return the cells of leaves and arcs (N, 6), drawn with a pen that covers their lines."""
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
