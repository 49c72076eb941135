# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet localize``: a recording on a floorplan, offline, through the very same core."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fpnet_core.cli import common
from fpnet_core.errors import OdometryError

if TYPE_CHECKING:
    from fpnet_core.accuracy import RunSummary
    from fpnet_core.config import FpnetConfig, ScanStamp
    from fpnet_core.drawings.types import Reading
    from fpnet_core.geometry import Affine2D
    from fpnet_core.io import ScanSource
    from fpnet_core.judging.causes import Asked
    from fpnet_core.localizer import ReplayResult
    from fpnet_core.trajectory import PlanarTrajectory
    from fpnet_core.types import Cause, LocalizerOutput, Segmentation

_REPORT_NAME = 'report.html'

OdometryChoice = Literal['kiss', 'robot', 'both']
"""Who says how the robot moved."""

_Recording = Annotated[
    Path,
    typer.Argument(metavar='INPUT', help='ROS 2 bag, CARMEN log, or folder of scans with poses.'),
]
_TruthOption = Annotated[
    Path | None,
    typer.Option(
        '--truth',
        metavar='TUM',
        help='True poses to compare with: on the floorplan, or truth.tum of a simulation.',
    ),
]
_PosesOption = Annotated[
    Path | None,
    typer.Option(
        '--poses',
        metavar='FILE',
        help='Poses of the scans, used as odometry: TUM, KITTI or .npy, as KISS-ICP writes.',
    ),
]
_OdometryOption = Annotated[
    OdometryChoice | None,
    typer.Option(
        '--odometry',
        help="Of a bag: kiss (KISS-ICP), robot (the bag's own), or both (KISS-ICP, helped and "
        "checked by the bag's own). Default: the bag's own if it has one.",
    ),
]
_TopicsOption = Annotated[
    list[str] | None,
    typer.Option(
        '--topic',
        metavar='NAME',
        help='Topic of a bag: a PointCloud2, or a LaserScan; repeated for several scanners.',
    ),
]
_TumOption = Annotated[
    Path | None,
    typer.Option('--tum', metavar='OUT', help='Write every published pose, floorplan frame.'),
]


