# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Options that several subcommands of ``fpnet train-*`` and ``fpnet bench`` share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from importlib import import_module
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from fpnet_core.errors import ConfigError

_T = TypeVar('_T')


class Half(StrEnum):
    """Half of the real buildings: one to choose parameters on, one for published figures."""

    TUNE = 'tune'
    REPORT = 'report'


_TUNE_DATA = typer.Option('--data', metavar='DIR', help='Shared data; only its tune half is read.')
TuneDataOption = Annotated[Path, _TUNE_DATA]
MaybeTuneDataOption = Annotated[Path | None, _TUNE_DATA]
RunOption = Annotated[
    Path, typer.Option('--out', metavar='DIR', help='Folder of the run; continued if it exists.')
]
ShareOption = Annotated[
    float, typer.Option('--share', min=0.001, max=1.0, help='Gather so much of the data.')
]
WorkersOption = Annotated[int, typer.Option('--workers', min=1, help='Processes.')]
RealDataOption = Annotated[
    Path, typer.Option('--data', metavar='DIR', help='Real data: radish, mesh_*.')
]
WorkOption = Annotated[
    Path | None, typer.Option('--work', metavar='DIR', help='Keeps finished cases, to go on from.')
]


def named(what: str, name: str, known: Mapping[str, _T]) -> _T:
    """
    Return what the user has named.

    Raises
    ------
    ConfigError
        If nothing has that name.
    """
    if name not in known:
        raise ConfigError(f'unknown {what} {name!r}; choose one of {", ".join(known)}')
    return known[name]


def _completed_by(module: str, mapping: str) -> Callable[[str], list[str]]:
    """Return what completes the names that a mapping of a module has; loads it when asked."""

    def complete(incomplete: str) -> list[str]:
        known = getattr(import_module(f'fpnet_lab.sim.{module}'), mapping)
        return [name for name in known if name.startswith(incomplete)]

    return complete


complete_sensor = _completed_by('lidars.sensors', 'SENSORS')
complete_building = _completed_by('buildings.fittings', 'BUILDING_STYLES')
complete_family = _completed_by('plans', 'FAMILIES')
complete_style = _completed_by('drawn.styles', 'STYLES')
