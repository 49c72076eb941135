# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What benchmarks and fits say on the screen and of how they were made."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

import typer

from fpnet_core.cli import common
from fpnet_lab.provenance import Provenance

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


def percent(share: float | None) -> str:
    """Return a share in per cent, ``-`` where there is none."""
    return '-' if share is None else f'{100.0 * share:.1f}'


def say_figures(figures: Mapping[str, Any], **drawn: Any) -> dict[str, Any]:
    """Print what a fit found, and return it for the manifest with what it was ``drawn`` from."""
    for name, value in figures.items():
        typer.echo(f'{name}: {value:.3g}' if isinstance(value, float) else f'{name}: {value}')
    return {'figures': figures, 'data': drawn | {'command': Provenance.now().command}}
