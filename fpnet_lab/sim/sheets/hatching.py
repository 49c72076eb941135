# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Vectorized hatching and patterns in polygons."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fpnet_lab.sim.sheets.artwork import Array

_MOST_STROKES = 600  # numerical: finer hatching is coarsened


def turned(angle_rad: float) -> Array:
    """Return the matrix (2, 2) with the axes of a rotated frame as rows."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, s], [-s, c]])


def hatched(rings: Sequence[Array], angle_rad: float, spacing_m: float) -> Array:
    """Return parallel strokes (K, 2, 2) [m] that fill rings (V, 2); inner rings are holes."""
    none = np.zeros((0, 2, 2))
    if not any(len(ring) for ring in rings):
        return none
    R = turned(angle_rad)
    a = np.concatenate(list(rings)) @ R.T
    b = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings]) @ R.T
    low, high = float(a[:, 1].min()), float(a[:, 1].max())
    spacing_m = max(spacing_m, (high - low) / _MOST_STROKES)
    at = np.arange(np.ceil(low / spacing_m), np.ceil(high / spacing_m)) * spacing_m
    if not len(at):
        return none
    crosses = (a[:, 1] <= at[:, None]) != (b[:, 1] <= at[:, None])
    rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
    x = a[:, 0] + (at[:, None] - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    x = np.sort(np.where(crosses, x, np.inf), axis=1)
    pairs = int(crosses.sum(axis=1).max()) // 2
    starts, ends = x[:, 0 : 2 * pairs : 2], x[:, 1 : 2 * pairs : 2]
    row, column = np.nonzero(np.isfinite(ends))
    y = at[row]
    first = np.stack([starts[row, column], y], axis=1)
    last = np.stack([ends[row, column], y], axis=1)
    return np.asarray(np.stack([first, last], axis=1) @ R)


def chord(ring: Array, xy: Array, along: Array) -> tuple[Array, Array] | None:
    """Return the two points where a line through a point inside a ring meets the ring."""
    across = np.array([-along[1], along[0]])
    offset = (ring - xy) @ np.stack([along, across]).T
    nxt = np.roll(offset, -1, axis=0)
    crosses = (offset[:, 1] <= 0.0) != (nxt[:, 1] <= 0.0)
    p, q = offset[crosses], nxt[crosses]
    if not len(p):
        return None
    x = p[:, 0] - p[:, 1] / (q[:, 1] - p[:, 1]) * (q[:, 0] - p[:, 0])
    before, after = x[x < 0.0], x[x > 0.0]
    if not len(before) or not len(after):
        return None
    return xy + before.max() * along, xy + after.min() * along


def pattern(ring: Array, angle_rad: float, cell: Array, size: Array, row_shift: float) -> Array:
    """
    Return copies (K, 2, 2) [m] of a pattern cell's strokes that are inside a ring.

    Parameters
    ----------
    ring : (V, 2)
        Outline of the filled area [m].
    angle_rad : direction of the pattern's rows
    cell : (C, 2, 2)
        Strokes of one cell [m], relative to its lower left corner.
    size : (2,)
        Size of the cell [m].
    row_shift : offset of each row relative to the row below, as a share of a cell
    """
    R = turned(angle_rad)
    local = ring @ R.T
    low = np.floor(local.min(axis=0) / size) - 1
    high = np.ceil(local.max(axis=0) / size) + 1
    columns, rows = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    shift = (rows * row_shift) % 1.0
    corners = np.stack([(columns + shift).ravel(), rows.ravel()], axis=1) * size
    strokes = (corners[:, None, None] + cell).reshape(-1, 2, 2) @ R
    shape = shapely.Polygon(ring)
    shapely.prepare(shape)
    is_within = shapely.contains_xy(shape, strokes[..., 0], strokes[..., 1])
    return np.asarray(strokes[is_within.all(axis=1)])
