# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Windows and entrances in the outer walls of a varied sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_lab.sim.sheets.artwork import Array
from fpnet_lab.sim.sheets.interior_style import InteriorStyle

_PROBE_M = 0.05  # numerical
_OVERLAP_M = 0.05  # numerical: overlap of an opening with the room
# Chosen, not measured:
_LEAST_EDGE_M, _LEAST_PANE_M = 0.9, 0.4
_ENTRANCE_M = (0.9, 2.4)
_JAMB_M = 0.25  # between an entrance and the ends of its wall


@dataclass(frozen=True, eq=False)
class Facade:
    """
    Openings in outer walls [m, page].

    ``panes (N, 4, 2)`` are windows, ``entrances (M, 4, 2)`` are doors, each with two corners on
    the room's outline and two outside.
    """

    panes: Array
    entrances: Array


def draw_facade(
    rooms: list[Array],
    depth_m: float,
    shell: BaseGeometry,
    style: InteriorStyle,
    has_windows: bool,
) -> Facade:
    """Return the openings in walls ``depth_m`` thick between rooms (V, 2) and the outside."""
    none = np.zeros((0, 4, 2))
    edges = _outer_edges(rooms, depth_m, shell)
    if not len(edges):
        return Facade(none, none)
    rng = np.random.default_rng(style.seed)
    lengths = np.hypot(*(edges[:, 1] - edges[:, 0]).T)
    fits = np.flatnonzero(lengths > _ENTRANCE_M[0] + 2.0 * _JAMB_M)
    doors = rng.permutation(fits)[: style.entrances]
    entrances = [_entrance(edges[i], float(lengths[i]), depth_m, rng) for i in doors.tolist()]
    panes = [none]
    if has_windows:
        taken = {*doors.tolist()}
        panes += [_panes(edge, depth_m, style) for i, edge in enumerate(edges) if i not in taken]
    return Facade(np.concatenate(panes), np.stack(entrances) if entrances else none)


def _outer_edges(rooms: list[Array], depth_m: float, shell: BaseGeometry) -> Array:
    """Return the room edges (E, 2, 2) that face the outside."""
    edges = np.concatenate([np.stack([r, np.roll(r, -1, axis=0)], axis=1) for r in rooms])
    along = edges[:, 1] - edges[:, 0]
    length = np.hypot(*along.T)
    edges, along = edges[length > _LEAST_EDGE_M], along[length > _LEAST_EDGE_M]
    along /= length[length > _LEAST_EDGE_M, None]
    out = np.stack([along[:, 1], -along[:, 0]], axis=1) * (depth_m + _PROBE_M)
    shapely.prepare(shell)
    shares = np.array([0.05, 0.35, 0.65, 0.95])[:, None, None]
    beyond = edges[:, 0] + shares * (edges[:, 1] - edges[:, 0]) + out
    is_inside = shapely.contains_xy(shell, beyond[..., 0], beyond[..., 1])
    return np.asarray(edges[~is_inside.any(axis=0)])


def _opening(edge: Array, start_m: Array, end_m: Array, depth_m: float, into_m: float) -> Array:
    along = (edge[1] - edge[0]) / np.linalg.norm(edge[1] - edge[0])
    out = np.array([along[1], -along[0]])
    a, b = edge[0] + start_m[:, None] * along, edge[0] + end_m[:, None] * along
    near, far = -into_m * out, depth_m * out
    return np.stack([a + near, b + near, b + far, a + far], axis=1)


def _entrance(edge: Array, length: float, depth_m: float, rng: np.random.Generator) -> Array:
    width = min(float(rng.uniform(*_ENTRANCE_M)), length - 2.0 * _JAMB_M)
    start = float(rng.uniform(_JAMB_M, max(length - _JAMB_M - width, _JAMB_M + 1e-6)))
    ends = np.array([start]), np.array([start + width])
    return np.asarray(_opening(edge, *ends, depth_m, _OVERLAP_M)[0])


def _panes(edge: Array, depth_m: float, style: InteriorStyle) -> Array:
    """Return the windows (N, 4, 2) of one wall, in a row."""
    paint, length = style.windows, float(np.linalg.norm(edge[1] - edge[0]))
    usable = paint.share * length
    count = max(1, int(np.ceil((usable + paint.gap_m) / (paint.longest_m + paint.gap_m))))
    width = (usable - (count - 1) * paint.gap_m) / count
    if width < _LEAST_PANE_M:
        count, width = 1, min(usable, paint.longest_m)
    pitch = width + paint.gap_m
    first = (length - (count * pitch - paint.gap_m)) / 2.0
    starts = np.asarray(first + pitch * np.arange(count), np.float64)
    return _opening(edge, starts, np.asarray(starts + width, np.float64), depth_m, 0.0)
