# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Construction of the attributed graph for matchers from a segmentation."""

from __future__ import annotations

from typing import Literal

import numpy as np

from fpnet_core.graphs.features import edge_features, node_features
from fpnet_core.types import RegionGraph, Segmentation


def build_region_graph(
    segmentation: Segmentation, frame: Literal['plan', 'submap']
) -> RegionGraph:
    """
    Return the graph whose vertices are all rooms and doors, in the order of their ids.

    Each portal connects its door to the one or two rooms it opens into (paper, section III-C1); a
    door into unseen space has a single edge. Several openings of a door into the same room are one
    edge, with the widest opening. A segmentation without regions gives an empty graph.
    """
    widths: dict[tuple[int, int], float] = {}
    for portal in segmentation.portals:
        for room in portal.rooms:
            if room is None or room == portal.door:
                continue
            edge = (min(room, portal.door), max(room, portal.door))
            widths[edge] = max(widths.get(edge, 0.0), portal.width_m)
    edges = np.array(sorted(widths), dtype=np.int64).reshape(-1, 2)
    ordered = [widths[(int(a), int(b))] for a, b in edges]
    return RegionGraph(
        regions=segmentation.regions,
        edges=edges,
        node_feat=node_features(segmentation.regions),
        edge_feat=edge_features(segmentation.regions, edges, ordered),
        frame=frame,
    )