@common.reads_drawing
def command(
    recording: _Recording,
    floorplan: Annotated[Path, typer.Option('--floorplan', metavar='F', help=common.DRAWING_HELP)],
    said: common.DrawingOptions,
    truth: _TruthOption = None,
    poses: _PosesOption = None,
    odometry: _OdometryOption = None,
    topics: _TopicsOption = None,
    tum: _TumOption = None,
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
    or --poses, are used as odometry, or help and check KISS-ICP with --odometry both.

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
    from fpnet_core.drawings.scaling import with_scale_of

    reading = said.read(floorplan, tree)
    tree = with_scale_of(reading, tree)
    common.say_reading(reading, json_path)
    known = _known(truth)
    given = [*common.typed_settings(config, settings), *_typed_source(poses, odometry, topics)]
    asked = said.asked(('fpnet', 'localize', str(recording), *given, '--floorplan'), floorplan)
    source = _opened(recording, poses, odometry, topics or (), tree.scans.stamp)
    result = _localize(source, reading, tree, asked, said.storey, odometry)
    summary = result.summary(known)
    common.say(result.last.said, json_path)
    common.say(f'{summary}' if out is None else f'{summary}; see {out / _REPORT_NAME}', json_path)
    common.say_causes(result.causes, json_path)
    if tum is not None:
        _write_poses(tum, result.run)
    if json_path is not None:
        common.write_json(json_path, result.figures(summary))
    if out is not None:
        name = f'{recording.name} on {floorplan.name}'
        _write_folder(out, name, result, known, summary)


@dataclass(frozen=True, eq=False)
class _Known:
    """True poses, None where nobody knows them, and the map from their frame to the plan's."""

    reference: PlanarTrajectory | None
    A_plan_truth: Affine2D


def _known(truth: Path | None) -> _Known:
    from fpnet_core.geometry import Affine2D
    from fpnet_core.io.truth import read_truth

    return _Known(None, Affine2D.identity()) if truth is None else _Known(*read_truth(truth))


def _typed_source(
    poses: Path | None, odometry: OdometryChoice | None, topics: Sequence[str] | None
) -> list[str]:
    """Return what was typed to say which scans and poses of the recording are meant."""
    given = ['--poses', str(poses)] if poses else []
    given += ['--odometry', odometry] if odometry else []
    return given + [word for topic in topics or () for word in ('--topic', topic)]


def _opened(
    recording: Path,
    poses: Path | None,
    odometry: OdometryChoice | None,
    topics: Sequence[str],
    scan_stamp: ScanStamp,
) -> ScanSource:
    from fpnet_core.io import PosedScans, open_scans, read_poses

    # With poses of the sensor itself, nobody asks where it sits on the robot.
    unread = '' if odometry == 'kiss' or poses is not None else None
    source = open_scans(
        common.check_input(recording), topics=topics, odometry_topic=unread, scan_stamp=scan_stamp
    )
    if poses is not None:
        return PosedScans(source, read_poses(poses))
    if odometry in ('robot', 'both') and not source.has_poses:
        raise OdometryError(
            f'{recording} brings no odometry of its own; record its nav_msgs/Odometry as well, or '
            'leave out --odometry'
        )
    return source


@dataclass(frozen=True, eq=False)
class _Localized:
    """A run, the floorplan that it was on, its last tick, and why it has no answer."""

    run: ReplayResult
    plan: Segmentation
    last: LocalizerOutput
    causes: tuple[Cause, ...]

    def summary(self, known: _Known) -> RunSummary:
        from fpnet_core.accuracy import summarize_run

        run = self.run
        return summarize_run(
            run.published, run.odometry, run.tick_ms, known.reference, known.A_plan_truth
        )

    def figures(self, summary: RunSummary) -> dict[str, Any]:
        return {
            'status': self.last.status.value,
            'probability': round(self.last.probability, 4),
            'reason': self.last.reason,
            'causes': [cause.as_json() for cause in self.causes],
            'scans': len(self.run.odometry),
            'rejected_scans': self.run.rejected_scans,
            'path_m': round(self.run.odometry.path_length_m(), 3),
            **summary.as_json(),
        }


def _localize(
    source: ScanSource,
    reading: Reading,
    tree: FpnetConfig,
    asked: Asked,
    storey: int | None,
    choice: OdometryChoice | None,
) -> _Localized:
    from fpnet_core.localizer import Localizer, replay
    from fpnet_core.localizer.diagnosis import explain_run
    from fpnet_core.matching.learned import LearnedMatcher
    from fpnet_core.odometry_check import GuidedOdometry
    from fpnet_core.types import Status

    matcher = LearnedMatcher(tree.matcher)
    localizer = Localizer(tree, matcher)
    localizer.set_plan(reading.grid, reading.estimate)
    odometry = GuidedOdometry(tree.odometry)
    with common.progress('localizing', total=len(source)) as advance:
        run = replay(
            source,
            localizer,
            tree.localizer.tick_period_s,
            odometry.register_scan,
            on_scan=lambda: advance(1.0),
            registers_all=choice == 'both',
        )
    assert localizer.plan is not None  # it was set above
    last = run.outputs[-1] if run.outputs else localizer.output
    causes: tuple[Cause, ...] = ()
    if last.status is not Status.LOCALIZED:
        causes = explain_run(run.outputs, reading.grid, matcher, tree, reading, asked, storey)
    return _Localized(run, localizer.plan.segmentation, last, causes)


def _write_poses(tum: Path, run: ReplayResult) -> None:
    from fpnet_core.io import write_tum

    write_tum(tum, run.published.stamps_ns, run.published.xy, run.published.yaw)


def _write_folder(
    out: Path, name: str, result: _Localized, known: _Known, summary: RunSummary
) -> None:
    from fpnet_core.report import RunRecord, write_run_exports, write_run_report

    run = result.run
    record = RunRecord(
        name,
        f'{result.last.said}. {summary}',
        result.plan,
        run.outputs,
        run.published,
        known.reference,
        known.A_plan_truth,
        result.figures(summary),
        result.causes,
    )
    write_run_exports(out, record.plan.grid, run.outputs, run.published, run.odometry)
    common.write_json(out / 'run.json', record.figures)
    write_run_report(out / _REPORT_NAME, record)
