# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scale-free node rows: the input of the ``fpnet`` preset.

Every length is divided by the graph's own unit, roughly the width of a door, so a map in pixels
gives the same rows as one in metres. The first four columns, position and axis, rotate with the
map. The network only uses distances and relative angles from them, so its input is invariant to
rotation, translation and uniform scale of either map.

======= ============ ======================================================================
columns name         value
======= ============ ======================================================================
0:2     ``POSITION`` centre relative to the graph's, in tens of units
2:4     ``AXIS``     ``e (cos 2a, sin 2a)`` of the long axis at angle a; elongation e in [0, 1]
4:6     label        one-hot: door, room
6       long side    logarithm of the enclosing rectangle's long side; a door's width
7       short side   logarithm of its short side; rooms only
8       size         half the logarithm of the area; rooms only
9       filling      area over that of the rectangle; rooms only
10:13   seen         observed fraction, frontier fraction, confidence
13:16   doors        of a room: log(1 + number), mean and largest log width; 0 without doors
16:18   side         one-hot: plan, submap
18:40   shape        Hu moments and Fourier descriptors as in schema 1; rooms only
======= ============ ======================================================================
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.graphs.features import FOURIER, HU, KEPT_OUTLINES
from fpnet_core.graphs.layout import POSITION, FeatureLayout
from fpnet_core.types import RegionGraph, RegionLabel

Array = NDArray[np.float64]

AXIS = slice(2, 4)
_LABEL, _SIZES, _SEEN = slice(4, 6), slice(6, 10), slice(10, 13)
_DOORS, _SIDE, _SHAPE = slice(13, 16), slice(16, 18), slice(18, 40)
_HU_SKEW = _SHAPE.start + 6  # given: the seventh Hu moment distinguishes mirror images

# Given.
INVARIANT_LAYOUT = FeatureLayout(
    size=_SHAPE.stop,
    odd=(0, AXIS.start + 1, _HU_SKEW),
    log_lengths=(6, 7, 8, 14, 15),
    noisy=_SIZES,
    axis=AXIS,
)

POSITION_UNITS = 10.0
"""Length, in units, that becomes 1 in node positions. Chosen."""

SHORT_SIDE_UNITS = 4.5
"""Typical short side of a room in door widths; estimates the unit without doors. Chosen."""

# Chosen, not measured:
_ROOM_WEIGHT = 0.2  # weight of a room relative to a door in the weighted median of the unit
_ROOM_LOG_SIZE = 1.5  # typical logarithm of a room's sides in units, subtracted from its sizes
_SMALLEST = 1e-6  # numerical: least side of degenerate outlines, in the outline's unit of length


def invariant_rows(graph: RegionGraph) -> NDArray[np.float32]:
    """Return the rows ``(R, 40) float32`` of ``graph``; ``(0, 40)`` for an empty one."""
    rows = np.zeros((len(graph), INVARIANT_LAYOUT.size))
    if not len(graph):
        return rows.astype(np.float32)
    is_door = door_mask(graph)
    _, sides, angle = enclosing_rectangles(graph)
    area = np.array([region.area_m2 for region in graph.regions])
    unit = length_unit(sides, is_door)
    centroid = np.array([region.centroid for region in graph.regions])
    rows[:, POSITION] = (centroid - area @ centroid / area.sum()) / (unit * POSITION_UNITS)
    elongation = np.where(is_door, 1.0, 1.0 - sides[:, 1] / sides[:, 0])
    rows[:, AXIS] = elongation[:, None] * np.stack([np.cos(2 * angle), np.sin(2 * angle)], axis=1)
    rows[:, _LABEL] = np.stack([is_door, ~is_door], axis=1)
    rows[:, _SIZES] = _sizes(sides / unit, area / unit**2, is_door)
    rows[:, _SEEN] = [
        (r.observed_fraction, r.frontier_fraction, r.confidence) for r in graph.regions
    ]
    rows[:, _DOORS] = _adjacent_doors(graph, np.log(sides[:, 0] / unit), is_door)
    rows[:, _SIDE] = (graph.frame == 'plan', graph.frame != 'plan')
    shape = np.concatenate([graph.node_feat[:, HU], graph.node_feat[:, FOURIER]], axis=1)
    rows[:, _SHAPE] = np.where(is_door[:, None], 0.0, shape)
    return rows.astype(np.float32)


