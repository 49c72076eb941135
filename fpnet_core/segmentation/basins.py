# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Watershed of the clearance, and merging of its basins across shallow saddles."""

from __future__ import annotations

from dataclasses import dataclass

from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.pieces import label_figures
from fpnet_core.raster.windows import NEIGHBOURS, first_of_each
from fpnet_core.segmentation.scene import WorkRaster

# Openings up to this width are judged as doors; fitted to the tune half (docs/segmentation.md).
_NARROW_WIDTH_M = 1.4
# Narrow opening over narrower room above which they join;
# fitted to the tune half (docs/segmentation.md).
_NARROW_MERGE_RATIO = 0.9
# The same for wider openings; fitted to the tune half (docs/segmentation.md).
_WIDE_MERGE_RATIO = 0.8
# Wider openings join both sides into one room; fitted to the tune half (docs/segmentation.md).
_OPEN_WIDTH_M = 2.5
_MERGE_DEPTH_M = 0.1  # numerical: shallower constrictions are of the raster
# Small rooms with a longer edge to unseen space stay apart;
# fitted to the tune half (docs/segmentation.md).
_GLIMPSE_EDGE_M = 0.8

# Numerical: clearances are ordered in steps of a millimetre: radix sort, and no ties decided by
# rounding.
_STEP_M = 1e-3


@dataclass(frozen=True, eq=False)
class Basins:
    """
    Catchment areas of the clearance's maxima.

    ``labels (h, w)`` int32 is basin index + 1, 0 outside the mask; ``peaks (B,)`` is the
    largest clearance of each basin [m]; ``areas (B,)`` its size and ``frontiers (B,)`` its
    border to unseen space, both in working cells.
    """

    labels: NDArray[np.int32]
    peaks: NDArray[np.float32]
    areas: NDArray[np.int64]
    frontiers: NDArray[np.int64]


@njit(cache=True)
def _flood(
    height: NDArray[np.float32],
    mask: NDArray[np.bool_],
    order: NDArray[np.int64],
    labels: NDArray[np.int32],
) -> int:
    """
    Label cells in descending order by their highest labelled neighbour; count the basins.

    Diagonal neighbours count only beside a free cell: a wall drawn as a diagonal line of single
    cells is closed.
    """
    cols = height.shape[1]
    count = 0
    for index in order:
        row, col = index // cols, index % cols
        best = np.int32(0)
        best_height = np.float32(-1.0)
        for d_row in range(-1, 2):
            for d_col in range(-1, 2):
                label = labels[row + d_row, col + d_col]
                if label == 0 or height[row + d_row, col + d_col] <= best_height:
                    continue
                if mask[row + d_row, col] or mask[row, col + d_col]:
                    best = label
                    best_height = height[row + d_row, col + d_col]
        if best == 0:
            count += 1
            best = np.int32(count)
        labels[row, col] = best
    return count


def grow_basins(work: WorkRaster) -> Basins:
    """
    Cut the working raster into one basin per local maximum of the clearance.

    Cells join the basin of their steepest ascent, visited from the widest place to the
    narrowest: a watershed without markers. Zero free cells give zero basins.
    """
    mask = np.pad(work.mask, 1)
    height = np.pad(work.clearance, 1)
    cells = np.flatnonzero(mask)
    steps = np.minimum(height.ravel()[cells] / _STEP_M, 65535).astype(np.uint16)
    order = cells[np.argsort(65535 - steps, kind='stable')]
    labels = np.zeros(mask.shape, dtype=np.int32)
    count = _flood(height, mask, order, labels)
    areas, peaks = label_figures(labels, height, count + 1)
    inner = np.ascontiguousarray(labels[1:-1, 1:-1])
    frontiers = np.bincount(inner[work.frontier], minlength=count + 1)[1:]
    return Basins(inner, peaks[1:], areas[1:], frontiers)


