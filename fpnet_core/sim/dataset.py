# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Matching pairs on disk: a folder of ``.npz`` blocks without pickle, and a manifest.

Each block holds consecutive pairs of one seed as concatenated arrays with row offsets
(``*_ptr``). Blocks appear complete or not at all, so a folder can be read while others still
write to it, and writing goes on where it stopped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
import json
import multiprocessing
import os
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import ConfigError
from fpnet_core.geometry import Affine2D
from fpnet_core.sim.config import SimConfig
from fpnet_core.sim.pairs import MatchingPair, generate_pair
from fpnet_core.types import FEATURE_SCHEMA, Region, RegionGraph, RegionLabel

DATASET_SCHEMA = 1
"""Version of the block layout; a folder of another version is refused."""

BLOCK_PAIRS = 40
MANIFEST = 'manifest.json'

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


def write_pairs(
    out_dir: Path,
    seed: int,
    count: int,
    shard: int = 0,
    num_shards: int = 1,
    workers: int = 1,
    config: SimConfig | None = None,
    on_pairs: Callable[[int], None] | None = None,
) -> int:
    """
    Write pairs 0 to ``count`` of ``seed`` that belong to a shard; blocks that exist stay.

    Parameters
    ----------
    out_dir : made where it is missing; may hold other shards of the same seed
    shard, num_shards : write every ``num_shards``-th block from ``shard`` on
    workers : processes; the pairs do not depend on it
    on_pairs : called with the number of pairs after each block, also for existing ones

    Returns
    -------
    Number of pairs written now.

    Raises
    ------
    ConfigError
        If the folder was written with another seed, configuration or schema.
    """
    if not (count > 0 and 0 <= shard < num_shards and workers > 0):
        raise ConfigError(
            f'cannot write {count} pairs as shard {shard}/{num_shards} with {workers} workers; '
            'expected a positive count, 0 <= shard < shards, at least one worker'
        )
    config = config if config is not None else SimConfig()
    out_dir.mkdir(parents=True, exist_ok=True)
    _write_manifest(out_dir, seed, count, config)
    present = _present_blocks(out_dir)
    wanted = {
        start: min(BLOCK_PAIRS, count - start)
        for start in range(0, count, BLOCK_PAIRS)[shard::num_shards]
    }
    tasks = [
        (out_dir, seed, start, size, config)
        for start, size in wanted.items()
        if _size(present.get(start)) < size
    ]
    report = on_pairs if on_pairs is not None else _ignore
    report(sum(wanted.values()) - sum(task[3] for task in tasks))
    written = 0
    for size in _run(tasks, workers):
        written += size
        report(size)
    return written


def _ignore(count: int) -> None:
    """Stand in for a missing progress callback."""


_Task = tuple[Path, int, int, int, SimConfig]


def _run(tasks: Sequence[_Task], workers: int) -> Iterator[int]:
    if workers == 1:
        yield from map(_write_block, tasks)
        return
    context = multiprocessing.get_context('spawn')
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        for future in as_completed([pool.submit(_write_block, task) for task in tasks]):
            yield future.result()


def _block_path(out_dir: Path, start: int, size: int) -> Path:
    return out_dir / f'pairs-{start:07d}-{size:03d}.npz'


def _size(path: Path | None) -> int:
    return 0 if path is None else int(path.stem.rsplit('-', 1)[1])


def _present_blocks(folder: Path) -> dict[int, Path]:
    """Return blocks by their first pair; of an extended last block, the longer version."""
    paths = sorted(folder.glob('pairs-*.npz'), key=_size)
    return dict(sorted((int(path.stem.split('-')[1]), path) for path in paths))


def _write_block(task: _Task) -> int:
    """Generate one block and put it in place in one step."""
    out_dir, seed, start, size, config = task
    pairs = [generate_pair(seed, index, config) for index in range(start, start + size)]
    path = _block_path(out_dir, start, size)
    part = path.with_name(f'.{path.stem}-{os.getpid()}.part')
    with part.open('wb') as file:
        np.savez_compressed(file, **_packed(pairs))
    part.replace(path)
    return size


def _packed(pairs: Sequence[MatchingPair]) -> dict[str, Any]:
    """Return a block's arrays by name; text is fixed-width unicode."""
    block: dict[str, Any] = {
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
        'ptr': _offsets([len(graph) for graph in graphs]),
        'edge_ptr': _offsets([len(graph.edges) for graph in graphs]),
        'vertex_ptr': _offsets([len(region.polygon) for region in regions]),
        'node_feat': np.concatenate([graph.node_feat for graph in graphs]),
        'edges': np.concatenate([graph.edges for graph in graphs]),
        'edge_feat': np.concatenate([graph.edge_feat for graph in graphs]),
        'positions': np.stack([region.centroid for region in regions]),
        'is_door': np.array([region.label is RegionLabel.DOOR for region in regions]),
        'polygons': np.concatenate([region.polygon for region in regions]),
        'scalars': np.array([[getattr(r, name) for name in _SCALARS] for r in regions]),
    }


