# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet localize``: a recording on a floorplan, offline, through the very same core."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet_core.cli import common

if TYPE_CHECKING:
    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading
    from fpnet_core.io import ScanSource
    from fpnet_core.judging.causes import Asked
    from fpnet_core.localizer import ReplayResult
    from fpnet_core.report import RunRecord
    from fpnet_core.types import Cause, LocalizerOutput, Segmentation

_REPORT_NAME = 'report.html'


@common.reads_drawing
def command(
    recording: Annotated[
        Path,
        typer.Argument(
            metavar='INPUT', help='ROS 2 bag, CARMEN log, or folder of scans with poses.'
        ),
    ],
    floorplan: Annotated[Path, typer.Option('--floorplan', metavar='F', help=common.DRAWING_HELP)],
    said: common.DrawingOptions,
    truth: Annotated[
        Path | None,
        typer.Option(
            '--truth',
            metavar='TUM',
            help='True poses to compare with: on the floorplan, or truth.tum of a simulation.',
        ),
    ] = None,
    poses: Annotated[
        Path | None,
        typer.Option(
            '--poses',
            metavar='FILE',
            help='Poses of the scans, used as odometry: TUM, KITTI or .npy, as KISS-ICP writes.',
        ),
    ] = None,
    topics: Annotated[
        list[str] | None,
        typer.Option(
            '--topic',
            metavar='NAME',
            help='Topic of a bag: a PointCloud2, or a LaserScan; repeated for several scanners.',
        ),
    ] = None,
    tum: Annotated[
        Path | None,
        typer.Option('--tum', metavar='OUT', help='Write every published pose, floorplan frame.'),
    ] = None,
    out: common.OutOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Localise a recording on a floorplan, offline.

    The scale of a drawing that states none is estimated, and searched around that estimate as far
    as it is unsure, unless localizer.scale_policy is set.

    Of a bag, the PointCloud2 topic is read, or else all LaserScan topics, merged where
    /tf_static puts the scanners. Raw scans run through KISS-ICP; poses that the recording brings,
    or --poses, are used as odometry.

    Exits 0 whether or not the robot was found; what it prints says which, and why; where it ends
    without a pose, the likely causes with the next command. fpnet --verbose localize logs every
    change of status with its reason.

    With --out the folder gets report.html (opens without a network), run.json, poses.tum and
    odometry.tum, map.yaml (the floorplan at the scale that was found), submap.yaml, and run.mcap
    for Foxglove.

    Example: fpnet localize drive/ --floorplan plan.yaml --out out/run

    Example: fpnet localize scans/ --floorplan plan.png --poses drive_poses_tum.txt --json -
    """
    tree = common.load(config, settings, seed)
    from fpnet_core.accuracy import summarize_run
    from fpnet_core.drawings.scaling import with_scale_of
    from fpnet_core.geometry import Affine2D
    from fpnet_core.io import PosedScans, open_scans, read_poses, write_tum
    from fpnet_core.io.truth import read_truth

    reading = said.read(floorplan, tree)
    tree = with_scale_of(reading, tree)
    common.say_reading(reading, json_path)
    reference, A_plan_truth = (None, Affine2D.identity()) if truth is None else read_truth(truth)
    source = open_scans(common.check_input(recording), topics=topics or ())
    if poses is not None:
        source = PosedScans(source, read_poses(poses))
    given = common.typed_settings(config, settings)
    given += ['--poses', str(poses)] if poses else []
    given += [word for topic in topics or () for word in ('--topic', topic)]
    asked = said.asked(('fpnet', 'localize', str(recording), *given, '--floorplan'), floorplan)
    result = _localize(source, reading, tree, asked, said.storey)
    run = result.run
    if tum is not None:
        write_tum(tum, run.published.stamps_ns, run.published.xy, run.published.yaw)
    summary = summarize_run(run.published, run.odometry, run.tick_ms, reference, A_plan_truth)
    figures = {
        'status': result.last.status.value,
        'probability': round(result.last.probability, 4),
        'reason': result.last.reason,
        'causes': [cause.as_json() for cause in result.causes],
        'scans': len(run.odometry),
        'rejected_scans': run.rejected_scans,
        'path_m': round(run.odometry.path_length_m(), 3),
        **summary.as_json(),
    }
    common.say(result.last.said, json_path)
    common.say(f'{summary}' if out is None else f'{summary}; see {out / _REPORT_NAME}', json_path)
    common.say_causes(result.causes, json_path)
    if json_path is not None:
        common.write_json(json_path, figures)
    if out is not None:
        from fpnet_core.report import RunRecord

        record = RunRecord(
            f'{recording.name} on {floorplan.name}',
            f'{result.last.said}. {summary}',
            result.plan,
            run.outputs,
            run.published,
            reference,
            A_plan_truth,
            figures,
            result.causes,
        )
        _write_folder(out, record, run)


@dataclass(frozen=True, eq=False)
class _Localized:
    """A run, the floorplan that it was on, its last tick, and why it has no answer."""

    run: ReplayResult
    plan: Segmentation
    last: LocalizerOutput
    causes: tuple[Cause, ...]


def _localize(
    source: ScanSource, reading: Reading, tree: FpnetConfig, asked: Asked, storey: int | None
) -> _Localized:
    from fpnet_core.localizer import Localizer, replay
    from fpnet_core.localizer.diagnosis import explain_run
    from fpnet_core.matching.learned import LearnedMatcher
    from fpnet_core.odometry import KissOdometry
    from fpnet_core.types import Status

    matcher = LearnedMatcher(tree.matcher)
    localizer = Localizer(tree, matcher)
    localizer.set_plan(reading.grid, reading.estimate)
    odometry = KissOdometry(tree.odometry)
    with common.progress('localizing', total=len(source)) as advance:
        run = replay(
            source,
            localizer,
            tree.localizer.tick_period_s,
            odometry.register_scan,
            on_scan=lambda: advance(1.0),
        )
    assert localizer.plan is not None  # it was set above
    last = run.outputs[-1] if run.outputs else localizer.output
    causes: tuple[Cause, ...] = ()
    if last.status is not Status.LOCALIZED:
        causes = explain_run(run.outputs, reading.grid, matcher, tree, reading, asked, storey)
    return _Localized(run, localizer.plan.segmentation, last, causes)


def _write_folder(out: Path, record: RunRecord, run: ReplayResult) -> None:
    from fpnet_core.report import write_run_exports, write_run_report

    write_run_exports(out, record.plan.grid, run.outputs, run.published, run.odometry)
    common.write_json(out / 'run.json', record.figures)
    write_run_report(out / _REPORT_NAME, record)
