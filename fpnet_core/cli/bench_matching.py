# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench matching``: region matchers on the same pairs of graphs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from fpnet_core.cli import common


class PairSet(StrEnum):
    """Where the pairs come from."""

    SYNTHETIC = 'synthetic'


def command(
    data: Annotated[
        Path,
        typer.Option('--data', metavar='DIR', help='Pairs that no training has seen.'),
    ],
    pair_set: Annotated[
        PairSet, typer.Option('--set', help='Kind of pairs in DIR.')
    ] = PairSet.SYNTHETIC,
    limit: Annotated[
        int | None, typer.Option('--limit', min=1, help='Use only the first pairs.')
    ] = None,
    config: common.ConfigOption = None,
    weights: Annotated[
        Path | None, typer.Option('--weights', help='Checkpoint; default: the packaged one.')
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Match every pair with the learned matcher and the baselines.

    Example: fpnet bench matching --data runs/pairs-test --limit 400 --json out/bench.json
    """
    common.check_input(data)
    tree = common.load(config, [f'matcher.weights={weights}'] if weights else None)
    from fpnet_core.baselines import MATCHERS
    from fpnet_core.evaluation.matching import bench_matching
    from fpnet_core.sim.dataset import PairDataset

    dataset = PairDataset(data)
    count = min(limit or len(dataset), len(dataset))
    matchers = {name: factory(tree.matcher) for name, factory in MATCHERS.items()}
    pairs = (dataset.pair(index) for index in range(count))
    with common.progress('matching', count) as advance:
        report = bench_matching(pairs, matchers, advance) | {'set': pair_set.value}
    _print_table(report['methods'])
    if json_path is not None:
        common.write_json(json_path, report)


def _print_table(methods: dict[str, dict[str, Any]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table('method', 'MS', 'precision', 'recall', 'F1', 'ms per pair')
    for name, figures in methods.items():
        shares = ('ms', 'match_precision', 'match_recall', 'match_f1')
        cells = [f'{100.0 * figures[key]:.1f}%' for key in shares]
        table.add_row(name, *cells, f'{figures["ms_per_pair"]:.1f}')
    Console().print(table)