def _offsets(sizes: Sequence[int]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


def _write_manifest(out_dir: Path, seed: int, count: int, config: SimConfig) -> None:
    """Write what the folder holds, or check that it agrees with what is there already."""
    manifest = {
        'schema': DATASET_SCHEMA,
        'feature_schema': FEATURE_SCHEMA,
        'seed': seed,
        'block_pairs': BLOCK_PAIRS,
        'config': json.loads(config.model_dump_json()),
    }
    path = out_dir / MANIFEST
    if path.exists():
        found = read_manifest(out_dir)
        for key, value in manifest.items():
            if found.get(key) != value:
                raise ConfigError(
                    f'{out_dir} was written with another {key}; choose an empty folder'
                )
        count = max(count, int(found['count']))
    part = path.with_name(f'.{MANIFEST}-{os.getpid()}.part')
    part.write_text(json.dumps({**manifest, 'count': count}, indent=2) + '\n', encoding='utf-8')
    part.replace(path)


def read_manifest(folder: Path) -> dict[str, Any]:
    """Read a folder's manifest; raises ConfigError where it is missing or of another version."""
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding='utf-8'))
    except (OSError, ValueError):
        raise ConfigError(
            f'{folder} holds no readable {MANIFEST}; write pairs with: fpnet simulate pairs'
        ) from None
    for key, expected in (('schema', DATASET_SCHEMA), ('feature_schema', FEATURE_SCHEMA)):
        if manifest.get(key) != expected:
            raise ConfigError(
                f'{folder}: {key} {manifest.get(key)}, expected {expected}; generate it anew'
            )
    return dict(manifest)


class PairDataset:
    """
    Read access to a folder of pairs: ``len``, ``[i]`` as arrays, :meth:`pair` as graphs.

    Sees the blocks that exist on construction; an incomplete folder is as good as a complete
    one. Blocks are read on first use and kept in memory, about 30 kB per pair.

    Raises
    ------
    ConfigError
        If the folder holds no pairs, or was written for another schema.
    """

    def __init__(self, folder: Path) -> None:
        self.manifest = read_manifest(folder)
        self._paths = list(_present_blocks(folder).values())
        if not self._paths:
            raise ConfigError(
                f'{folder} holds no pairs yet; write them with: fpnet simulate pairs'
            )
        self._first = _offsets([_size(path) for path in self._paths])
        self._blocks: dict[int, dict[str, NDArray[Any]]] = {}

    def __len__(self) -> int:
        """Count the pairs."""
        return int(self._first[-1])

    def __getitem__(self, index: int) -> StoredPair:
        """Return pair ``index`` as arrays; negative indices count from the end."""
        block, row = self._locate(index)
        return StoredPair(
            plan=_side(block, 'plan', row),
            sub=_side(block, 'sub', row),
            labels=_rows(block, 'labels', 'sub_ptr', row),
            A_plan_submap=Affine2D.from_matrix(block['A_plan_submap'][row]),
            explored_area_m2=float(block['explored_area_m2'][row]),
            plan_id=int(block['plan_id'][row]),
            family=str(block['family'][row]),
        )

    def pair(self, index: int) -> MatchingPair:
        """Return pair ``index`` with complete region graphs, as matchers take them."""
        stored = self[index]
        block, row = self._locate(index)
        return MatchingPair(
            plan_graph=_graph(block, 'plan', row, stored.plan),
            sub_graph=_graph(block, 'sub', row, stored.sub),
            sub_labels=stored.labels,
            A_plan_submap=stored.A_plan_submap,
            explored_area_m2=stored.explored_area_m2,
            plan_id=stored.plan_id,
            family=stored.family,
        )

    def _locate(self, index: int) -> tuple[dict[str, NDArray[Any]], int]:
        position = index + len(self) if index < 0 else index
        if not 0 <= position < len(self):
            raise IndexError(f'pair {index} of {len(self)}')
        number = int(np.searchsorted(self._first, position, side='right')) - 1
        if number not in self._blocks:
            with np.load(self._paths[number], allow_pickle=False) as file:
                self._blocks[number] = {name: file[name] for name in file.files}
        return self._blocks[number], position - int(self._first[number])


def _rows(block: dict[str, NDArray[Any]], name: str, pointer: str, row: int) -> NDArray[Any]:
    start, end = block[pointer][row : row + 2]
    return block[name][start:end]


def _side(block: dict[str, NDArray[Any]], side: str, row: int) -> SideArrays:
    node, edge = f'{side}_ptr', f'{side}_edge_ptr'
    return SideArrays(
        node_feat=_rows(block, f'{side}_node_feat', node, row),
        edges=_rows(block, f'{side}_edges', edge, row),
        edge_feat=_rows(block, f'{side}_edge_feat', edge, row),
        positions=_rows(block, f'{side}_positions', node, row),
        is_door=_rows(block, f'{side}_is_door', node, row),
    )


def _graph(
    block: dict[str, NDArray[Any]], side: Literal['plan', 'sub'], row: int, arrays: SideArrays
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
