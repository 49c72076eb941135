# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What benchmarks and fits say on the screen and of how they were made."""

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
    """Note what is run, and of which commit, before anybody commits another one."""
    _begun[:] = [Provenance.now()]


def script_parser(description: str | None) -> ArgumentParser:
    """Return the parser of a benchmark's script, with ``--json``; it has begun."""
    begin()
    parser = ArgumentParser(description=description)
    parser.add_argument('--json', type=Path, metavar='OUT', help='write what was measured there')
    return parser


def write_report(path: Path | None, report: dict[str, Any]) -> None:
    """Write ``--json`` where it is asked for, with what ``begin`` noted; NaN becomes null."""
    made = _begun[0] if _begun else Provenance.now()
    plain = json.loads(json.dumps(report), parse_constant=lambda _: None)
    common.write_json(path, made.in_report(plain))


def show(
    table: Table, json_path: Path | None, title: str | None = None, width: int | None = None
) -> None:
    """Print a table, unless ``--json -`` has stdout."""
    common.show_table(table.titles, table.rows, json_path, title, width)


def finish(name: str, path: Path | None, report: dict[str, Any]) -> None:
    """Write a benchmark's report as ``--json``, and print the tables that pages have of it."""
    write_report(path, report)
    say_tables(name, path, report)


def say_tables(name: str, path: Path | None, report: dict[str, Any]) -> None:
    """Print the tables that pages have of a benchmark's report."""
    from fpnet_lab.evaluation.published.makers import figures_of

    for table in figures_of(name, report)[0].values():
        common.say(f'\n{table.markdown()}', path)


def print_scores(items: Iterable[Item], scores: Callable[[Item], Sequence[Score]]) -> list[Item]:
    """Print a Markdown table, a row for each item as it comes; returns the items."""
    kept: list[Item] = []
    for item in items:
        lines = Table.of_scores([scores(item)]).markdown().splitlines()
        print('\n'.join(lines[2:] if kept else lines), flush=True)
        kept.append(item)
    return kept


def say_figures(figures: Mapping[str, Any], **drawn: Any) -> dict[str, Any]:
    """Print what a fit found, and return it for the manifest with what it was ``drawn`` from."""
    for name, value in figures.items():
        typer.echo(f'{name}: {value:.3g}' if isinstance(value, float) else f'{name}: {value}')
    return {'figures': figures, 'data': drawn | {'command': Provenance.now().command}}
