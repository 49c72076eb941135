# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generation of pairs into a folder: in one process, on all cores, or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
import importlib
import json
from pathlib import Path
from typing import Any

import cv2

from fpnet_core.errors import ConfigError
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.pool import each_done
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.pairs.blocks import matching_pair, pack_pairs, with_new_features
from fpnet_lab.sim.pairs.dataset import (
    block_path,
    block_size,
    encode_block,
    present_blocks,
    put_file,
    read_block,
    read_manifest,
    set_feature_schema,
    write_manifest,
)
from fpnet_lab.sim.pairs.pair import generate_pair
from fpnet_lab.sim.plans.sources import PlanSource, generated_plans

BLOCK_PAIRS = 40  # numerical

_CONNECT_S = 10.0  # numerical


@dataclass(frozen=True, eq=False)
class BlockMaker:
    """Generator of the blocks of one pair sequence, with identical bytes in every process."""

    source: PlanSource
    seed: int
    config: SimConfig

    def __call__(self, start: int, size: int) -> bytes:
        """Return the encoded block of ``size`` pairs starting at ``start``."""
        indices = range(start, start + size)
        pairs = [generate_pair(self.seed, index, self.config, self.source) for index in indices]
        return encode_block(pack_pairs(pairs))


def shard_blocks(count: int, shard: int, num_shards: int) -> dict[int, int]:
    """Return block sizes of a shard by first pair; a shard has every ``num_shards``-th block."""
    starts = range(0, count, BLOCK_PAIRS)[shard::num_shards]
    return {start: min(BLOCK_PAIRS, count - start) for start in starts}


def write_pairs(
    out_dir: Path,
    seed: int,
    count: int,
    shard: int = 0,
    num_shards: int = 1,
    workers: int = 1,
    config: SimConfig | None = None,
    on_pairs: Callable[[int], None] | None = None,
    source: PlanSource | None = None,
    cluster: str | None = None,
) -> int:
    """
    Write a shard of the first ``count`` pairs of ``seed``; existing blocks are kept.

    Parameters
    ----------
    out_dir : created if missing; may contain other shards of the same seed
    shard, num_shards : write every ``num_shards``-th block, starting at block ``shard``
    workers : number of processes; the pairs do not depend on it
    on_pairs : callback with the number of pairs of each block, and of all existing blocks
    source : source of storeys; None: the generator
    cluster : address of a Dask scheduler whose workers generate; only this process writes files

    Returns
    -------
    Number of pairs written by this call.

    Raises
    ------
    ConfigError
        If the folder was written with another seed, configuration, source or schema, or the
        cluster cannot be reached.
    """
    if not (count > 0 and 0 <= shard < num_shards and workers > 0):
        raise ConfigError(
            f'cannot write {count} pairs as shard {shard}/{num_shards} with {workers} workers; '
            'expected a positive count, 0 <= shard < num_shards and at least one worker'
        )
    config = config if config is not None else SimConfig()
    source = source or generated_plans(config)
    out_dir.mkdir(parents=True, exist_ok=True)
    described = {
        'seed': seed,
        'block_pairs': BLOCK_PAIRS,
        'source': source.describe(),
        'config': json.loads(config.model_dump_json()),
    }
    write_manifest(out_dir, count, described)
    present = present_blocks(out_dir)
    wanted = shard_blocks(count, shard, num_shards)
    tasks = [task for task in wanted.items() if block_size(present.get(task[0])) < task[1]]
    report = on_pairs if on_pairs is not None else _ignore
    report(sum(wanted.values()) - sum(size for _, size in tasks))
    written = 0
    for (start, size), content in _made(BlockMaker(source, seed, config), tasks, workers, cluster):
        put_file(block_path(out_dir, start, size), content)
        written += size
        report(size)
    return written


def _ignore(count: int) -> None:
    """Do nothing; default progress callback."""


_Task = tuple[int, int]


def _made(
    make: BlockMaker, tasks: Sequence[_Task], workers: int, cluster: str | None
) -> Iterator[tuple[_Task, bytes]]:
    """Yield finished blocks in order of completion."""
    if cluster is not None:
        return _on_cluster(make, tasks, cluster)
    return each_done(partial(_make_block, make), tasks, workers)


def _make_block(make: BlockMaker, task: _Task) -> bytes:
    return make(*task)


def _on_cluster(
    make: BlockMaker, tasks: Sequence[_Task], address: str
) -> Iterator[tuple[_Task, bytes]]:
    try:
        distributed: Any = importlib.import_module('distributed')
    except ImportError:
        raise ConfigError(
            '--cluster needs Dask distributed; install it with: pip install fpnet_ros[cluster]'
        ) from None
    try:
        client = distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        detail = (str(error) or type(error).__name__).splitlines()[0]
        raise ConfigError(f'no Dask scheduler answers at {address}: {detail}') from None
    with client:
        shared = client.scatter(make, broadcast=True, hash=False)
        futures = client.map(_run_task, tasks, make=shared, pure=False)
        for future in distributed.as_completed(futures, loop=client.loop):
            yield future.result()
            future.release()


def _run_task(task: _Task, make: BlockMaker) -> tuple[_Task, bytes]:
    cv2.setNumThreads(1)  # never reset: a worker's threads share this setting
    return task, make(*task)


def refresh_features(folder: Path, on_pairs: Callable[[int], None] | None = None) -> int:
    """
    Recompute the features of stored pairs for the current schema; geometry is unchanged.

    Resumes where a previous call was interrupted.

    Returns
    -------
    Number of pairs that were rewritten.

    Raises
    ------
    ConfigError
        If the folder is not a set of pairs, or its blocks have another layout.
    """
    read_manifest(folder, any_features=True)
    report = on_pairs if on_pairs is not None else _ignore
    rewritten = 0
    for path in present_blocks(folder).values():
        block, size = read_block(path), block_size(path)
        if int(block['feature_schema']) != FEATURE_SCHEMA:
            pairs = [with_new_features(matching_pair(block, row)) for row in range(size)]
            put_file(path, encode_block(pack_pairs(pairs)))
            rewritten += size
        report(size)
    set_feature_schema(folder)
    return rewritten
