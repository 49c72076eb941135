# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Geometry of a graph's regions in the graph's own unit, for consensus."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fpnet_core.graphs.invariant import door_mask, enclosing_rectangles, length_unit
from fpnet_core.matching.outlines import Painted, Surfaces, painted, seen
from fpnet_core.types import RegionGraph

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GraphGeometry:
    """
    ``R`` regions in units of about a door's width, relative to the mean of their centres.

    ``point (R, 2)`` is a door's middle or a room's centroid. ``box (R, 5)`` is the enclosing
    rectangle: centre, half long side, half short side, angle of the long side [rad], for a door
    that of its opening line. ``unit`` and ``origin (2,)`` convert back to the graph's frame.
    ``linked (R, R)`` marks regions joined by an edge. ``outlines`` are ``R`` polygons ``(V, 2)``;
    ``unseen (R,)`` is the share of each that borders on unknown space.
    """

    point: Array
    box: Array
    is_door: NDArray[np.bool_]
    observed: Array
    linked: NDArray[np.bool_]
    unit: float
    origin: Array
    outlines: tuple[Array, ...]
    unseen: Array

    @cached_property
    def painted(self) -> Painted:
        """The free space as rasters; used of a plan."""
        return painted(self.outlines, self.is_door)

    @cached_property
    def seen(self) -> Surfaces:
        """Points on walls and floors; used of a submap."""
        return seen(self.outlines, self.is_door, self.box, self.unseen)

    def __len__(self) -> int:
        """Return the number of regions."""
        return len(self.point)


def graph_geometry(graph: RegionGraph) -> GraphGeometry:
    """Return the geometry of a graph with at least one region."""
    centre, sides, angle = enclosing_rectangles(graph)
    is_door = door_mask(graph)
    unit = length_unit(sides, is_door)
    centroid = np.array([region.centroid for region in graph.regions])
    origin = centroid.mean(axis=0)
    linked = np.zeros((len(graph), len(graph)), dtype=np.bool_)
    linked[graph.edges[:, 0], graph.edges[:, 1]] = True
    return GraphGeometry(
        point=(centroid - origin) / unit,
        box=np.column_stack([(centre - origin) / unit, 0.5 * sides / unit, angle]),
        is_door=is_door,
        observed=np.array([region.observed_fraction for region in graph.regions]),
        linked=linked | linked.T,
        unit=unit,
        origin=origin,
        outlines=tuple((region.polygon - origin) / unit for region in graph.regions),
        unseen=np.array([region.frontier_fraction for region in graph.regions]),
    )
