# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What all subcommands share: the common options, configuration, progress bars, JSON output."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
import json
from pathlib import Path
import sys
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from fpnet_core.errors import ConfigError, FpnetError

if TYPE_CHECKING:
    from fpnet_core.config import FpnetConfig
    from fpnet_core.types import Cause

Item = TypeVar('Item')

ConfigOption = Annotated[
    Path | None,
    typer.Option('--config', metavar='FILE', help='Configuration YAML; default: built in.'),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        '--set',
        metavar='KEY=VALUE',
        help='Override a key, as submap.resolution_m=0.1; repeatable.',
    ),
]
OutOption = Annotated[
    Path | None, typer.Option('--out', metavar='DIR', help='Folder for everything written.')
]
SeedOption = Annotated[
    int | None, typer.Option('--seed', min=0, help='Seed of every random choice.')
]
DeviceOption = Annotated[
    str, typer.Option('--device', metavar='NAME', help='Network device: cpu, cuda or cuda:N.')
]
JsonOption = Annotated[
    Path | None,
    typer.Option('--json', metavar='FILE', help='Write the result as JSON; - for stdout.'),
]


def load(
    config: Path | None, settings: Sequence[str] | None = None, seed: int | None = None
) -> FpnetConfig:
    """Return the configuration from ``--config``, ``--set`` and ``--seed``, the last one wins."""
    from fpnet_core.config import load_config

    overrides = parse_settings(settings or ())
    if seed is not None:
        overrides['seed'] = seed
    return load_config(config, overrides)


def parse_settings(settings: Sequence[str]) -> dict[str, Any]:
    """Turn ``['submap.resolution_m=0.1']`` into ``{'submap.resolution_m': 0.1}``."""
    from fpnet_core.plain_yaml import parse_yaml

    overrides: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition('=')
        if not (equals and all(key.split('.'))):
            raise ConfigError(f'--set {setting}: expected KEY=VALUE, as submap.resolution_m=0.1')
        try:
            overrides[key] = parse_yaml(text)
        except ValueError:
            raise ConfigError(f'--set {setting}: {text!r} is not a YAML value') from None
    return overrides


def write_json(path: Path, result: Mapping[str, Any]) -> None:
    """Write ``result`` to ``path``, creating its folder, or to stdout if ``path`` is ``-``."""
    text = json.dumps(result, indent=2, allow_nan=False)
    if str(path) == '-':
        typer.echo(text)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + '\n', encoding='utf-8')


def say(text: str, json_path: Path | None) -> None:
    """Print a line for people: on stdout, or on stderr where ``--json -`` has stdout."""
    typer.echo(text, err=str(json_path) == '-')


def say_causes(causes: Sequence[Cause], json_path: Path | None) -> None:
    """Print why there is no answer and what to type next, the likeliest cause first."""
    if causes:
        say('likely causes, and what to do:', json_path)
    for number, cause in enumerate(causes, start=1):
        say(f'{number}. {cause.said}\n   next: {cause.next}', json_path)


def check_input(path: Path) -> Path:
    """Return ``path`` if it exists, else raise FpnetError."""
    if not path.exists():
        raise FpnetError(f'{path} does not exist; give an existing file or folder')
    return path


@contextmanager
def progress(description: str, total: float | None = None) -> Iterator[Callable[[float], None]]:
    """
    Show a progress bar on stderr and yield a function that advances it by a number of steps.

    Nothing is drawn unless stdout and stderr are terminals, so that logs and pipes stay clean.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = [SpinnerColumn(), TextColumn('{task.description}')]
    if total is not None:
        columns += [BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()]
    columns.append(TimeElapsedColumn())
    shown = sys.stdout.isatty() and sys.stderr.isatty()
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not shown) as bar:
        task = bar.add_task(description, total=total)

        def advance(steps: float) -> None:
            bar.advance(task, steps)

        yield advance


def track(items: Sequence[Item], description: str) -> Iterator[Item]:
    """Yield the items under a progress bar."""
    with progress(description, total=len(items)) as advance:
        for item in items:
            yield item
            advance(1.0)
