# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench localization``: the localizer and baselines on recordings with odometry."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli import options
from fpnet_lab.cli.reports import show, write_report
from fpnet_lab.scores import Column, Table, Unit, Units, columns, named

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fpnet_lab.evaluation.localization.records import Record
    from fpnet_lab.evaluation.localization.runs import Job

_TABLE_WIDTH = 170  # characters; narrower tables are illegible; chosen
_COLUMNS = (  # numerical: digits
    Column('', 'name'),
    Column('runs', 'runs'),
    *columns(Units.SHARE, {'recall_1m_10deg': '1 m 10 deg', 'recall_05m_5deg': '0.5 m 5 deg'}),
    Column('first', 'path_to_first_pose_m_median', Units.METRES.in_title(2)),
    Column('wrong runs', 'wrong_published_runs'),
    Column('wrong poses', 'wrong_published_poses'),
    Column('false claims', 'open_set_false_claims'),
    Column('error', 'median_position_error_m', Units.METRES.in_title(2)),
    Column('error', 'median_yaw_error_deg', Units.DEGREES.in_title(2)),
    Column('NEES', 'nees_mean', Units.NUMBER),
    Column('in gate', 'inside_95', Units.SHARE),
    Column('ECE', 'ece', Units.NUMBER),
    *columns(Units.MS.in_title(2), {'tick_ms_p50': 'tick p50', 'tick_ms_p95': 'p95'}),
    Column('add', 'add_scan_ms_p50', Units.MS.in_title(2)),
    Column('RSS', 'rss_mb_max', Unit(' MB').in_title(0)),
)


def command(
    limit: Annotated[
        int | None, typer.Option('--limit', min=1, help='Number of cases, from all groups.')
    ] = None,
    groups: Annotated[
        list[str] | None,
        typer.Option('--groups', metavar='NAME', help='Only this group; repeatable.'),
    ] = None,
    workers: options.WorkersOption = 1,
    baselines: Annotated[
        int | None,
        typer.Option(
            '--baselines', metavar='N', min=0, help='Run baselines on the first N cases only.'
        ),
    ] = None,
    data: options.RealDataOption = Path('../shared/data'),
    work: options.WorkOption = None,
    strips: Annotated[
        Path | None,
        typer.Option('--strips', metavar='DIR', help='Draw the first new run of each building.'),
    ] = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Localize on simulated and real recordings, with exact, inexact and wrong plans.

    Cases that need missing real data are skipped.

    Example: fpnet bench localization --limit 12 --work out/bench --json out/bench.json
    """
    tree = common.load(config, settings, seed)
    from fpnet_lab.evaluation.localization.cases import make_suite, select
    from fpnet_lab.evaluation.localization.figures import report
    from fpnet_lab.evaluation.localization.runs import Job

    drawn: set[str] = set()
    jobs = []
    for number, case in enumerate(select(make_suite(tree.seed), groups, limit)):
        is_drawn = strips is not None and case.building not in drawn
        drawn.add(case.building)
        strip = strips / f'{case.name}.png' if strips is not None and is_drawn else None
        with_baselines = baselines is None or number < baselines
        jobs.append(Job(case, tree, tree.seed, data, with_baselines, strip))
    records, skipped = localized(jobs, work, workers, json_path)
    if groups is not None:
        records = [record for record in records if record.group in groups]
    result = {**report(records), 'skipped': skipped}
    rows = {**result['groups'], 'total': result['total']}
    rows |= {name: table['total'] for name, table in result['baselines'].items()}
    show(Table.of(_COLUMNS, named(rows)), json_path, width=_TABLE_WIDTH)
    write_report(json_path, result)


def localized(
    jobs: Sequence[Job], work: Path | None, workers: int, json_path: Path | None
) -> tuple[list[Record], dict[str, str]]:
    """Run recordings, print an estimate of the duration and skipped cases; return both."""
    from fpnet_lab.evaluation.localization.suite import estimated_minutes, run_suite

    minutes = estimated_minutes(jobs, workers)
    said = f'{len(jobs)} recordings, about {minutes:.0f} minutes; resumable with --work'
    common.say(said, json_path)
    with progress('localizing', len(jobs)) as advance:
        records, skipped = run_suite(jobs, work, workers, advance)
    for name, reason in skipped.items():
        common.say(f'skipped {name}: {reason}', json_path)
    return records, skipped
