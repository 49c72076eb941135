# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Options shared by several subcommands of ``fpnet train`` and ``fpnet bench``."""

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
    """Split of the real buildings: development, or test for published figures."""

    TUNE = 'tune'
    REPORT = 'report'


_TUNE_DATA = typer.Option('--data', metavar='DIR', help='Shared data; uses development split.')
TuneDataOption = Annotated[Path, _TUNE_DATA]
MaybeTuneDataOption = Annotated[Path | None, _TUNE_DATA]
RunOption = Annotated[
    Path, typer.Option('--out', metavar='DIR', help='Folder of the run; resumed if it exists.')
]
ShareOption = Annotated[
    float, typer.Option('--share', min=0.001, max=1.0, help='Share of the data to generate.')
]
WorkersOption = Annotated[int, typer.Option('--workers', min=1, help='Processes.')]
RealDataOption = Annotated[
    Path, typer.Option('--data', metavar='DIR', help='Real data: radish, mesh_*.')
]
WorkOption = Annotated[
    Path | None, typer.Option('--work', metavar='DIR', help='Caches finished cases for resuming.')
]


def named(what: str, name: str, known: Mapping[str, _T]) -> _T:
    """
    Return the entry of ``known`` with the user's ``name``.

    Raises
    ------
    ConfigError
        If there is no such entry.
    """
    if name not in known:
        raise ConfigError(f'unknown {what} {name!r}; choose one of {", ".join(known)}')
    return known[name]


def _completed_by(module: str, mapping: str) -> Callable[[str], list[str]]:
    """Return a completion of the keys of a module's mapping; it imports the module when used."""

    def complete(incomplete: str) -> list[str]:
        known = getattr(import_module(f'fpnet_lab.sim.{module}'), mapping)
        return [name for name in known if name.startswith(incomplete)]

    return complete


complete_sensor = _completed_by('lidars.sensors', 'SENSORS')
complete_building = _completed_by('buildings.fittings', 'BUILDING_STYLES')
complete_family = _completed_by('plans', 'FAMILIES')
complete_style = _completed_by('drawn.styles', 'STYLES')
