# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet localize``: localize a recording on a floorplan, offline, with the nodes' core."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.exits import NO_ANSWER
from fpnet.cli.plans import read_plans, write_differences
from fpnet.cli.progress import Advance, progress
from fpnet_core.config import OdometryChoice

if TYPE_CHECKING:
    from fpnet.accuracy import RunSummary
    from fpnet.api.run import Run
    from fpnet.report import RunRecord
    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading
    from fpnet_core.geometry import Affine2D
    from fpnet_core.io.scans import ScanSource
    from fpnet_core.scoring.invocation import Invocation
    from fpnet_core.sites import Site
    from fpnet_core.trajectory import PlanarTrajectory
    from fpnet_core.types import Cause

_Recording = Annotated[
    Path,
    typer.Argument(metavar='INPUT', help='Bag, CARMEN log, or folder of scans with poses.'),
]
_TruthOption = Annotated[
    Path | None,
    typer.Option(
        '--truth',
        metavar='TUM',
        help='True poses on the floorplan, or truth.tum of a simulation, to compute errors.',
    ),
]
_PosesOption = Annotated[
    Path | None,
    typer.Option(
        '--poses',
        metavar='FILE',
        help='Poses of the scans, used as odometry: TUM, KITTI or .npy, as KISS-ICP writes them.',
    ),
]
_OdometryOption = Annotated[
    OdometryChoice | None,
    common.choice(
        '--odometry',
        OdometryChoice,
        "Odometry of a bag: kiss (KISS-ICP), robot (the bag's), or both (KISS-ICP, initialized "
        "and checked by the bag's). Default: the bag's if it has one, else KISS-ICP.",
    ),
]
_TopicsOption = Annotated[
    list[str] | None,
    typer.Option(
        '--topic',
        metavar='NAME',
        help='PointCloud2, LaserScan or Odometry topic of a bag; repeatable.',
    ),
]
_TumOption = Annotated[
    Path | None,
    typer.Option('--tum', metavar='OUT', help='Write all published poses, floorplan frame.'),
]
_RoomsOption = Annotated[
    Path | None,
    typer.Option(
        '--rooms',
        metavar='CSV',
        help='Write when the robot entered and left each room that the plan names.',
    ),
]
_FilmOption = Annotated[
    Path | None,
    typer.Option('--film', metavar='GIF', help='Write the run as an animated GIF.'),
]
_ViewOption = Annotated[
    bool, typer.Option('--view', help='Show the run live in a browser on this machine.')
]


