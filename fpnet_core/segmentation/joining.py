# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Greedy merging of free-space pieces into rooms, most probable merge first.

A model scores every candidate dividing line, with features of the pieces on both sides as merged
so far. After each merge, the lines of the merged pieces are scored again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.pieces import label_figures
from fpnet_core.raster.windows import cells_of

Array = NDArray[np.float64]
JoinModel = Callable[[Array], Array]
"""Returns the probability (L,) that lines of figures (L, D) divide nothing."""

_ROOMS = ('area', 'peak', 'frontier', 'fill', 'long', 'wide', 'lines')
ROOM_FIGURES = (
    *(f'{name}_{which}' for which in ('small', 'large') for name in _ROOMS),
    'fill_both', 'long_both', 'wide_both', 'over_peak', 'over_wide', 'beside', 'widest_beside',
)  # fmt: skip
"""Features of the pieces beside a line, the smaller first, and of both as one."""

_EVEN = 0.5  # given: pieces merge if that is more probable than not
# Numerical: lower bounds of divisors [m2, m, m2, m2].
_LEAST_M2, _LEAST_M, _LEAST_VARIANCE_M2, _NOTHING_M2 = 0.05, 0.05, 1e-4, 1e-9


@dataclass(frozen=True, eq=False)
class Pieces:
    """
    Additive statistics of pieces of free space; index 0 is no piece.

    ``moments (P, 6)`` are area [m2] and sums of row, column and their products [m], ``peak (P,)``
    the largest clearance [m], ``frontier (P,)`` the length of the edge to unseen space [m].
    """

    moments: Array
    peak: Array
    frontier: Array

    @classmethod
    def of(
        cls, labels: NDArray[np.int32], clearance: NDArray[np.float32],
        frontier: NDArray[np.bool_], cell_m: float,
    ) -> Pieces:  # fmt: skip
        """Return the pieces of ``labels (h, w)`` with cells of ``cell_m``."""
        rows, cols = cells_of(labels != 0).T
        piece = labels[rows, cols]
        count = int(piece.max(initial=0)) + 1
        r, c = rows * cell_m, cols * cell_m
        sums = [np.bincount(piece, weights, count) for weights in (r, c, r * r, r * c, c * c)]
        moments = cell_m**2 * np.stack([np.bincount(piece, minlength=count), *sums], axis=1)
        _, peak = label_figures(labels, clearance, count)
        peak[0] = 0.0
        edge = np.bincount(piece[frontier[rows, cols]], minlength=count)
        return cls(moments, peak.astype(np.float64), np.asarray(cell_m * edge))

    def joined(self, target: NDArray[np.int64]) -> Pieces:
        """Return the pieces merged into their ``target (P,)``; all others are empty."""
        moments, frontier = np.zeros_like(self.moments), np.zeros_like(self.frontier)
        peak = np.zeros_like(self.peak)
        np.add.at(moments, target, self.moments)
        np.add.at(frontier, target, self.frontier)
        np.maximum.at(peak, target, self.peak)
        return Pieces(moments, peak, frontier)


@dataclass(frozen=True, eq=False)
class DividingLines:
    """Lines between pieces: ``pieces (L, 2)``, ``width_m (L,)`` and features (L, D)."""

    pieces: NDArray[np.int64]
    width_m: Array
    figures: Array


def join_pieces(pieces: Pieces, lines: DividingLines, is_one: JoinModel) -> NDArray[np.int64]:
    """
    Return, for each piece (P,), the piece that it merged into, mostly itself.

    Two pieces merge if their line more probably divides nothing and is the most probable such line
    of both. All lines are then scored again.
    """
    target = np.arange(len(pieces.peak))
    for stage in joining_stages(pieces, lines, is_one):
        target = stage
    return target


def joining_stages(
    pieces: Pieces, lines: DividingLines, is_one: JoinModel
) -> Iterator[NDArray[np.int64]]:
    """Yield the targets of :func:`join_pieces` after each round of merges."""
    target = np.arange(len(pieces.peak))
    probability = np.zeros(len(lines.width_m))
    before = np.full((len(lines.width_m), lines.figures.shape[1] + len(ROOM_FIGURES)), np.nan)
    while True:
        pair = target[lines.pieces]
        live = np.flatnonzero(pair[:, 0] != pair[:, 1])
        if not len(live):
            return
        pair = pair[live]
        figures = figures_now(pieces.joined(target), pair, lines, live)
        # Most lines have not changed since they were scored last.
        is_new = (figures != before[live]).any(axis=1)
        if is_new.any():
            probability[live[is_new]] = is_one(figures[is_new])
            before[live] = figures
        now = probability[live]
        best = np.zeros(len(target))
        np.maximum.at(best, pair.ravel(), np.repeat(now, 2))
        chosen = (now > _EVEN) & (now >= best[pair].max(axis=1))
        if not chosen.any():
            return
        target = target.copy()
        for a, b in pair[chosen].tolist():
            keep, gone = target[a], target[b]  # an equal line may have merged them already
            target[target == gone] = keep
        yield target


