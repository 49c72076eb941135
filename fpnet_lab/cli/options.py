# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Options that several subcommands of ``fpnet train-*`` and ``fpnet bench`` share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


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


def complete_sensor(incomplete: str) -> list[str]:
    """Return the sensors whose names begin so."""
    from fpnet_lab.sim.sensors import SENSORS

    return [name for name in SENSORS if name.startswith(incomplete)]


def complete_building(incomplete: str) -> list[str]:
    """Return the looks of buildings whose names begin so."""
    from fpnet_lab.sim.fittings import BUILDING_STYLES

    return [name for name in BUILDING_STYLES if name.startswith(incomplete)]


def complete_family(incomplete: str) -> list[str]:
    """Return the layouts of buildings whose names begin so."""
    from fpnet_lab.sim.plans import FAMILIES

    return [name for name in FAMILIES if name.startswith(incomplete)]


def complete_style(incomplete: str) -> list[str]:
    """Return the looks of drawings whose names begin so."""
    from fpnet_lab.sim.styles import STYLES

    return [name for name in STYLES if name.startswith(incomplete)]
