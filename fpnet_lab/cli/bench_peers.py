# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench peers``: the localizer and other ways to a pose, on the same drives."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fpnet_core.cli import common
from fpnet_core.cli.progress import progress
from fpnet_lab.cli import options
from fpnet_lab.cli.reports import write_report


def command(
    limit: Annotated[int, typer.Option('--limit', min=1, help='Drives.')] = 12,
    workers: options.WorkersOption = 1,
    data: Annotated[
        Path, typer.Option('--data', metavar='DIR', help='Real data: radish, mesh_*.')
    ] = Path('../shared/data'),
    work: Annotated[
        Path | None,
        typer.Option('--work', metavar='DIR', help='Keeps finished drives, to go on from.'),
    ] = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Compare the localizer with other ways to a pose, all on the same drives and plans.

    Monte Carlo localisation, correlative search, branch and bound, and the paper's matching with
    RANSAC get the same submaps, odometry and plans; on each drive a plan of another building as
    well. The drives are the first of fpnet bench localization.

    Example: fpnet bench peers --limit 12 --work out/peers --json out/peers.json
    """
    tree = common.load(config, settings, seed)
    from fpnet_lab.evaluation.localization.cases import make_suite, select
    from fpnet_lab.evaluation.localization.peers import COLUMNS, peer_figures, peer_rows
    from fpnet_lab.evaluation.localization.runs import Job
    from fpnet_lab.evaluation.localization.suite import estimated_minutes, run_suite

    cases = select(make_suite(tree.seed), None, limit)
    jobs = [Job(case, tree, tree.seed, data) for case in cases]
    minutes = estimated_minutes(jobs, workers)
    common.say(f'{len(jobs)} drives, about {minutes:.0f} minutes', json_path)
    with progress('localizing', len(jobs)) as advance:
        records, skipped = run_suite(jobs, work, workers, advance)
    peers = peer_figures(records)
    common.show_table(COLUMNS, peer_rows(peers), json_path)
    for name, reason in skipped.items():
        common.say(f'skipped {name}: {reason}', json_path)
    write_report(json_path, {'methods': peers, 'skipped': skipped})
