# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench sites``: storey selection, outdated drawings and plan libraries."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress, track
from fpnet_lab.cli import options
from fpnet_lab.cli.options import Half
from fpnet_lab.cli.reports import finish


class SitesPart(StrEnum):
    """Parts that can be measured separately."""

    SITES = 'sites'
    ONE = 'one'
    DIFFERENCES = 'differences'
    LIBRARY = 'library'


def command(
    only: Annotated[
        list[SitesPart] | None,
        typer.Option(
            '--only', metavar=f'[{"|".join(SitesPart)}]', help='Measure this part; repeatable.'
        ),
    ] = None,
    sites: Annotated[int, typer.Option('--sites', min=1, help='Generated sites.')] = 12,
    drives: Annotated[
        int, typer.Option('--drives', min=1, help='Recordings with outdated drawings.')
    ] = 12,
    plans: Annotated[
        int, typer.Option('--plans', min=1, help='Generated plans of the library.')
    ] = 1000,
    most: Annotated[
        int, typer.Option('--most', help='Plans of the largest library to measure.')
    ] = 100_000,
    data: Annotated[
        Path | None,
        typer.Option('--data', metavar='DIR', help='Also use real floorplans and robot maps.'),
    ] = None,
    split: Annotated[Half, typer.Option('--split', help='Split of the real data.')] = Half.REPORT,
    workers: options.WorkersOption = 1,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Localize on multi-storey sites, detect outdated drawings, and query libraries of plans.

    Sites have 2 to 12 storeys; half of them share most of their walls, and one in four sites has
    two equal storeys. Each recording takes about a minute.

    Example: fpnet bench sites --json out/sites.json

    Example: fpnet bench sites --only sites --sites 24
    """
    tree = common.load(config, settings, seed)
    import cv2

    cv2.setNumThreads(1)
    report: dict[str, Any] = {}
    run: dict[SitesPart, Callable[[], dict[str, Any]]] = {
        SitesPart.SITES: lambda: _sites(sites, tree),
        SitesPart.ONE: lambda: _one(drives, tree),
        SitesPart.DIFFERENCES: lambda: _differences(drives, tree),
        SitesPart.LIBRARY: lambda: _library(plans, drives, most, data, split.value, workers, tree),
    }
    for part in only or SitesPart:
        report |= run[part]()
    finish('sites', json_path, report)


def _sites(count: int, tree: Any) -> dict[str, Any]:
    from fpnet_lab.evaluation.sites.site_drives import run_site, site_report

    runs = [run_site(number, tree.seed + 300, tree) for number in track(range(count), 'sites')]
    return {'sites': site_report(runs)}


def _one(count: int, tree: Any) -> dict[str, Any]:
    from fpnet_lab.evaluation.sites.site_of_one import one_report, site_of_one

    seeds = range(tree.seed + 9000, tree.seed + 9000 + count)
    return {'one': one_report([site_of_one(seed, tree) for seed in track(seeds, 'site of one')])}


def _differences(count: int, tree: Any) -> dict[str, Any]:
    from dataclasses import asdict

    from fpnet_lab.evaluation.sites.differences import DifferenceCase, difference_cases, figures_of

    cases: list[DifferenceCase] = []
    for number in track(range(count), 'drives'):
        cases += difference_cases(tree.seed + 7000 + number, tree)
    return {'differences': asdict(figures_of(cases))}


def _library(
    plans: int, drives: int, most: int, data: Path | None, split: str, workers: int, tree: Any
) -> dict[str, Any]:
    from fpnet.library import PlanLibrary
    from fpnet.library.files import read_library_plan
    from fpnet_lab.evaluation.sites import plan_library as bench

    seed = tree.seed + 20_000
    with TemporaryDirectory() as name:
        folder = Path(name).resolve()
        with progress('plans', plans) as advance:
            known = bench.generated_plans(plans, seed, folder, tree, workers, advance)
        cases = [
            bench.drive_case(number, seed + plans, folder, tree)
            for number in track(range(drives), 'drives')
        ]
        known += [read_library_plan(Path(case.path), tree) for case in cases]
        real = []
        if data is not None:
            real = list(bench.real_cases(data, split, folder, tree))
            known += bench.real_plans(data, split, folder, tree)
        library = PlanLibrary.of(known)
        bench.ask(library, cases[0])  # compiles the kernels
        answers = [bench.ask(library, case) for case in [*cases, *real]]
        found = zip(cases, answers, strict=False)
        claims = [
            bench.claim(case, proposals, tree)
            for case, (_, proposals) in track(list(found), 'searching')
        ]
        report = bench.figures([asked for asked, _ in answers], claims, library)
        return {'library': report | {'growth': bench.growth(known, cases, most, seed)}}
