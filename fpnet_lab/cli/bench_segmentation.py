# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench segmentation``: rooms and doors against hand-labelled and generated truth."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from fpnet_core.cli import common
from fpnet_core.cli.progress import progress
from fpnet_lab.cli.reports import percent, write_report


class Split(StrEnum):
    """Half of the real buildings: one to choose parameters on, one for published figures."""

    TUNE = 'tune'
    REPORT = 'report'


def command(
    split: Annotated[Split, typer.Option('--split', help='Half of the real floorplans.')],
    data: Annotated[
        Path, typer.Option('--data', metavar='DIR', help='Folder of bormann and areagraph.')
    ] = Path('../shared/data'),
    limit: Annotated[
        int | None, typer.Option('--limit', min=1, help='Use only the first maps and drives.')
    ] = None,
    submap: Annotated[
        bool, typer.Option('--submap/--no-submap', help='Drive and cut generated recordings too.')
    ] = True,
    seed: Annotated[
        int | None,
        typer.Option(
            '--buildings-from',
            min=0,
            help="Seed of the drives' first building; default: the split's.",
            show_default=False,
        ),
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Score the segmentation of floorplans, robot maps and submaps.

    Percentages on screen, fractions in the JSON.

    Example: fpnet bench segmentation --split report --json out/segmentation.json
    """
    common.check_input(data)
    from fpnet_lab.evaluation.segmentation import METHODS, bench_plans, bench_robot_maps
    from fpnet_lab.sim.presets import SPLITS

    plans = len(SPLITS[split.value][:limit])
    with progress('floorplans', 2 * plans * len(METHODS)) as advance:
        report = bench_plans(data, split.value, limit, advance)
    with progress('robot maps') as advance:
        report['robot_maps'] = bench_robot_maps(data, limit, advance)
    if submap:
        report['submap'] = _bench_submaps(split, limit, seed)
    report['split'] = split.value
    _print_plans(report, json_path)
    _print_others(report, json_path)
    write_report(json_path, report)


def _bench_submaps(split: Split, limit: int | None, seed: int | None) -> dict[str, Any]:
    from fpnet_lab.evaluation.submap_segmentation import RECORDINGS, REPORT_SEED, bench_submaps

    first_seed = seed if seed is not None else REPORT_SEED if split is Split.REPORT else 0
    with progress('submaps', limit or RECORDINGS) as advance:
        return bench_submaps(limit, advance, first_seed)


def _print_plans(report: dict[str, Any], json_path: Path | None) -> None:
    rows = []
    for method, figures in {'default': report, **report['baselines']}.items():
        for kind in ('clean', 'furnished'):
            *shares, seconds = figures[kind].values()
            rows.append([method, kind, *map(percent, shares), f'{seconds:.3f}'])
    titles = ('method', 'plans', 'P', 'R', 'F1', 'door P', 'door R', 's per map')
    title = f'{report["plans"]} floorplans, {report["split"]} half [%]'
    common.show_table(titles, rows, json_path, title)


def _print_others(report: dict[str, Any], json_path: Path | None) -> None:
    maps = report['robot_maps']
    rows = [
        [method, *map(percent, figures.values())]
        for method, figures in maps.items()
        if isinstance(figures, dict)
    ]
    title = f'{maps["maps"]} robot maps [%]'
    common.show_table(('method', 'P', 'R', 'F1'), rows, json_path, title)
    if 'submap' not in report:
        return
    submap = report['submap']
    keys = ('room_iou_mean', 'rooms_over_iou50', 'doors_precision', 'doors_recall')
    rows = [
        [sensor, *(percent(figures[key]) for key in keys)]
        for sensor, figures in {**submap['by_sensor'], 'all': submap}.items()
    ]
    titles = ('sensor', 'room IoU', 'IoU > 50', 'door P', 'door R')
    common.show_table(titles, rows, json_path, 'submaps [%]')