def door_mask(graph: RegionGraph) -> NDArray[np.bool_]:
    """Return which regions are doors, ``(R,)``."""
    return np.array([region.label is RegionLabel.DOOR for region in graph.regions], dtype=bool)


def enclosing_rectangles(graph: RegionGraph) -> tuple[Array, Array, Array]:
    """Return centres ``(R, 2)``, sides ``(R, 2)``, longer first, and long axes ``(R,)`` [rad]."""
    found = [_rectangle(r.polygon.tobytes(), r.centroid.tobytes()) for r in graph.regions]
    figures = np.array(found, dtype=np.float64).reshape(-1, 5)
    return figures[:, :2], np.maximum(figures[:, 2:4], _SMALLEST), figures[:, 4]


@lru_cache(maxsize=KEPT_OUTLINES)
def _rectangle(polygon: bytes, centroid: bytes) -> tuple[float, ...]:
    """Return centre, longer and shorter side and long axis; cached, since rooms recur."""
    middle = np.frombuffer(centroid)
    # Centred first: OpenCV computes in single precision.
    outline = (np.frombuffer(polygon).reshape(-1, 2) - middle).astype(np.float32)
    (x, y), (width, height), degrees = cv2.minAreaRect(outline)
    angle = np.deg2rad(degrees + (90.0 if height > width else 0.0))
    return middle[0] + x, middle[1] + y, max(width, height), min(width, height), float(angle)


def length_unit(sides: Array, is_door: NDArray[np.bool_]) -> float:
    """
    Return the graph's unit of length from ``sides (R, 2)``, about the width of a door.

    It is the weighted median of the doors' widths and a fraction of the rooms' short sides. Rooms
    prevent a single wide opening from dominating when there are few doors.
    """
    length = np.where(is_door, sides[:, 0], sides[:, 1] / SHORT_SIDE_UNITS)
    weight = np.where(is_door, 1.0, _ROOM_WEIGHT)
    order = np.argsort(length, kind='stable')
    cumulated = np.cumsum(weight[order]) - 0.5 * weight[order]
    return float(np.exp(np.interp(0.5 * weight.sum(), cumulated, np.log(length[order]))))


def _sizes(sides: Array, area: Array, is_door: NDArray[np.bool_]) -> Array:
    """Return the four size columns; doors only have a width, as their depth is a convention."""
    filling = np.clip(area / sides.prod(axis=1), 0.0, 1.0)
    logs = np.column_stack([np.log(sides), 0.5 * np.log(area)]) - _ROOM_LOG_SIZE
    rooms = np.column_stack([logs, filling])
    doors = np.zeros_like(rooms)
    doors[:, 0] = np.log(sides[:, 0])
    return np.where(is_door[:, None], doors, rooms)


def _adjacent_doors(graph: RegionGraph, log_width: Array, is_door: NDArray[np.bool_]) -> Array:
    """Return the three door columns; zeros for doors and for rooms without doors."""
    both_ways = np.concatenate([graph.edges, graph.edges[:, ::-1]])
    both_ways = both_ways[~is_door[both_ways[:, 0]] & is_door[both_ways[:, 1]]]
    count = np.bincount(both_ways[:, 0], minlength=len(graph)).astype(np.float64)
    width = log_width[both_ways[:, 1]]
    total = np.bincount(both_ways[:, 0], weights=width, minlength=len(graph))
    widest = np.full(len(graph), -np.inf)
    np.maximum.at(widest, both_ways[:, 0], width)
    return np.column_stack(
        [np.log1p(count), total / np.maximum(count, 1.0), np.where(count > 0, widest, 0.0)]
    )