@common.reads_drawing
def command(
    recording: _Recording,
    said: common.DrawingOptions,
    floorplan: common.FloorplanOption = None,
    site: common.SiteOption = None,
    truth: _TruthOption = None,
    poses: _PosesOption = None,
    odometry: _OdometryOption = None,
    topics: _TopicsOption = None,
    tum: _TumOption = None,
    rooms: _RoomsOption = None,
    film: _FilmOption = None,
    view: _ViewOption = False,
    port: common.PortOption = common.DEFAULT_PORT,
    out: common.OutOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Localize a recording on a floorplan, offline.

    A scale that the drawing does not state is estimated, and its whole interval is searched.

    From a bag, the PointCloud2 topic is read or, without one, all LaserScan topics, merged by
    /tf_static. Raw scans are registered by KISS-ICP. Poses of the recording or --poses are used
    as odometry; with --odometry both they initialize and check KISS-ICP.

    Exits with 0 if localized at the end, with 3 if not (after printing likely causes and next
    commands), and with 1 on errors. --out writes a report, poses, maps, a bag, differences, and
    rooms.csv if the plan names rooms.

    Example: fpnet localize drive/ --floorplan plan.yaml --out out/run

    Example: fpnet localize drive/ --site site.yaml --out out/run

    Example: fpnet localize scans/ --floorplan plan.png --poses drive_poses_tum.txt --json -
    """
    tree = common.load(config, settings, seed)
    from fpnet.api.run import scans_of
    from fpnet_core.types import Status

    source = scans_of(
        common.check_input(recording), poses=poses, odometry=odometry, topics=topics or (),
        scan_stamp=tree.scans.stamp,
    )  # fmt: skip
    plans = read_plans(floorplan, site, said, tree, json_path)
    known = _known(truth, plans)
    given = [*common.typed_settings(config, settings), *_typed_source(poses, odometry, topics)]
    typed = said.typed(('localize', str(recording), *given), floorplan, site)
    title = f'{recording.name} on {Path(typed.drawing).name}'
    run = _ended(plans, source, tree, odometry, title, port if view else None)
    typed = _of_bag(typed, source, poses, odometry)
    ended = _Ended(run, known, run.causes(typed, said.storey))
    _say(ended, out, json_path)
    _write_files(ended, tum, rooms, json_path)
    _write_pictures(ended, title, film, out)
    if run.status is not Status.LOCALIZED:
        raise typer.Exit(NO_ANSWER)


def _of_bag(
    invocation: Invocation, source: ScanSource, poses: Path | None, odometry: OdometryChoice | None
) -> Invocation:
    """Return the invocation, marked if the bag's own odometry was used by default."""
    is_own = source.kind == 'bag' and source.has_poses
    return replace(invocation, of_bag=is_own and poses is None and odometry is None)


@dataclass(frozen=True, eq=False)
class _Known:
    """Ground-truth poses, None if unknown, and the transform from their frame to the plan's."""

    reference: PlanarTrajectory | None
    A_plan_truth: Affine2D


def _known(truth: Path | None, plans: Reading | Site) -> _Known:
    from fpnet.recordings.truth import check_truth, read_truth
    from fpnet_core.drawings.types import Reading
    from fpnet_core.geometry import Affine2D

    if truth is None:
        return _Known(None, Affine2D.identity())
    if isinstance(plans, Reading):  # for a site, the storey is not known yet
        check_truth(truth, plans.grid.resolution)
    return _Known(*read_truth(truth))


def _typed_source(
    poses: Path | None, odometry: OdometryChoice | None, topics: Sequence[str] | None
) -> list[str]:
    """Return the command-line options that select scans and odometry."""
    given = ['--poses', str(poses)] if poses else []
    given += ['--odometry', odometry] if odometry else []
    return given + [word for topic in topics or () for word in ('--topic', topic)]


@dataclass(frozen=True, eq=False)
class _Ended:
    """A finished run with ground truth and the likely causes of a failure."""

    run: Run
    known: _Known
    causes: tuple[Cause, ...]

    @property
    def summary(self) -> RunSummary:
        return self.run.summary(self.known.reference, self.known.A_plan_truth)

    def figures(self) -> dict[str, Any]:
        last, result = self.run.last, self.run.result
        return {
            'status': last.status.value,
            **self._storeys(),
            'probability': round(last.probability, 4),
            'reason': last.reason,
            'causes': [cause.as_json() for cause in self.causes],
            'room': self.run.room or None,
            'next_look': None if self.run.next_look is None else self.run.next_look.as_json(),
            'outdated': None if self.run.outdated is None else self.run.outdated.as_json(),
            'scans': len(result.odometry),
            'rejected_scans': result.rejected_scans,
            'path_m': round(result.odometry.path_length_m(), 3),
            **self.summary.as_json(),
        }

    def record(self, title: str) -> RunRecord:
        """Return the run as input of reports and animations."""
        from fpnet.report import RunRecord
        from fpnet.report.record import on_one_storey

        run, known, plan = self.run, self.known, self.run.segmentation
        outputs = on_one_storey(run.result.outputs)
        names = (run.site.name or Path(run.plan.drawing.name).stem, run.storey)
        return RunRecord(
            title, f'{run.last.said}. {self.summary}', plan, outputs, run.poses,
            known.reference, known.A_plan_truth, self.figures(), self.causes, run.result.odometry,
            run.differences, ', '.join(filter(None, names)), run.named_rooms.names,
        )  # fmt: skip

    def _storeys(self) -> dict[str, Any]:
        """Return the results about storeys; empty for a single floorplan."""
        last = self.run.last
        if len(last.storeys) < 2:
            return {}
        probability = {name: round(p, 4) for name, p in last.storeys.items()}
        claims = [o for o in self.run.result.outputs if o.A_plan_odom is not None]
        changes = [
            {'stamp_ns': new.stamp_ns, 'storey': new.storey}
            for old, new in zip([None, *claims], claims, strict=False)
            if old is None or old.storey != new.storey
        ]
        return {'storey': last.storey, 'storeys': probability, 'claims': changes}


def _ended(
    plans: Reading | Site,
    source: ScanSource,
    tree: FpnetConfig,
    odometry: OdometryChoice | None,
    title: str,
    port: int | None,
) -> Run:
    """Run to the end; ``port`` is that of the live page, None for none."""
    from fpnet.api.run import Run

    with progress('localizing', total=len(source)) as advance:
        run = Run(plans, source, tree, lambda: advance(1.0), odometry)
        if port is None:
            _show_status(run, advance)
        else:
            from fpnet.cli.view import follow
            from fpnet.report.live import LiveRun

            with LiveRun(title, run.rooms, port) as live:
                follow(run, live)
    return run


def _show_status(run: Run, advance: Advance) -> None:
    """Run to the end and show the status at each update with its time in the recording."""
    from fpnet_core.stamps import NS_PER_S

    first_ns = None
    for update in run:
        first_ns = update.stamp_ns if first_ns is None else first_ns
        short = f'{update.status.value} (p {update.probability:.2f})'
        seconds = (update.stamp_ns - first_ns) / NS_PER_S
        advance.status(short, f'{seconds:.0f} s: {update.said}')


def _say(ended: _Ended, out: Path | None, json_path: Path | None) -> None:
    common.say(ended.run.last.said, json_path)
    if ended.run.outdated is not None:
        common.say(ended.run.outdated.said, json_path)
    if ended.run.room:
        common.say(f'in room {ended.run.room}', json_path)
    seen = '' if out is None else f'; see {out / common.REPORT_NAME}'
    common.say(f'{ended.summary}{seen}', json_path)
    common.say_causes(ended.causes, json_path)
    if ended.run.next_look is not None:
        common.say(
            f'where to look next, relative to the sensor: {ended.run.next_look.words}', json_path
        )


def _write_files(
    ended: _Ended, tum: Path | None, rooms: Path | None, json_path: Path | None
) -> None:
    from fpnet.recordings.trajectories import write_tum
    from fpnet.rooms import write_stays

    if tum is not None:
        poses = ended.run.poses
        write_tum(tum, poses.stamps_ns, poses.xy, poses.yaw)
    if rooms is not None:
        named = ended.run.named_rooms
        if not named:
            common.say(f'{rooms} stays empty: the floorplan names no rooms', json_path)
        write_stays(rooms, named.stays(ended.run.poses))
    common.write_json(json_path, ended.figures())


def _write_pictures(ended: _Ended, title: str, film: Path | None, out: Path | None) -> None:
    if film is None and out is None:  # plotting libraries are optional
        return
    from fpnet.report import write_run_exports, write_run_report
    from fpnet.report.film import write_film
    from fpnet.rooms import write_stays

    record, run = ended.record(title), ended.run
    if out is not None:
        write_run_exports(
            out, record.plan.grid, record.outputs, run.poses, run.covariances, record.odometry
        )
        common.write_json(out / 'run.json', record.figures)
        if run.named_rooms:
            write_stays(out / 'rooms.csv', run.named_rooms.stays(run.poses))
        if run.differences is not None:
            write_differences(out, run.differences)
        write_run_report(out / common.REPORT_NAME, record)
    if film is not None:  # last: it raises if no update has a submap
        write_film(film, record)