def find_saddles(
    labels: NDArray[np.int32], clearance: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """
    Return the pairs of touching labels and the widest place of each shared boundary.

    Returns
    -------
    pairs (E, 2) int64 : labels, smaller first, each pair once; widest boundary first
    saddles (E,) float32 : clearance there [m], descending
    """
    keys, values = [], []
    base = int(labels.max(initial=0)) + 1
    for here, there in NEIGHBOURS:
        a, b = labels[here], labels[there]
        meet = (a != b) & (a > 0) & (b > 0)
        low, high = np.minimum(a[meet], b[meet]), np.maximum(a[meet], b[meet])
        keys.append(low.astype(np.int64) * base + high)
        values.append(np.minimum(clearance[here][meet], clearance[there][meet]))
    key, value = np.concatenate(keys), np.concatenate(values)
    widest = first_of_each(key, np.lexsort((key, -value)))
    pairs = key[widest]
    return np.stack([pairs // base, pairs % base], axis=1), value[widest]


class _Groups:
    """Union-find over labels that keeps each group's peak, area and frontier."""

    def __init__(self, basins: Basins) -> None:
        self.parent = list(range(len(basins.peaks) + 1))
        self.peak = [0.0, *basins.peaks.tolist()]
        self.area = [0, *basins.areas.tolist()]
        self.frontier = [0, *basins.frontiers.tolist()]

    def root(self, label: int) -> int:
        while self.parent[label] != label:
            self.parent[label] = self.parent[self.parent[label]]
            label = self.parent[label]
        return label

    def join(self, a: int, b: int) -> None:
        keep, gone = (a, b) if self.peak[a] >= self.peak[b] else (b, a)
        self.parent[gone] = keep
        self.area[keep] += self.area[gone]
        self.frontier[keep] += self.frontier[gone]


def is_one_room(saddle_m: float, peak_m: float) -> bool:
    """
    Tell whether an opening is too wide or too shallow to separate two rooms.

    ``saddle_m`` is the clearance at the opening (half its width), ``peak_m`` the clearance in
    the narrower of both rooms.
    """
    width = 2.0 * saddle_m
    narrow = width <= _NARROW_WIDTH_M
    ratio = _NARROW_MERGE_RATIO if narrow else _WIDE_MERGE_RATIO
    return width > _OPEN_WIDTH_M or saddle_m > ratio * peak_m or peak_m - saddle_m < _MERGE_DEPTH_M


def merge_basins(basins: Basins, work: WorkRaster, min_area_m2: float) -> NDArray[np.int32]:
    """
    Join basins into rooms; returns room labels (h, w), 1..R without gaps, 0 outside.

    Saddles are visited from the widest to the narrowest and joined by :func:`is_one_room`;
    then rooms below ``min_area_m2`` join the neighbour with the widest opening, unless unseen
    space cuts them short: a glimpse through a door is no part of the room in front. That is the
    paper's breadth-first clustering "room - connection - room" (section III-B): regions above
    ``a_th = min_area_m2`` are seeds, smaller candidates are collected across their widest
    connection, and growth stops at other seeds and at closed (lintel) doorways.
    """
    pairs, saddles = find_saddles(basins.labels, work.clearance)
    groups = _Groups(basins)
    edges = [(*pair, s) for pair, s in zip(pairs.tolist(), saddles.tolist(), strict=True)]
    for left, right, saddle in edges:
        a, b = groups.root(left), groups.root(right)
        if a != b and is_one_room(saddle, min(groups.peak[a], groups.peak[b])):
            groups.join(a, b)
    _absorb_small(groups, edges, min_area_m2 / work.cell_m**2, _GLIMPSE_EDGE_M / work.cell_m)
    roots = np.array([groups.root(label) for label in range(len(groups.parent))])
    keep = np.array([label for label in np.unique(roots) if label and groups.area[label] >= 1])
    relabel = np.zeros(len(roots), dtype=np.int32)
    for number, root in enumerate(keep.tolist(), start=1):
        relabel[roots == root] = number
    return np.asarray(relabel[basins.labels], dtype=np.int32)


def _absorb_small(
    groups: _Groups, edges: list[tuple[int, int, float]], min_cells: float, max_frontier: float
) -> None:
    """Join small groups across their widest saddle until none is left that may be joined."""
    absorbing = True
    while absorbing:
        absorbing = False
        for left, right, _ in edges:
            a, b = groups.root(left), groups.root(right)
            small = [
                g
                for g in (a, b)
                if groups.area[g] < min_cells and groups.frontier[g] <= max_frontier
            ]
            if a != b and small:
                groups.join(a, b)
                absorbing = True
