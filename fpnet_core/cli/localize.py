# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet localize``: a recording on a floorplan, offline, through the very same core."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fpnet_core.cli import common


def command(
    recording: Annotated[
        Path,
        typer.Argument(
            metavar='INPUT', help='ROS 2 bag, CARMEN log, or folder of scans with poses.'
        ),
    ],
    floorplan: Annotated[
        Path, typer.Option('--floorplan', metavar='F', help='Floorplan image or map_server YAML.')
    ],
    resolution_m: Annotated[
        float | None,
        typer.Option('--resolution', min=0.001, help='Metres per pixel of a plain image.'),
    ] = None,
    mirrored: Annotated[
        bool, typer.Option('--mirrored', help='The drawing is a mirror image: flip it.')
    ] = False,
    truth: Annotated[
        Path | None,
        typer.Option('--truth', metavar='TUM', help='True poses on the floorplan, to compare.'),
    ] = None,
    tum: Annotated[
        Path | None,
        typer.Option('--tum', metavar='OUT', help='Write every published pose, floorplan frame.'),
    ] = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Localise a recording on a floorplan, offline.

    A bag with raw clouds only runs through KISS-ICP; poses that the recording brings are used
    as odometry. Exits 0 whether or not the robot was found; the summary says which.

    Example: fpnet localize drive/ --floorplan plan.yaml --tum poses.tum --json run.json
    """
    tree = common.load(config, settings, seed)
    from fpnet_core.evaluation.runs import summarize_run
    from fpnet_core.io import open_scans, read_map, read_tum, write_tum
    from fpnet_core.localizer import create_localizer, replay
    from fpnet_core.odometry import KissOdometry

    grid = read_map(common.check_input(floorplan), resolution_m)
    if mirrored:
        grid = grid.mirrored()
    source = open_scans(common.check_input(recording))
    localizer = create_localizer(tree)
    localizer.set_plan(grid)
    odometry = KissOdometry(tree.odometry)
    with common.progress('localizing', total=len(source)) as advance:
        run = replay(
            source,
            localizer,
            tree.localizer.tick_period_s,
            odometry.register_scan,
            on_scan=lambda: advance(1.0),
        )
    if tum is not None:
        write_tum(tum, *run.trajectory())
    summary = summarize_run(run, None if truth is None else read_tum(truth))
    typer.echo(summary.line())
    if json_path is not None:
        common.write_json(json_path, summary.as_json())