def absorb_small(
    pieces: Pieces,
    lines: DividingLines,
    target: NDArray[np.int64],
    least_m2: float,
    frontier_m: float,
) -> NDArray[np.int64]:
    """
    Return ``target (P,)`` after pieces below ``least_m2`` merge across their widest line.

    Pieces with a longer edge to unseen space stay: a glimpse through a door is not part of the
    room in front of it.
    """
    now, target = pieces.joined(target), target.copy()
    area, frontier = now.moments[:, 0], now.frontier
    order = lines.pieces[np.argsort(-lines.width_m, kind='stable')]
    absorbing = True
    while absorbing:
        absorbing = False
        for a, b in order.tolist():
            here, there = target[a], target[b]
            is_small = (area < least_m2) & (frontier <= frontier_m)
            if here != there and (is_small[here] or is_small[there]):
                target[target == there] = here
                area[here] += area[there]
                frontier[here] += frontier[there]
                absorbing = True
    return target


def figures_now(
    now: Pieces, pair: NDArray[np.int64], lines: DividingLines, live: NDArray[np.int64]
) -> Array:
    """Return all features (K, D) of the lines ``live (K,)`` between the pieces ``pair (K, 2)``."""
    area = now.moments[:, 0]
    swap = area[pair[:, 0]] > area[pair[:, 1]]
    pair = np.where(swap[:, None], pair[:, ::-1], pair)
    count = np.bincount(pair.ravel(), minlength=len(area)).astype(np.float64)
    shape = _shape(now.moments)
    single = np.column_stack(
        [np.log(np.maximum(area, _LEAST_M2)), now.peak,
         now.frontier / np.sqrt(np.maximum(area, _LEAST_M2)), shape, count]
    )  # fmt: skip
    both = _shape(now.moments[pair[:, 0]] + now.moments[pair[:, 1]])
    width = lines.width_m[live]
    peak = np.minimum(now.peak[pair[:, 0]], now.peak[pair[:, 1]])
    wide = np.minimum(shape[pair[:, 0], 2], shape[pair[:, 1], 2])
    beside, widest = _parallel(pair, width, len(area))
    return np.column_stack(
        [lines.figures[live], single[pair[:, 0]], single[pair[:, 1]], both,
         0.5 * width / np.maximum(peak, _LEAST_M), width / np.maximum(wide, _LEAST_M),
         beside, widest]
    )  # fmt: skip


def _parallel(pair: NDArray[np.int64], width: Array, count: int) -> tuple[Array, Array]:
    """Return the number of other lines between the same pieces, and log(widest / own width)."""
    key = pair.min(axis=1) * count + pair.max(axis=1)
    _, number = np.unique(key, return_inverse=True)
    widest = np.zeros(number.max(initial=0) + 1)
    np.maximum.at(widest, number, width)
    over = np.log(widest[number] / np.maximum(width, _LEAST_M))
    beside = np.bincount(number)[number] - 1.0
    return np.asarray(beside, np.float64), np.asarray(over)


def _shape(moments: Array) -> Array:
    """
    Return how much of its box a piece fills (1 for a rectangle), log length, and width [m].

    The box is the rectangle of equal second moments.
    """
    area = np.maximum(moments[:, 0], _NOTHING_M2)
    r, c = moments[:, 1] / area, moments[:, 2] / area
    rr, rc, cc = (moments[:, k] / area for k in (3, 4, 5))
    rr, rc, cc = rr - r * r, rc - r * c, cc - c * c
    middle, spread = 0.5 * (rr + cc), np.hypot(0.5 * (rr - cc), rc)
    long = np.sqrt(12.0 * np.maximum(middle + spread, _LEAST_VARIANCE_M2))
    wide = np.sqrt(12.0 * np.maximum(middle - spread, _LEAST_VARIANCE_M2))
    return np.stack([moments[:, 0] / (long * wide), np.log(long), wide], axis=1)
