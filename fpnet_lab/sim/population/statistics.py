# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Statistics of storeys: rooms, doors and their connectivity.

All values are measured on label rasters (:mod:`fpnet_lab.sim.population.floors`), so that
generated and hand-labelled storeys use the same code.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import networkx as nx
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.distance import nearest_labels
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.windows import NEIGHBOURS, window_of
from fpnet_lab.sim.population.floors import CELL_M, LabelledFloor

FEATURES = (
    'log_area',
    'aspect',
    'rectangularity',
    'solidity',
    'compactness',
    'doors',
    'mean_door_width',
    'log_largest_neighbour',
)
"""Columns of :attr:`FloorMeasures.regions`."""

_NOISE_M2 = 0.375
"""Given: smaller labels are noise; 150 cells, the limit used by the data set."""
_LABEL_GAP_M = 0.5
"""Maximum distance between a label and the middle of its door. Chosen."""
_MIN_OPENING_M = 0.5
"""Shorter contacts are artefacts, where labels grow through thin walls. Chosen."""


@dataclass(frozen=True, eq=False)
class FloorMeasures:
    """
    Statistics of one storey with R rooms and D doors.

    ``regions (R, F)`` has a column for each of :data:`FEATURES`; ``aspects``, ``areas_m2``
    and ``doors_per_room`` are the (R,) values of some of them, ``door_widths_m (D,)`` the
    widths of openings between two rooms. ``hub_degree`` is the largest number of doors of a
    room, ``cycles`` the number of doors that can be closed without disconnecting rooms.
    """

    name: str
    regions: NDArray[np.float64]
    areas_m2: NDArray[np.float64]
    aspects: NDArray[np.float64]
    rectangularities: NDArray[np.float64]
    doors_per_room: NDArray[np.int64]
    door_widths_m: NDArray[np.float64]
    hub_degree: int
    cycles: int
    components: int


def measure_floor(floor: LabelledFloor) -> FloorMeasures:
    """Compute the statistics of one storey's rooms, doors and graph."""
    labels = _grown(floor)
    cells = np.bincount(labels.ravel())
    kept = np.flatnonzero(cells * CELL_M**2 >= _NOISE_M2)
    kept = kept[kept > 0]
    shapes = np.array([_shape(labels == label) for label in kept]).reshape(-1, 5)
    number = {int(label): i for i, label in enumerate(kept)}
    doors = [
        (number[a], number[b], width)
        for a, b, width in _openings(labels)
        if a in number and b in number
    ]
    graph = nx.MultiGraph()
    graph.add_nodes_from(range(len(kept)))
    graph.add_edges_from((a, b, {'width': width}) for a, b, width in doors)
    degrees = np.array([degree for _, degree in graph.degree()], np.int64)
    components = nx.number_connected_components(graph)
    areas = shapes[:, 0]
    around = np.array([_around(graph, areas, i) for i in graph]).reshape(-1, 2)
    regions = np.column_stack([np.log(areas), shapes[:, 1:], degrees, around])
    return FloorMeasures(
        name=floor.name,
        regions=regions,
        areas_m2=areas,
        aspects=shapes[:, 1],
        rectangularities=shapes[:, 2],
        doors_per_room=degrees,
        door_widths_m=np.array([width for _, _, width in doors]),
        hub_degree=int(degrees.max(initial=0)),
        cycles=len(doors) - len(kept) + components,
        components=components,
    )


def _shape(mask: NDArray[np.bool_]) -> tuple[float, float, float, float, float]:
    """Return area [m^2], aspect, rectangularity, solidity and compactness of a room's cells."""
    part = window_of(mask)
    assert part is not None, 'only labels with cells are kept'
    window = np.pad(mask[part].astype(np.uint8), 1)
    outlines, _ = cv2.findContours(window, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    points = np.concatenate(outlines).astype(np.float32)
    _, sides, _ = cv2.minAreaRect(points)
    short, long = sorted(side + 1.0 for side in sides)  # contours run through cell centres
    area = float(np.count_nonzero(window))
    hull = cv2.convexHull(points)
    hull_area = cv2.contourArea(hull) + cv2.arcLength(hull, True) / 2.0 + 1.0
    perimeter = sum(cv2.arcLength(outline, True) for outline in outlines) + 4.0
    return (
        area * CELL_M**2,
        long / short,
        area / (long * short),
        area / hull_area,
        4.0 * np.pi * area / perimeter**2,
    )


def _openings(labels: NDArray[np.int32]) -> Iterator[tuple[int, int, float]]:
    """Yield the two labels and the width [m] of each opening between labelled rooms."""
    base = int(labels.max()) + 1
    contact = _contacts(labels, base)
    for pair in np.unique(contact[contact > 0]).tolist():
        rows, cols = np.nonzero(contact == pair)
        top, left = rows.min() - 1, cols.min() - 1
        window = np.zeros((rows.max() - top + 2, cols.max() - left + 2), np.bool_)
        window[rows - top, cols - left] = True
        pieces, stats = pieces_of(grown(window, 1))
        for piece in range(1, len(stats)):
            at = np.argwhere((pieces == piece) & window).astype(np.float32)
            width = CELL_M * (float(max(cv2.minAreaRect(at)[1])) + 1.0)
            if width >= _MIN_OPENING_M:
                yield pair // base, pair % base, width


def _grown(floor: LabelledFloor) -> NDArray[np.int32]:
    """Return the labels extended into doorways: nearby free cells get the nearest label."""
    distance, label = nearest_labels(floor.labels)
    near = (distance * CELL_M <= _LABEL_GAP_M) & floor.free
    return np.asarray(np.where(near | (floor.labels > 0), label, 0), np.int32)


def _contacts(labels: NDArray[np.int32], base: int) -> NDArray[np.int64]:
    """Mark cells (H, W) next to another label (right, above): smaller * base + larger."""
    contact = np.zeros(labels.shape, np.int64)
    for first, second in NEIGHBOURS[::-1]:
        here, there, marks = labels[first], labels[second], contact[first]
        meet = (here != there) & (here > 0) & (there > 0)
        marks[meet] = np.minimum(here, there)[meet].astype(np.int64) * base
        marks[meet] += np.maximum(here, there)[meet]
    return contact


def _around(graph: nx.MultiGraph, areas: NDArray[np.float64], room: int) -> tuple[float, float]:
    """Return a room's mean door width [m] and the log area of its largest neighbour."""
    edges = list(graph.edges(room, data='width'))
    if not edges:
        return 0.0, 0.0
    return (
        float(np.mean([width for _, _, width in edges])),
        float(np.log(max(areas[other] for _, other, _ in edges))),
    )
