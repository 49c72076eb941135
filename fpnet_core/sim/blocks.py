# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Many matching pairs as a few flat arrays, and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D
from fpnet_core.sim.pairs import MatchingPair
from fpnet_core.types import Region, RegionGraph, RegionLabel

Block = dict[str, NDArray[Any]]
"""Arrays by name; rows of pair k lie between ``*_ptr[k]`` and ``*_ptr[k + 1]``."""

_SIDES: tuple[Literal['plan', 'sub'], ...] = ('plan', 'sub')
_SCALARS = ('area_m2', 'observed_fraction', 'frontier_fraction', 'confidence')


@dataclass(frozen=True, eq=False)
class SideArrays:
    """
    One side's graph: ``node_feat (R, D)``, ``edge_feat (E, De)`` float32, ``edges (E, 2)`` int64.

    ``positions (R, 2)`` are the regions' centroids [m] and ``is_door (R,)`` their labels.
    """

    node_feat: NDArray[np.float32]
    edges: NDArray[np.int64]
    edge_feat: NDArray[np.float32]
    positions: NDArray[np.float64]
    is_door: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class StoredPair:
    """A pair as arrays; ``labels (N,)`` int64 as in :class:`fpnet_core.sim.pairs.MatchingPair`."""

    plan: SideArrays
    sub: SideArrays
    labels: NDArray[np.int64]
    A_plan_submap: Affine2D
    explored_area_m2: float
    plan_id: int
    family: str


def pack_pairs(pairs: Sequence[MatchingPair]) -> Block:
    """Return a block's arrays by name; text is fixed-width unicode."""
    block: Block = {
        'labels': np.concatenate([pair.sub_labels for pair in pairs]),
        'A_plan_submap': np.stack([pair.A_plan_submap.matrix for pair in pairs]),
        'explored_area_m2': np.array([pair.explored_area_m2 for pair in pairs]),
        'plan_id': np.array([pair.plan_id for pair in pairs]),
        'family': np.array([pair.family for pair in pairs]),
    }
    for side in _SIDES:
        graphs = [pair.plan_graph if side == 'plan' else pair.sub_graph for pair in pairs]
        block |= {f'{side}_{name}': array for name, array in _packed_side(graphs).items()}
    return block


def _packed_side(graphs: Sequence[RegionGraph]) -> dict[str, Any]:
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


def row_offsets(sizes: Sequence[int]) -> NDArray[np.int64]:
    """Return where each run of rows starts, and at the end their total number."""
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


def stored_pair(block: Block, row: int) -> StoredPair:
    """Return a block's pair ``row`` as arrays."""
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
    """Return a block's pair ``row`` with complete region graphs."""
    stored = stored_pair(block, row)
    return MatchingPair(
        plan_graph=_graph(block, 'plan', row, stored.plan),
        sub_graph=_graph(block, 'sub', row, stored.sub),
        sub_labels=stored.labels,
        A_plan_submap=stored.A_plan_submap,
        explored_area_m2=stored.explored_area_m2,
        plan_id=stored.plan_id,
        family=stored.family,
    )


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
            **dict(zip(_SCALARS, map(float, scalars[i]), strict=True)),
        )
        for i in range(len(arrays.positions))
    )
    frame: Literal['plan', 'submap'] = 'plan' if side == 'plan' else 'submap'
    return RegionGraph(regions, arrays.edges, arrays.node_feat, arrays.edge_feat, frame)
