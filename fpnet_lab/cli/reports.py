# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Output of benchmarks and fits: printed tables, and reports with their provenance."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Mapping, Sequence
import json
from pathlib import Path
from typing import Any, TypeVar

import typer

from fpnet.cli import common
from fpnet_lab.provenance import Provenance
from fpnet_lab.scores import Score, Table

Item = TypeVar('Item')

_begun: list[Provenance] = []


def begin() -> None:
    """Store command and commit of this run, before HEAD can change."""
    _begun[:] = [Provenance.now()]


def script_parser(description: str | None) -> ArgumentParser:
    """Return the argument parser of a benchmark script, with ``--json``; calls ``begin``."""
    begin()
    parser = ArgumentParser(description=description)
    parser.add_argument('--json', type=Path, metavar='OUT', help='write the report to this file')
    return parser


def write_report(path: Path | None, report: dict[str, Any]) -> None:
    """Write the ``--json`` report, if requested, with the provenance; NaN becomes null."""
    made = _begun[0] if _begun else Provenance.now()
    plain = json.loads(json.dumps(report), parse_constant=lambda _: None)
    common.write_json(path, made.in_report(plain))


def show(
    table: Table, json_path: Path | None, title: str | None = None, width: int | None = None
) -> None:
    """Print a table, unless ``--json -`` uses stdout."""
    common.show_table(table.titles, table.rows, json_path, title, width)


def finish(name: str, path: Path | None, report: dict[str, Any]) -> None:
    """Write a benchmark's report as ``--json``, and print its tables of the documentation."""
    write_report(path, report)
    say_tables(name, path, report)


def say_tables(name: str, path: Path | None, report: dict[str, Any]) -> None:
    """Print the documentation's tables of a benchmark's report."""
    from fpnet_lab.evaluation.published.makers import figures_of

    for table in figures_of(name, report)[0].values():
        common.say(f'\n{table.markdown()}', path)


def print_scores(items: Iterable[Item], scores: Callable[[Item], Sequence[Score]]) -> list[Item]:
    """Print a Markdown table with one row per item as items arrive; return the items."""
    kept: list[Item] = []
    for item in items:
        lines = Table.of_scores([scores(item)]).markdown().splitlines()
        print('\n'.join(lines[2:] if kept else lines), flush=True)
        kept.append(item)
    return kept


def say_figures(figures: Mapping[str, Any], **drawn: Any) -> dict[str, Any]:
    """Print the figures of a fit; return them for the manifest with the facts ``drawn``."""
    for name, value in figures.items():
        typer.echo(f'{name}: {value:.3g}' if isinstance(value, float) else f'{name}: {value}')
    return {'figures': figures, 'data': drawn | {'command': Provenance.now().command}}
