# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parallel, resumable generation of the placement scorer's trials in blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from fpnet_core.config import FpnetConfig
from fpnet_lab.kept import make_once
from fpnet_lab.training.gathering import Counts
from fpnet_lab.training.scorer_drives import DRIVE_BLOCK, PLAIN_DRIVES, DriveSource
from fpnet_lab.training.scorer_trials import (
    BLOCK_CASES,
    COLUMNS,
    KINDS,
    Trial,
    Trials,
    TrialSource,
)


@dataclass(frozen=True)
class TrialAmounts(Counts):
    """Cases of each kind, rounded up to whole blocks, and recordings."""

    real: int = 1200
    drawn: int = 600
    foreign: int = 300
    generated: int = 700
    drives: int = 42


@dataclass(frozen=True)
class Block:
    """Trials that one task computes; ``data`` is optional for generated ones."""

    kind: str
    number: int
    seed: int
    data: Path | None
    config: FpnetConfig

    @property
    def name(self) -> str:
        """Unique name among the blocks of all seeds."""
        return f'{self.kind}-{self.seed}-{self.number:04d}'


def gather_trials(
    folder: Path,
    blocks: Sequence[Block],
    workers: int = 1,
    on_block: Callable[[float], None] = lambda _: None,
) -> list[Trial]:
    """
    Return all trials; blocks in ``folder`` are reused.

    Raises
    ------
    FpnetError
        If the shared data or a cached block is unusable.
    """
    named = {block.name: block for block in blocks}
    made = make_once(folder, Trials, named, _trials, workers, on_block, COLUMNS)
    return [trial for trials in made for trial in trials]


def trial_blocks(
    seed: int, data: Path | None, config: FpnetConfig, amounts: TrialAmounts
) -> list[Block]:
    """Return all blocks; kinds alternate, so that an interrupted run has some of each."""
    each = [
        (number / len(numbers), kind, number)
        for kind, numbers in _numbers(amounts)
        for number in numbers
    ]
    return [Block(kind, number, seed, data, config) for _, kind, number in sorted(each)]


def _numbers(amounts: TrialAmounts) -> Iterator[tuple[str, range]]:
    for kind in KINDS:
        yield kind, range(-(-getattr(amounts, kind) // BLOCK_CASES))
    yield 'drives', range(-(-min(amounts.drives, PLAIN_DRIVES) // DRIVE_BLOCK))


def _trials(block: Block) -> tuple[Trial, ...]:
    source = _source(block.kind, block.seed, block.data, block.config)
    return tuple(source.block(block.number))


@lru_cache(maxsize=5)
def _source(
    kind: str, seed: int, data: Path | None, config: FpnetConfig
) -> TrialSource | DriveSource:
    """Return the source of blocks of one kind, cached per process."""
    import torch

    from fpnet_core.matching.learned import LearnedMatcher

    torch.set_num_threads(1)
    matcher = LearnedMatcher(config.matcher)
    if kind == 'drives':
        return DriveSource(seed, config, matcher)
    return TrialSource(kind, seed, data, config, matcher)
