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
import json
import multiprocessing
import os
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.errors import ConfigError
from fpnet_core.sim.blocks import (
    Block,
    StoredPair,
    matching_pair,
    pack_pairs,
    row_offsets,
    stored_pair,
)
from fpnet_core.sim.config import SimConfig
from fpnet_core.sim.pairs import MatchingPair, generate_pair
from fpnet_core.types import FEATURE_SCHEMA

DATASET_SCHEMA = 1
"""Version of the block layout; a folder of another version is refused."""

BLOCK_PAIRS = 40
MANIFEST = 'manifest.json'


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
        arrays: dict[str, Any] = pack_pairs(pairs)
        np.savez_compressed(file, **arrays)
    part.replace(path)
    return size


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
        self._first = row_offsets([_size(path) for path in self._paths])
        self._blocks: dict[int, Block] = {}

    def __len__(self) -> int:
        """Count the pairs."""
        return int(self._first[-1])

    def __getitem__(self, index: int) -> StoredPair:
        """Return pair ``index`` as arrays; negative indices count from the end."""
        block, row = self._locate(index)
        return stored_pair(block, row)

    def pair(self, index: int) -> MatchingPair:
        """Return pair ``index`` with complete region graphs, as matchers take them."""
        block, row = self._locate(index)
        return matching_pair(block, row)

    def _locate(self, index: int) -> tuple[Block, int]:
        position = index + len(self) if index < 0 else index
        if not 0 <= position < len(self):
            raise IndexError(f'pair {index} of {len(self)}')
        number = int(np.searchsorted(self._first, position, side='right')) - 1
        if number not in self._blocks:
            with np.load(self._paths[number], allow_pickle=False) as file:
                self._blocks[number] = {name: file[name] for name in file.files}
        return self._blocks[number], position - int(self._first[number])
