# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Serialization of matching pairs to flat arrays, and deserialization."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D
from fpnet_core.graphs import build_region_graph
from fpnet_core.types import (
    FEATURE_SCHEMA,
    UNKNOWN,
    GridMap,
    Portal,
    Region,
    RegionGraph,
    RegionLabel,
    Segmentation,
)
from fpnet_lab.sim.pairs.labels import Correspondences
from fpnet_lab.sim.pairs.pair import MatchingPair

Block = dict[str, NDArray[Any]]
"""Arrays by name; the rows of pair k are ``*_ptr[k]`` to ``*_ptr[k + 1]``."""

_SIDES: tuple[Literal['plan', 'sub'], ...] = ('plan', 'sub')
_UNSEEN = -1  # given: second room of a portal into unobserved space
_SCALARS = ('area_m2', 'observed_fraction', 'frontier_fraction', 'confidence')


@dataclass(frozen=True, eq=False)
class SideArrays:
    """
    A region graph: ``node_feat (R, D)``, ``edge_feat (E, De)`` float32, ``edges (E, 2)`` int64.

    ``positions (R, 2)`` are the region centroids [m]; ``is_door (R,)`` marks door regions.
    """

    node_feat: NDArray[np.float32]
    edges: NDArray[np.int64]
    edge_feat: NDArray[np.float32]
    positions: NDArray[np.float64]
    is_door: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class StoredPair:
    """A pair as arrays; ``labels (N,)`` int64 as in :class:`~.pair.MatchingPair`."""

    plan: SideArrays
    sub: SideArrays
    labels: NDArray[np.int64]
    A_plan_submap: Affine2D
    explored_area_m2: float
    plan_id: int
    family: str


def pack_pairs(pairs: Sequence[MatchingPair]) -> Block:
    """Return the arrays of a block by name; strings are fixed-width unicode."""
    truths = [_truth(pair) for pair in pairs]
    block: Block = {
        'feature_schema': np.array(FEATURE_SCHEMA),
        'labels': np.concatenate([pair.sub_labels for pair in pairs]),
        'relations': np.concatenate([truth.relations for truth in truths]),
        'overlap_ptr': row_offsets([len(truth.overlap_m2) for truth in truths]),
        'overlap_pairs': np.concatenate([truth.overlap_pairs for truth in truths]),
        'overlap_m2': np.concatenate([truth.overlap_m2 for truth in truths]),
        'A_plan_submap': np.stack([pair.A_plan_submap.matrix for pair in pairs]),
        'S_plan_submap': np.stack([pair.S_plan_submap.matrix for pair in pairs]),
        'explored_area_m2': np.array([pair.explored_area_m2 for pair in pairs]),
        'plan_id': np.array([pair.plan_id for pair in pairs]),
        'family': np.array([pair.family for pair in pairs]),
    }
    for side in _SIDES:
        graphs = [pair.plan_graph if side == 'plan' else pair.sub_graph for pair in pairs]
        portals = [pair.plan_portals if side == 'plan' else pair.sub_portals for pair in pairs]
        arrays = _packed_graphs(graphs) | _packed_portals(portals)
        block |= {f'{side}_{name}': array for name, array in arrays.items()}
    return block


def _truth(pair: MatchingPair) -> Correspondences:
    if pair.truth is None:
        raise ValueError('a pair without ground truth cannot be stored')
    return pair.truth


def _packed_graphs(graphs: Sequence[RegionGraph]) -> Block:
    regions = [region for graph in graphs for region in graph.regions]
    return {
        'ptr': row_offsets([len(graph) for graph in graphs]),
        'edge_ptr': row_offsets([len(graph.edges) for graph in graphs]),
        'vertex_ptr': row_offsets([len(region.polygon) for region in regions]),
        'node_feat': np.concatenate([graph.node_feat for graph in graphs]),
        'edges': np.concatenate([graph.edges for graph in graphs]),
        'edge_feat': np.concatenate([graph.edge_feat for graph in graphs]),
        'positions': np.stack([region.centroid for region in regions]),
        'is_door': np.array([region.label is RegionLabel.DOOR for region in regions]),
        'polygons': np.concatenate([region.polygon for region in regions]),
        'scalars': np.array([[getattr(r, name) for name in _SCALARS] for r in regions]),
    }


def _packed_portals(portals: Sequence[Sequence[Portal]]) -> Block:
    every = [portal for group in portals for portal in group]
    rooms = [(a, _UNSEEN if b is None else b) for a, b in (portal.rooms for portal in every)]
    return {
        'portal_ptr': row_offsets([len(group) for group in portals]),
        'portal_door': np.array([portal.door for portal in every], dtype=np.int64),
        'portal_rooms': np.array(rooms, dtype=np.int64).reshape(-1, 2),
        'portal_ends': np.array([portal.ends for portal in every]).reshape(-1, 2, 2),
        'portal_has_lintel': np.array([portal.has_lintel for portal in every], dtype=np.bool_),
    }


