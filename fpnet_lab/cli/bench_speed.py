# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench speed``: durations of all operations that a user or a robot waits for."""

from __future__ import annotations

from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli.reports import show, write_report
from fpnet_lab.scores import Score, Table

if TYPE_CHECKING:
    from fpnet_lab.evaluation.speed.growth import Grown
    from fpnet_lab.evaluation.speed.timing import Figure


class SpeedPart(StrEnum):
    """Parts that can be timed separately."""

    PLANS = 'plans'
    PAIRS = 'pairs'
    DRIVE = 'drive'
    MATCHER = 'matcher'
    SCORER = 'scorer'
    SHELL = 'shell'
    GROWTH = 'growth'


def command(
    data: Annotated[
        Path, typer.Option('--data', metavar='DIR', help='Folder of real plans and robot maps.')
    ] = Path('../shared/data'),
    only: Annotated[
        list[SpeedPart] | None,
        typer.Option(
            '--only', metavar=f'[{"|".join(SpeedPart)}]', help='Time this part; repeatable.'
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option('--seconds', min=20.0, help='Duration of the recording; default: 7 minutes.'),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option('--plot', metavar='PNG', help='Plot times over storey areas.')
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Time plans, robot maps, a recording, matcher, scorer and shell; medians of five.

    The table shows each figure with its aim, which is for two idle cores. Real plans and robot
    maps are skipped if --data does not exist. Storeys of 300 to 50,000 m², which take some
    minutes, are timed with --only growth.

    Example: fpnet bench speed --json out/speed.json

    Example: fpnet bench speed --only matcher --only shell

    Example: fpnet bench speed --only growth --plot out/growth.png
    """
    import cv2

    cv2.setNumThreads(1)
    figures: list[Figure] = []
    storeys: list[Grown] = []
    parts = only or [part for part in SpeedPart if part is not SpeedPart.GROWTH]
    with progress('timing', len(parts)) as advance:
        for part in parts:
            if part is SpeedPart.GROWTH:
                storeys = _grown()
            figures += _measured(part, data, seconds)
            advance(1.0)
    figures += [figure for storey in storeys for figure in storey.figures()]
    show(Table.of_scores([_row(figure) for figure in figures]), json_path)
    if plot is not None and storeys:
        from fpnet_lab.viz.growth import save_growth

        save_growth(storeys, plot)
    report: dict[str, Any] = {'figures': {each.name: each.as_json() for each in figures}}
    if storeys:
        report['growth'] = [asdict(storey) for storey in storeys]
    if json_path is not None:
        write_report(json_path, report)


def _grown() -> list[Grown]:
    from fpnet_lab.evaluation.speed.growth import AREAS_M2, growth

    return [growth(area_m2) for area_m2 in AREAS_M2]


def _measured(part: SpeedPart, data: Path, seconds: float | None) -> list[Figure]:
    from fpnet_lab.evaluation.speed import maps
    from fpnet_lab.evaluation.speed.drive import drive_figures

    if part is SpeedPart.GROWTH:
        return []
    if part is SpeedPart.DRIVE:
        return drive_figures(seconds)[0]
    if part is SpeedPart.PAIRS:
        return [maps.pairs_figure(data)] if data.is_dir() else []
    real = [maps.bormann_figure(data)] if part is SpeedPart.PLANS and data.is_dir() else []
    return real + maps.PARTS[part.value]()


def _row(figure: Figure) -> tuple[Score, ...]:
    return (
        Score('what', figure.name),
        Score('by the clock', figure.value, figure.unit),
        Score('processor', figure.cpu_s, figure.unit),
        Score('aim', figure.said_aim),
        Score('of', figure.of),
    )
