# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench regression``: comparison of the product's results with stored ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Mapping


def command(
    golden: Annotated[
        Path, typer.Option('--golden', metavar='FILE', help='Expected results.')
    ] = Path('benchmarks/regression.json'),
    is_short: Annotated[
        bool, typer.Option('--short', help='Only 2 recordings, 6 pairs of maps and 4 plans.')
    ] = False,
    is_written: Annotated[
        bool, typer.Option('--write', help='Store the current results as the expected ones.')
    ] = False,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
) -> None:
    """
    Compare statuses, placements and rooms of generated cases with expected results.

    Prints a line for each difference above small tolerances; exits with 1 if there are any. It
    takes three minutes on one core; --short takes twenty seconds.

    Example: fpnet bench regression

    Example: fpnet bench regression --write
    """
    tree = common.load(config, settings)
    if is_written and is_short:
        raise ConfigError('--write needs all cases; omit --short')
    from fpnet.recordings.truth import read_json
    from fpnet_lab.evaluation.regression import COUNTS, SHORT, differences, run_regression
    from fpnet_lab.training import use_threads

    expected = None if is_written else read_json(golden, 'create it with --write')
    use_threads(1)
    counts = SHORT if is_short else COUNTS
    with progress('cases', sum(counts.values())) as advance:
        found = run_regression(counts, tree, lambda: advance(1.0))
    if expected is None:
        golden.write_text(_text(found), encoding='utf-8')
        typer.echo(f'wrote {golden}')
        return
    lines = differences(found, expected)
    for line in lines:
        typer.echo(line)
    typer.echo(f'{sum(counts.values())} cases, {len(lines)} differences from {golden}')
    if lines:
        raise typer.Exit(1)


def _text(found: Mapping[str, Mapping[str, Any]]) -> str:
    """Return JSON with one line per case, for readable diffs."""
    parts = []
    for kind, outcomes in found.items():
        rows = [f'    "{name}": {json.dumps(outcome)}' for name, outcome in outcomes.items()]
        parts.append(f'  "{kind}": {{\n' + ',\n'.join(rows) + '\n  }')
    return '{\n' + ',\n'.join(parts) + '\n}\n'