def row_offsets(sizes: Sequence[int]) -> NDArray[np.int64]:
    """Return the start offset of each group of rows, followed by the total number of rows."""
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


def stored_pair(block: Block, row: int) -> StoredPair:
    """Return pair ``row`` of a block as arrays."""
    return StoredPair(
        plan=_side(block, 'plan', row),
        sub=_side(block, 'sub', row),
        labels=_rows(block, 'labels', 'sub_ptr', row),
        A_plan_submap=Affine2D.from_matrix(block['A_plan_submap'][row]),
        explored_area_m2=float(block['explored_area_m2'][row]),
        plan_id=int(block['plan_id'][row]),
        family=str(block['family'][row]),
    )


def matching_pair(block: Block, row: int) -> MatchingPair:
    """Return pair ``row`` of a block with complete region graphs."""
    stored = stored_pair(block, row)
    return MatchingPair(
        plan_graph=_graph(block, 'plan', row, stored.plan),
        sub_graph=_graph(block, 'sub', row, stored.sub),
        sub_labels=stored.labels,
        A_plan_submap=stored.A_plan_submap,
        explored_area_m2=stored.explored_area_m2,
        plan_id=stored.plan_id,
        family=stored.family,
        plan_portals=_portals(block, 'plan', row),
        sub_portals=_portals(block, 'sub', row),
        truth=Correspondences(
            labels=stored.labels,
            relations=_rows(block, 'relations', 'sub_ptr', row),
            overlap_pairs=_rows(block, 'overlap_pairs', 'overlap_ptr', row),
            overlap_m2=_rows(block, 'overlap_m2', 'overlap_ptr', row),
        ),
    )


def with_new_features(pair: MatchingPair) -> MatchingPair:
    """Return the pair with features recomputed from its regions and portals."""
    return replace(
        pair,
        plan_graph=build_region_graph(_unrastered(pair.plan_graph, pair.plan_portals), 'plan'),
        sub_graph=build_region_graph(_unrastered(pair.sub_graph, pair.sub_portals), 'submap'),
    )


def _unrastered(graph: RegionGraph, portals: tuple[Portal, ...]) -> Segmentation:
    """Return the graph's segmentation on a placeholder raster with one unknown cell."""
    grid = GridMap(np.full((1, 1), UNKNOWN, np.int8), 1.0)
    return Segmentation(grid, np.zeros((1, 1), np.int32), graph.regions, portals)


def _rows(block: Block, name: str, pointer: str, row: int) -> NDArray[Any]:
    start, end = block[pointer][row : row + 2]
    return block[name][start:end]


def _side(block: Block, side: str, row: int) -> SideArrays:
    node, edge = f'{side}_ptr', f'{side}_edge_ptr'
    return SideArrays(
        node_feat=_rows(block, f'{side}_node_feat', node, row),
        edges=_rows(block, f'{side}_edges', edge, row),
        edge_feat=_rows(block, f'{side}_edge_feat', edge, row),
        positions=_rows(block, f'{side}_positions', node, row),
        is_door=_rows(block, f'{side}_is_door', node, row),
    )


def _graph(
    block: Block, side: Literal['plan', 'sub'], row: int, arrays: SideArrays
) -> RegionGraph:
    first = int(block[f'{side}_ptr'][row])
    scalars = _rows(block, f'{side}_scalars', f'{side}_ptr', row)
    regions = tuple(
        Region(
            id=i,
            label=RegionLabel.DOOR if arrays.is_door[i] else RegionLabel.ROOM,
            polygon=_rows(block, f'{side}_polygons', f'{side}_vertex_ptr', first + i),
            centroid=arrays.positions[i],
            area_m2=float(area_m2),
            observed_fraction=float(observed),
            frontier_fraction=float(frontier),
            confidence=float(confidence),
        )
        for i, (area_m2, observed, frontier, confidence) in enumerate(scalars)
    )
    frame: Literal['plan', 'submap'] = 'plan' if side == 'plan' else 'submap'
    return RegionGraph(regions, arrays.edges, arrays.node_feat, arrays.edge_feat, frame)


def _portals(block: Block, side: str, row: int) -> tuple[Portal, ...]:
    names = ('portal_door', 'portal_rooms', 'portal_ends', 'portal_has_lintel')
    arrays = [_rows(block, f'{side}_{name}', f'{side}_portal_ptr', row) for name in names]
    return tuple(
        Portal(int(door), (int(a), None if b == _UNSEEN else int(b)), ends, bool(has_lintel))
        for door, (a, b), ends, has_lintel in zip(*arrays, strict=True)
    )
