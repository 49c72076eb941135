# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench segmentation``: rooms and doors against hand-labelled and generated truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli.options import Half
from fpnet_lab.cli.reports import finish, say_tables


def command(
    split: Annotated[Half, typer.Option('--split', help='Split of the real floorplans.')],
    data: Annotated[
        Path, typer.Option('--data', metavar='DIR', help='Folder of bormann and areagraph.')
    ] = Path('../shared/data'),
    limit: Annotated[
        int | None, typer.Option('--limit', min=1, help='Use only the first maps and recordings.')
    ] = None,
    submap: Annotated[
        bool, typer.Option('--submap/--no-submap', help='Also segment simulated submaps.')
    ] = True,
    seed: Annotated[
        int | None,
        typer.Option(
            '--buildings-from',
            min=0,
            help="Seed of the recordings' first building; default: the split's.",
            show_default=False,
        ),
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Score the segmentation of floorplans, robot maps and submaps.

    Prints the tables of the documentation; the JSON holds fractions.

    Example: fpnet bench segmentation --split report --json out/segmentation.json
    """
    common.check_input(data)
    from fpnet_lab.evaluation.segmentation import METHODS, bench_plans, bench_robot_maps
    from fpnet_lab.sim.pairs.presets import SPLITS

    plans = len(SPLITS[split.value][:limit])
    with progress('floorplans', 2 * plans * len(METHODS)) as advance:
        report = bench_plans(data, split.value, limit, advance)
    with progress('robot maps') as advance:
        report['robot_maps'] = bench_robot_maps(data, limit, advance)
    if submap:
        report['submap'] = _bench_submaps(split, limit, seed)
    report['split'] = split.value
    finish('segmentation', json_path, report)
    if submap:
        say_tables('submaps', json_path, report)


def _bench_submaps(split: Half, limit: int | None, seed: int | None) -> dict[str, Any]:
    from fpnet_lab.evaluation.submap_segmentation import RECORDINGS, REPORT_SEED, bench_submaps

    first_seed = seed if seed is not None else REPORT_SEED if split is Half.REPORT else 0
    with progress('submaps', limit or RECORDINGS) as advance:
        return bench_submaps(limit, advance, first_seed)
