# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Gathers the judge's trials in blocks, by several processes, and goes on where it stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from fpnet_core.config import FpnetConfig
from fpnet_lab.pool import each_done
from fpnet_lab.training.judge_drives import DRIVE_BLOCK, PLAIN_DRIVES, DriveSource
from fpnet_lab.training.judge_trials import (
    BLOCK_CASES,
    KINDS,
    Trial,
    TrialSource,
    read_trials,
    write_trials,
)


@dataclass(frozen=True)
class Amounts:
    """Cases of each kind, rounded up to whole blocks, and drives."""

    real: int = 1200
    drawn: int = 600
    foreign: int = 300
    generated: int = 700
    drives: int = 42

    def scaled(self, share: float) -> Amounts:
        """Return the same mixture of fewer cases."""
        return Amounts(*(max(1, round(share * getattr(self, n))) for n in (*KINDS, 'drives')))


@dataclass(frozen=True)
class _Block:
    kind: str
    number: int
    seed: int
    data: Path | None
    config: FpnetConfig
    path: Path


def gather_trials(
    folder: Path,
    seed: int,
    data: Path | None,
    config: FpnetConfig,
    amounts: Amounts,
    workers: int = 1,
    on_block: Callable[[float], None] = lambda _: None,
) -> list[Trial]:
    """
    Return all trials, those that ``folder`` has not yet are made first.

    Raises
    ------
    FpnetError
        If the shared data or a block is unusable.
    """
    blocks = list(_blocks(folder, seed, data, config, amounts))
    missing = [block for block in blocks if not block.path.exists()]
    on_block(float(len(blocks) - len(missing)))
    for _ in each_done(_make, missing, workers):
        on_block(1.0)
    return [trial for block in blocks for trial in read_trials(block.path)]


def count_blocks(amounts: Amounts) -> int:
    """Return how many blocks there are."""
    return sum(len(numbers) for _, numbers in _numbers(amounts))


def _numbers(amounts: Amounts) -> Iterator[tuple[str, range]]:
    for kind in KINDS:
        yield kind, range(-(-getattr(amounts, kind) // BLOCK_CASES))
    yield 'drives', range(-(-min(amounts.drives, PLAIN_DRIVES) // DRIVE_BLOCK))


def _blocks(
    folder: Path, seed: int, data: Path | None, config: FpnetConfig, amounts: Amounts
) -> Iterator[_Block]:
    each = [
        (number / len(numbers), kind, number)
        for kind, numbers in _numbers(amounts)
        for number in numbers
    ]
    # Kinds take turns, so that an interrupted run has some of all.
    for _, kind, number in sorted(each):
        path = folder / f'{kind}-{seed}-{number:04d}.npz'
        yield _Block(kind, number, seed, data, config, path)


def _make(block: _Block) -> None:
    source = _source(block.kind, block.seed, block.data, block.config)
    write_trials(block.path, source.block(block.number))


@lru_cache(maxsize=5)
def _source(
    kind: str, seed: int, data: Path | None, config: FpnetConfig
) -> TrialSource | DriveSource:
    """Return what makes the blocks of one kind; a process makes many of them."""
    import torch

    from fpnet_core.matching.learned import LearnedMatcher

    torch.set_num_threads(1)
    matcher = LearnedMatcher(config.matcher)
    if kind == 'drives':
        return DriveSource(seed, config, matcher)
    return TrialSource(kind, seed, data, config, matcher)
