# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Storage of matching pairs: a folder of ``.npz`` blocks without pickle, and a manifest.

Each block contains consecutive pairs of one seed as concatenated arrays with row offsets
(``*_ptr``). Blocks are written atomically, so a folder can be read while other processes write
to it, and interrupted writing can resume. ``docs/dataset.md`` describes every array.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.errors import ConfigError
from fpnet_core.io.atomic import replaced
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.sim.pairs.blocks import Block, StoredPair, matching_pair, row_offsets, stored_pair
from fpnet_lab.sim.pairs.pair import MatchingPair

DATASET_SCHEMA = 2
"""Given: version of the block layout; folders of other versions are rejected."""

MANIFEST = 'manifest.json'


def block_path(folder: Path, start: int, size: int) -> Path:
    """Return the path of the block with ``size`` pairs starting at ``start``."""
    return folder / f'pairs-{start:07d}-{size:03d}.npz'


def block_size(path: Path | None) -> int:
    """Return the number of pairs according to a block's file name; 0 for None."""
    return 0 if path is None else int(path.stem.rsplit('-', 1)[1])


def present_blocks(folder: Path) -> dict[int, Path]:
    """Return block paths by first pair; if a block exists in two sizes, the larger one."""
    paths = sorted(folder.glob('pairs-*.npz'), key=block_size)
    return dict(sorted((int(path.stem.split('-')[1]), path) for path in paths))


def encode_block(block: Block) -> bytes:
    """Encode a block as the bytes of a ``.npz`` file; equal blocks give equal bytes."""
    buffer = io.BytesIO()
    arrays: dict[str, Any] = block
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def read_block(path: Path) -> Block:
    """Read the arrays of a block."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def put_file(path: Path, content: bytes) -> None:
    """Write a file atomically."""
    with replaced(path) as partial:
        partial.write_bytes(content)


def write_manifest(folder: Path, count: int, content: dict[str, Any]) -> None:
    """
    Write the folder's manifest, or check that it agrees with the existing one.

    Raises
    ------
    ConfigError
        If the folder was written with another seed, configuration, source or schema.
    """
    manifest = {'schema': DATASET_SCHEMA, 'feature_schema': FEATURE_SCHEMA, **content}
    if (folder / MANIFEST).exists():
        found = read_manifest(folder)
        for key, value in manifest.items():
            if found.get(key) != value:
                raise ConfigError(
                    f'{folder} was written with another {key}; choose an empty folder'
                )
        count = max(count, int(found['count']))
    _put_manifest(folder, {**manifest, 'count': count})


def _put_manifest(folder: Path, manifest: dict[str, Any]) -> None:
    put_file(folder / MANIFEST, (json.dumps(manifest, indent=2) + '\n').encode())


def read_manifest(folder: Path, any_features: bool = False) -> dict[str, Any]:
    """
    Read a folder's manifest; ``any_features`` also accepts other feature schemas.

    Raises
    ------
    ConfigError
        If it is missing or has another version.
    """
    try:
        manifest = dict(json.loads((folder / MANIFEST).read_text(encoding='utf-8')))
    except (OSError, ValueError):
        raise ConfigError(
            f'{folder} has no readable {MANIFEST}; write pairs with: fpnet simulate pairs'
        ) from None
    if manifest.get('schema') != DATASET_SCHEMA:
        raise ConfigError(
            f'{folder}: schema {manifest.get("schema")}, expected {DATASET_SCHEMA}; '
            'generate it again'
        )
    if not any_features and manifest.get('feature_schema') != FEATURE_SCHEMA:
        raise ConfigError(
            f'{folder}: feature_schema {manifest.get("feature_schema")}, expected '
            f'{FEATURE_SCHEMA}; run: fpnet simulate features {folder}'
        )
    return manifest


def set_feature_schema(folder: Path) -> None:
    """Record in the manifest that all blocks have features of the current schema."""
    manifest = read_manifest(folder, any_features=True)
    _put_manifest(folder, {**manifest, 'feature_schema': FEATURE_SCHEMA})


class PairDataset:
    """
    Read access to a folder of pairs: ``len``, ``[i]`` as arrays, :meth:`pair` as graphs.

    It is a map-style ``torch.utils.data.Dataset`` and can be passed to a ``DataLoader``.
    It uses the blocks that exist on construction, so an incomplete folder can be read as well.
    Blocks are read on first use and kept in memory, about 30 kB per pair.

    Raises
    ------
    ConfigError
        If the folder contains no pairs, or was written with another schema.
    """

    def __init__(self, folder: Path) -> None:
        self.manifest = read_manifest(folder)
        self._paths = list(present_blocks(folder).values())
        if not self._paths:
            raise ConfigError(
                f'{folder} contains no pairs yet; write them with: fpnet simulate pairs'
            )
        self._first = row_offsets([block_size(path) for path in self._paths])
        self._blocks: dict[int, Block] = {}

    def __len__(self) -> int:
        """Return the number of pairs."""
        return int(self._first[-1])

    def __getitem__(self, index: int) -> StoredPair:
        """Return pair ``index`` as arrays; negative indices count from the end."""
        block, row = self._locate(index)
        return stored_pair(block, row)

    def pair(self, index: int) -> MatchingPair:
        """Return pair ``index`` with complete region graphs, the input of matchers."""
        block, row = self._locate(index)
        return matching_pair(block, row)

    def _locate(self, index: int) -> tuple[Block, int]:
        position = index + len(self) if index < 0 else index
        if not 0 <= position < len(self):
            raise IndexError(f'pair {index} of {len(self)}')
        number = int(np.searchsorted(self._first, position, side='right')) - 1
        if number not in self._blocks:
            self._blocks[number] = read_block(self._paths[number])
        return self._blocks[number], position - int(self._first[number])
