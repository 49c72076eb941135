# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Attributed graphs of regions and portals."""

from fpnet_core.graphs.build import build_region_graph
from fpnet_core.graphs.features import EDGE_FEATURES, NODE_FEATURES, edge_features, node_features

__all__ = [
    'EDGE_FEATURES',
    'NODE_FEATURES',
    'build_region_graph',
    'edge_features',
    'node_features',
]
