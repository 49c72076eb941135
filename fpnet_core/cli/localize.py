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
    from fpnet_core.trajectory import PlanarTrajectory

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
        write_tum(tum, run.published.stamps_ns, run.published.xy, run.published.yaw)
    reference = None
    if truth is not None:
        poses = read_tum(truth)
        reference = PlanarTrajectory.from_transforms(poses.stamps_ns, poses.T_frame_body)
    summary = summarize_run(run.published, run.odometry, run.tick_ms, reference)
    last = run.outputs[-1] if run.outputs else localizer.output
    typer.echo(f'{last.status.value} (p {last.probability:.2f}): {summary}')
    if json_path is not None:
        report = {
            'status': last.status.value,
            'probability': round(last.probability, 4),
            'scans': len(run.odometry),
            'rejected_scans': run.rejected_scans,
            'path_m': round(run.odometry.path_length_m(), 3),
            **summary.as_json(),
        }
        common.write_json(json_path, report)
