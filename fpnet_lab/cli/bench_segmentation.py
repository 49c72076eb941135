# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench segmentation``: rooms and doors against hand-labelled and generated truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from fpnet_core.cli import common
from fpnet_core.cli.progress import progress
from fpnet_lab.cli.options import Half
from fpnet_lab.cli.reports import show, write_report
from fpnet_lab.scores import Column, Table, Units, columns, named

_ROOMS = columns(Units.FINE_SHARE, {'precision': 'P', 'recall': 'R', 'f1': 'F1'})
_DOORS = columns(Units.FINE_SHARE, {'doors_precision': 'door P', 'doors_recall': 'door R'})
_IOUS = columns(Units.FINE_SHARE, {'room_iou_mean': 'room IoU', 'rooms_over_iou50': 'IoU > 50'})


def command(
    split: Annotated[Half, typer.Option('--split', help='Half of the real floorplans.')],
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
    _print(report, json_path)
    write_report(json_path, report)


def _bench_submaps(split: Half, limit: int | None, seed: int | None) -> dict[str, Any]:
    from fpnet_lab.evaluation.submap_segmentation import RECORDINGS, REPORT_SEED, bench_submaps

    first_seed = seed if seed is not None else REPORT_SEED if split is Half.REPORT else 0
    with progress('submaps', limit or RECORDINGS) as advance:
        return bench_submaps(limit, advance, first_seed)


def _print(report: dict[str, Any], json_path: Path | None) -> None:
    plans = [
        {**figures[kind], 'method': method, 'name': kind}
        for method, figures in {'default': report, **report['baselines']}.items()
        for kind in ('clean', 'furnished')
    ]
    method, took = (
        Column('method', 'method'),
        Column('a map', 'seconds_per_map_median', Units.SECONDS.to(3)),
    )
    title = f'{report["plans"]} floorplans, {report["split"]} half'
    every = [method, Column('plans', 'name'), *_ROOMS, *_DOORS, took]
    show(Table.of(every, plans), json_path, title)
    maps = report['robot_maps']
    rows = [{**found, 'method': m} for m, found in maps.items() if isinstance(found, dict)]
    show(Table.of([method, *_ROOMS], rows), json_path, f'{maps["maps"]} robot maps')
    if 'submap' in report:
        drives = named({**report['submap']['by_sensor'], 'all': report['submap']})
        table = Table.of([Column('sensor', 'name'), *_IOUS, *_DOORS], drives)
        show(table, json_path, 'submaps')
