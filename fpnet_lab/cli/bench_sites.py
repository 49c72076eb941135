# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench sites``: which storey of several, and where drawings are out of date."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer

from fpnet_core.cli import common
from fpnet_lab.cli.reports import write_report


class Part(StrEnum):
    """What may be measured alone."""

    SITES = 'sites'
    DIFFERENCES = 'differences'


def command(
    only: Annotated[
        list[Part] | None, typer.Option('--only', help='Measure this part; repeatable.')
    ] = None,
    sites: Annotated[int, typer.Option('--sites', min=1, help='Generated sites.')] = 12,
    drives: Annotated[
        int, typer.Option('--drives', min=1, help='Drives with drawings that are out of date.')
    ] = 12,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Drive on one storey of generated sites, and through buildings whose drawings are out of date.

    Sites have 2 to 12 storeys, of which half share most of their walls and one in four sites has
    two equal ones. Each drive takes about a minute.

    Example: fpnet bench sites --json out/sites.json

    Example: fpnet bench sites --only sites --sites 24
    """
    tree = common.load(config, settings, seed)
    import cv2

    cv2.setNumThreads(1)
    report: dict[str, Any] = {}
    for part in only or Part:
        report |= _sites(sites, tree) if part is Part.SITES else _differences(drives, tree)
    _print(report)
    write_report(json_path, report)


def _sites(count: int, tree: Any) -> dict[str, Any]:
    from fpnet_lab.evaluation.site_drives import run_site, site_report

    runs = [
        run_site(number, tree.seed + 300, tree) for number in common.track(range(count), 'sites')
    ]
    return {'sites': site_report(runs)}


def _differences(count: int, tree: Any) -> dict[str, Any]:
    from dataclasses import asdict

    from fpnet_lab.evaluation.differences import DifferenceCase, difference_cases, figures_of

    cases: list[DifferenceCase] = []
    for number in common.track(range(count), 'drives'):
        cases += difference_cases(tree.seed + 7000 + number, tree)
    return {'differences': asdict(figures_of(cases))}


def _print(report: dict[str, Any]) -> None:
    from rich.console import Console

    console = Console()
    for run in report.get('sites', {}).get('runs', ()):
        console.print(run)
    for name, part in report.items():
        console.print(name, {key: value for key, value in part.items() if key != 'runs'})
